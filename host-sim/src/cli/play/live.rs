//! Display while a show plays: each new state, and on a terminal the joints with the largest errors. Simulated servos
//! and boards have the same display.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use sinew_firmware::controller::Approach;
use sinew_host_util::command::note;
use sinew_show::Show;

/// Number of joints that are displayed.
const WORST: usize = 6;
/// Time between two updates.
const EVERY: Duration = Duration::from_millis(100);
/// Name of the motion to the show's first pose.
const APPROACH: &str = "going to the show's first pose";
/// Widths of the columns with text. With the columns of numbers, a line has 80 characters.
const NAME: usize = 20;
const LIMITER: usize = 18;

/// State of the whole rig at a moment.
pub(super) struct Moment {
    pub(super) time_s: f64,
    pub(super) state: String,
    /// Whether the rig is playing, and whether the show's clock runs. Until the clock runs, the rig goes to the show's
    /// first pose.
    pub(super) is_playing: bool,
    pub(super) runs: bool,
    /// Way to the show's first pose, if it is known.
    pub(super) approach: Option<Approach>,
    /// Place in the show, s.
    pub(super) show_s: f64,
    /// Mean and largest following error, deg; `None` while torque is off.
    pub(super) errors_deg: Option<[f32; 2]>,
    pub(super) supply_v: Option<f32>,
    pub(super) tick_us: Option<u16>,
}

/// State of a joint at a moment.
#[derive(Clone)]
pub(super) struct Row {
    pub(super) joint: String,
    pub(super) slides: bool,
    /// Difference of commanded and measured position, rad or m.
    pub(super) error: Option<f32>,
    /// Effort, N m or N; `None` while the rig is limp or is lowered.
    pub(super) effort: Option<f32>,
    pub(super) heat_percent: Option<f32>,
    pub(super) celsius: Option<f32>,
    pub(super) limiter: Option<String>,
}

/// The live display of a play.
pub(super) struct Live {
    bar: ProgressBar,
    told: String,
    has_begun: bool,
    shown: Instant,
    show_s: f64,
}

impl Live {
    /// Creates the display of a show.
    pub(super) fn new(show: &Show<'_>) -> Self {
        let style = ProgressStyle::with_template("{msg}").expect("the template is sound");
        let bar = ProgressBar::new_spinner().with_style(style);
        let show_s = f64::from(show.duration_s());
        Self { bar, told: String::new(), has_begun: false, shown: Instant::now(), show_s }
    }

    /// Returns whether standard error is a terminal.
    pub(super) fn is_watched(&self) -> bool {
        !self.bar.is_hidden()
    }

    /// Prints a new state, and updates the table if the update is due.
    pub(super) fn show(&mut self, moment: &Moment, rows: impl FnOnce() -> Vec<Row>) {
        self.has_begun = moment.is_playing && (self.has_begun || moment.runs);
        let is_approach = moment.is_playing && !self.has_begun;
        let label = if is_approach { APPROACH } else { &moment.state };
        if self.told != label {
            label.clone_into(&mut self.told);
            let way = if is_approach { approach_text(moment.approach) } else { String::new() };
            self.tell(format_args!("{:7.2} s  {label}{way}", moment.time_s));
        }
        if self.is_watched() && self.shown.elapsed() >= EVERY {
            self.shown = Instant::now();
            let place = self.has_begun.then_some([moment.show_s, self.show_s]);
            self.bar.set_message(text(moment, label, place, rows()));
        }
    }

    /// Clears the display at the end.
    pub(super) fn end(&self) {
        self.bar.finish_and_clear();
    }

    /// Prints a line above the table.
    pub(super) fn tell(&self, line: std::fmt::Arguments<'_>) {
        self.bar.suspend(|| note(line));
    }
}

/// Describes the way to the first pose. If the show begins at speed, also describes its delay.
fn approach_text(approach: Option<Approach>) -> String {
    let Some(Approach { way_s, late_s }) = approach else { return String::new() };
    let late = if late_s > 0.0 {
        format!(", which it passes at speed: the show begins slowly and is {late_s:.2} s late")
    } else {
        String::new()
    };
    format!(": {way_s:.1} s{late}")
}

/// Returns the table. `place`: place in the show and its length, s.
fn text(moment: &Moment, label: &str, place: Option<[f64; 2]>, mut rows: Vec<Row>) -> String {
    let place = place.map_or_else(String::new, |[at, of]| format!(", show {at:.2} of {of:.2} s"));
    let facts = [
        moment
            .errors_deg
            .map(|[mean, most]| format!("error {mean:.2} deg on average, {most:.2} at most")),
        moment.supply_v.map(|v| format!("supply {v:.2} V")),
        moment.tick_us.map(|us| format!("tick {us} us")),
    ];
    let facts: Vec<String> = facts.into_iter().flatten().collect();
    let mut text = format!(
        "{:7.2} s  {label}{place}\n  {}\n  {:<NAME$} {:>9} {:>10} {:>6} {:>7}  limited by",
        moment.time_s,
        facts.join("; "),
        "joint",
        "error deg",
        "effort N m",
        "heat %",
        "celsius",
    );
    let size = |row: &Row| row.error.map_or(0.0, f32::abs);
    rows.sort_by(|a, b| size(b).total_cmp(&size(a)));
    rows.iter().take(WORST).for_each(|row| text += &line(row));
    text
}

fn line(row: &Row) -> String {
    let number = |number: Option<f32>, digits: usize| {
        number.map_or_else(String::new, |x| format!("{x:.digits$}"))
    };
    let error = match row.error {
        Some(m) if row.slides => format!("{:.2} mm", 1e3 * m),
        error => number(error.map(f32::to_degrees), 2),
    };
    format!(
        "\n  {:<NAME$} {error:>9} {:>10} {:>6} {:>7}  {}",
        cut(&row.joint, NAME),
        number(row.effort, 3),
        number(row.heat_percent, 0),
        number(row.celsius, 0),
        cut(row.limiter.as_deref().unwrap_or_default(), LIMITER)
    )
}

/// Shortens a text to a width.
fn cut(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    text.chars().take(width - 2).chain("..".chars()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moment() -> Moment {
        Moment {
            time_s: 1234.5,
            state: "playing".to_owned(),
            is_playing: true,
            runs: false,
            approach: None,
            show_s: 0.0,
            errors_deg: Some([123.456, 123.456]),
            supply_v: Some(24.123),
            tick_us: Some(u16::MAX),
        }
    }

    #[test]
    fn a_table_fits_80_columns_and_shows_no_effort_without_torque() {
        let row = Row {
            joint: "a_joint_with_a_very_long_name".to_owned(),
            slides: false,
            error: Some(-3.0),
            effort: Some(-1234.567),
            heat_percent: Some(100.0),
            celsius: Some(-40.0),
            limiter: Some("the largest change of the acceleration".to_owned()),
        };
        let limp = Row { error: None, effort: None, ..row.clone() };
        let text = text(&moment(), APPROACH, Some([1234.5, 1234.5]), vec![limp, row]);
        for line in text.lines() {
            assert!(line.chars().count() <= 80, "{line}");
        }
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[3].contains("-171.89") && lines[3].contains("-1234.567"), "{text}");
        let words: Vec<&str> = lines[4].split_whitespace().collect();
        assert_eq!(words[1..3], ["100", "-40"], "{text}");
    }

    #[test]
    fn the_way_to_the_first_pose_is_no_show() {
        let mut live = Live {
            bar: ProgressBar::hidden(),
            told: String::new(),
            has_begun: false,
            shown: Instant::now(),
            show_s: 1.0,
        };
        live.show(&moment(), Vec::new);
        assert_eq!(live.told, APPROACH);
        live.show(&Moment { runs: true, ..moment() }, Vec::new);
        assert_eq!(live.told, "playing");
        // At the seam of a loop, the show's clock is 0 for a moment.
        live.show(&moment(), Vec::new);
        assert_eq!(live.told, "playing");
        live.show(&Moment { is_playing: false, state: "holding".to_owned(), ..moment() }, Vec::new);
        live.show(&moment(), Vec::new);
        assert_eq!(live.told, APPROACH);
    }
}
