//! Charts of the cluster of each pose of two sequences, for several measures.

use std::ops::Range;

use maud::{Markup, html};

use super::frame::{WIDTH, chart};
use super::path::px;

const STRIP: f64 = 13.0;
const GAP: f64 = 4.0;
const LEFT: f64 = 110.0;
/// Space between the two sequences.
const SEAM: f64 = 6.0;

/// Strips of one pair of sequences.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// Names of the two sequences.
    pub names: [String; 2],
    /// Number of poses of the first sequence.
    pub first: usize,
    /// Strips: label, cluster of every pose of both sequences, and the text after the strip.
    pub strips: Vec<(String, Vec<usize>, String)>,
}

/// CSS classes of the two clusters' colours.
const CLASSES: [&str; 2] = ["local", "world"];

/// Draws pairs below each other.
pub fn strips(title: &str, pairs: &[Pair]) -> Markup {
    let heights = pairs.iter().map(|pair| 34.0 + (STRIP + GAP) * pair.strips.len() as f64);
    let tops: Vec<f64> = heights
        .clone()
        .scan(28.0, |top, height| {
            let own = *top;
            *top += height;
            Some(own)
        })
        .collect();
    let height = 60.0 + heights.sum::<f64>();
    let texts = pairs.iter().flat_map(|pair| {
        pair.strips.iter().map(move |(label, _, behind)| {
            format!("{} and {} by {label}: {behind}", pair.names[0], pair.names[1])
        })
    });
    chart(
        height,
        title,
        &texts.collect::<Vec<_>>().join("; "),
        &html! {
            @for (pair, top) in pairs.iter().zip(&tops) {
                @let poses = pair.strips.first().map_or(1, |strip| strip.1.len());
                @let width = (WIDTH - LEFT - SEAM - 62.0) / poses as f64;
                @let at = |pose: usize| LEFT + width * pose as f64 + if pose < pair.first { 0.0 } else { SEAM };
                text class="tick" x=(px(LEFT)) y=(px(top + 20.0)) { (pair.names[0]) }
                text class="tick" x=(px(at(pair.first))) y=(px(top + 20.0)) { (pair.names[1]) }
                @for (index, (label, of, behind)) in pair.strips.iter().enumerate() {
                    @let y = top + 27.0 + (STRIP + GAP) * index as f64;
                    text class="tick" x=(px(LEFT - 8.0)) y=(px(y + 11.0)) text-anchor="end" { (label) }
                    @for run in runs(of, pair.first) {
                        g class=(CLASSES[of[run.start] % 2]) {
                            rect stroke="none" x=(px(at(run.start))) y=(px(y)) width=(px(width * run.len() as f64)) height=(px(STRIP)) {}
                        }
                    }
                    text class="tick" x=(px(WIDTH - 8.0)) y=(px(y + 11.0)) text-anchor="end" { (behind) }
                }
            }
            text class="axis-name" x=(px(WIDTH - 8.0)) y=(px(height - 12.0)) text-anchor="end" {
                "pose by pose, in the colours of both clusters; behind: in their sequence's"
            }
        },
    )
}

/// Returns the runs of consecutive poses in one cluster and one sequence. `first` is the number of poses of the
/// first sequence.
fn runs(of: &[usize], first: usize) -> Vec<Range<usize>> {
    let is_seam = |pose: &usize| *pose == first || of[*pose - 1] != of[*pose];
    let starts: Vec<usize> = std::iter::once(0).chain((1..of.len()).filter(is_seam)).collect();
    let ends = starts.iter().skip(1).copied().chain([of.len()]);
    starts.iter().copied().zip(ends).map(|(start, end)| start..end).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_end_where_the_sequence_does() {
        assert_eq!(runs(&[0, 0, 1, 1, 1], 3), [0..2, 2..3, 3..5]);
        assert_eq!(runs(&[0, 0], 1), [0..1, 1..2]);
    }
}
