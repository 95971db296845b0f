//! Histograms below each other, on a common axis.

use maud::{Markup, html};

use super::axis::Axis;
use super::frame::{Frame, WIDTH, chart, horizontal_axis, vertical_axis};
use super::path::{line, px};

/// Height of a histogram. The next constant is the height of the line above it.
const PANEL: f64 = 120.0;
const LINE: f64 = 24.0;
const KEY: f64 = 20.0;

/// Several histograms of values of common kinds.
#[derive(Debug, Clone, PartialEq)]
pub struct Histograms<'a> {
    pub title: &'a str,
    /// Name of the values, with their unit.
    pub axis: &'a str,
    /// Ends of the axis. The next field is the width of a bin.
    pub range: [f64; 2],
    pub bin: f64,
    /// CSS classes and names of the kinds of values, stacked in this order.
    pub kinds: &'a [(&'a str, &'a str)],
    pub panels: Vec<Panel>,
}

/// One histogram.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    pub title: String,
    /// Values by kind.
    pub values: Vec<Vec<f64>>,
    /// A value for comparison, and its name; `None` draws no line.
    pub mark: Option<(f64, String)>,
}

impl Histograms<'_> {
    pub fn draw(&self) -> Markup {
        let top = if self.kinds.len() > 1 { 28.0 + KEY } else { 28.0 };
        let height = top + (LINE + PANEL) * self.panels.len() as f64 + 40.0;
        let x = Axis::exact(self.range, [44.0, WIDTH - 14.0]);
        let mut left = 10.0;
        let key = self.kinds.iter().map(|(class, label)| {
            let at = left;
            // A letter is about 7 units wide.
            left += 40.0 + 7.0 * label.chars().count() as f64;
            (class, label, at)
        });
        let key: Vec<_> = if self.kinds.len() > 1 { key.collect() } else { Vec::new() };
        chart(
            height,
            self.title,
            &self.description(),
            &html! {
                @for (class, label, left) in key {
                    g class=(class) { rect class="count" x=(px(left)) y="30" width="12" height="12" {} }
                    text class="tick" x=(px(left + 18.0)) y="40" { (label) }
                }
                @for (index, panel) in self.panels.iter().enumerate() {
                    @let bottom = top + (LINE + PANEL) * (index as f64 + 1.0);
                    @let frame = Frame { left: 44.0, top: bottom - PANEL, right: WIDTH - 14.0, bottom };
                    (self.panel(panel, frame, &x, index + 1 == self.panels.len()))
                }
            },
        )
    }

    fn panel(&self, panel: &Panel, frame: Frame, x: &Axis, is_last: bool) -> Markup {
        let bins: Vec<Vec<usize>> = panel.values.iter().map(|values| self.counts(values)).collect();
        let total = |bin: usize| bins.iter().map(|counts| counts[bin]).sum::<usize>();
        let count = bins.first().map_or(0, Vec::len);
        let most = (0..count).map(total).max().unwrap_or(0);
        let y = Axis::from_zero(most as f64, [frame.bottom, frame.top]);
        html! {
            text class="axis-name" x=(px(frame.left)) y=(px(frame.top - 7.0)) { (panel.title) }
            (vertical_axis(frame, &y))
            @if is_last {
                (horizontal_axis(frame, x, self.axis))
            }
            @for bin in 0..count {
                @let left = x.at(self.range[0] + self.bin * bin as f64) + 0.5;
                @let right = x.at(self.range[0] + self.bin * (bin as f64 + 1.0)) - 0.5;
                @for (kind, counts) in bins.iter().enumerate() {
                    @let below: usize = bins[..kind].iter().map(|counts| counts[bin]).sum();
                    @let (low, high) = (y.at(below as f64), y.at((below + counts[bin]) as f64));
                    @if counts[bin] > 0 {
                        g class=(self.kinds[kind].0) {
                            rect class="count" x=(px(left)) y=(px(high)) width=(px(right - left)) height=(px(low - high)) {}
                        }
                    }
                }
            }
            line class="axis" x1=(px(frame.left)) x2=(px(frame.right)) y1=(px(frame.bottom)) y2=(px(frame.bottom)) {}
            @if let Some((value, name)) = &panel.mark {
                @let at = x.at(*value);
                @let (anchor, text) = if at > 0.5 * WIDTH { ("end", at - 5.0) } else { ("start", at + 5.0) };
                g class="reference dashed" { path class="stroke" d=(line([(at, frame.top), (at, frame.bottom)])) {} }
                text class="tick" x=(px(text)) y=(px(frame.top - 7.0)) text-anchor=(anchor) { (name) }
            }
        }
    }

    /// Returns the number of values in every bin. Values beyond the ends count in the outermost bins.
    fn counts(&self, values: &[f64]) -> Vec<usize> {
        let [low, high] = self.range;
        let whole = |x: f64| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "not negative, and few"
            )]
            let whole = x.max(0.0) as usize;
            whole
        };
        let mut counts = vec![0; whole(libm::rint((high - low) / self.bin)).max(1)];
        let last = counts.len() - 1;
        for value in values {
            // A billionth of a bin compensates the rounding of the division.
            counts[whole((value - low) / self.bin + 1e-9).min(last)] += 1;
        }
        counts
    }

    fn description(&self) -> String {
        let panels = self.panels.iter().map(|panel| {
            let count: usize = panel.values.iter().map(Vec::len).sum();
            let mark = panel.mark.as_ref().map_or(String::new(), |(_, name)| format!(", {name}"));
            format!("{}: {count} values{mark}", panel.title)
        });
        panels.collect::<Vec<_>>().join("; ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_in_one_bin() {
        let histograms = Histograms {
            title: "",
            axis: "",
            range: [0.0, 1.0],
            bin: 0.1,
            kinds: &[("local", "")],
            panels: Vec::new(),
        };
        assert_eq!(
            histograms.counts(&[0.0, 0.05, 0.3, 0.95, 1.0, -1.0, 2.0]),
            [3, 0, 0, 1, 0, 0, 0, 0, 0, 3]
        );
    }
}
