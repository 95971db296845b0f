//! Display while a show plays: states as they change, and on a terminal the joints with the largest errors.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use sinew_firmware::controller::Approach;
use sinew_firmware::supervisor::{Moving, State};
use sinew_host_util::command::note;
use sinew_performance::play::SimulatedRig;
use sinew_servo_sim::plant::RigPlant;
use sinew_show::Show;

/// Number of joints that are shown.
const WORST: usize = 6;
/// Time between two updates.
const EVERY: Duration = Duration::from_millis(100);

/// The live display of a play.
pub(super) struct Live {
    bar: ProgressBar,
    state: Option<State>,
    has_waited: bool,
    has_begun: bool,
    shown: Instant,
    show_s: f64,
    is_loop: bool,
    ran: u64,
}

impl Live {
    /// Creates the display of a show.
    pub(super) fn new(show: &Show<'_>) -> Self {
        let style = ProgressStyle::with_template("{msg}").expect("the template is sound");
        let bar = ProgressBar::new_spinner().with_style(style);
        let (show_s, is_loop) = (f64::from(show.duration_s()), show.is_loop());
        Self {
            bar,
            state: None,
            has_waited: false,
            has_begun: false,
            shown: Instant::now(),
            show_s,
            is_loop,
            ran: 0,
        }
    }

    /// Updates the display after a tick. `waits_for`: the joint that must come to rest before the rig can be armed.
    pub(super) fn show(&mut self, sim: &SimulatedRig<'_, RigPlant>, waits_for: Option<Moving>) {
        let report = sim.report();
        self.ran += u64::from(sim.permission().runs);
        if self.state != Some(report.state) {
            self.state = Some(report.state);
            self.tell(format_args!("{:7.2} s  {}", sim.time_s(), report.state));
            if report.state == State::Playing
                && let Some(approach) = sim.approach()
            {
                self.tell(format_args!("{:7.2} s  {}", sim.time_s(), approach_text(approach)));
            }
        }
        if sim.runs() && !std::mem::replace(&mut self.has_begun, true) {
            self.tell(format_args!("{:7.2} s  the show begins", sim.time_s()));
        }
        if let Some(moving) = waits_for
            && !std::mem::replace(&mut self.has_waited, true)
        {
            let [now, most] = moving.rad_s();
            self.tell(format_args!(
                "{:7.2} s  waits until the rig rests: {} at {now:.2} rad/s, at most {most:.2}",
                sim.time_s(),
                sim.parts.names[usize::from(moving.dof)],
            ));
        }
        for fault in report.raised.iter() {
            self.tell(format_args!("{:7.2} s  {fault}", sim.time_s()));
        }
        if !self.bar.is_hidden() && self.shown.elapsed() >= EVERY {
            self.shown = Instant::now();
            self.bar.set_message(self.lines(sim));
        }
    }

    /// Clears the display at the end.
    pub(super) fn end(&self) {
        self.bar.finish_and_clear();
    }

    fn tell(&self, line: std::fmt::Arguments<'_>) {
        self.bar.suspend(|| note(line));
    }

    fn lines(&self, sim: &SimulatedRig<'_, RigPlant>) -> String {
        let (report, parts) = (sim.report(), sim.parts);
        let played_s = self.ran as f64 / f64::from(parts.rate_hz);
        let played_s =
            if self.is_loop { played_s % self.show_s } else { played_s.min(self.show_s) };
        let error = report.following.map_or_else(String::new, |error| {
            let [mean, most] = [error.mean_rad, error.most_rad].map(f32::to_degrees);
            format!(", error {mean:.2} deg on average, {most:.2} at most")
        });
        let mut text = format!(
            "{:7.2} s  {}, tick {}, show {played_s:.2} of {:.2} s{error}\n  \
             {:<20} {:>9} {:>10} {:>9} {:>7}  limited by",
            sim.time_s(),
            report.state,
            sim.ticks(),
            self.show_s,
            "joint",
            "error deg",
            "effort N m",
            "current A",
            "celsius"
        );
        let mut worst: Vec<usize> =
            (0..parts.names.len()).filter(|joint| parts.drives[*joint].is_some()).collect();
        // For servos that report nothing, the error of the simulated rig is used.
        let simulated = sim.simulated_errors();
        let error = |joint: usize| {
            if parts.tells_nothing(joint) { simulated[joint] } else { report.dofs[joint].error }
        };
        let size = |joint: &usize| error(*joint).abs();
        worst.sort_by(|a, b| size(b).total_cmp(&size(a)));
        for joint in worst.into_iter().take(WORST) {
            text += &line(sim, joint, error(joint));
        }
        text
    }
}

/// Describes the beginning of a show.
pub(super) fn approach_text(approach: Approach) -> String {
    let Approach { way_s, late_s } = approach;
    let late = if late_s > 0.0 {
        format!(", which it passes at speed: the show begins slowly and is {late_s:.2} s late")
    } else {
        String::new()
    };
    format!("goes to the first pose: {way_s:.1} s{late}")
}

fn line(sim: &SimulatedRig<'_, RigPlant>, joint: usize, error: f32) -> String {
    let parts = sim.parts;
    let dof = sim.report().dofs[joint];
    let servo = parts.first_servo[joint].unwrap_or_default();
    let told = &sim.report().servos[servo];
    let number = |number: Option<f32>, digits: usize| {
        number.map_or_else(String::new, |x| format!("{x:.digits$}"))
    };
    format!(
        "\n  {:<20} {:>9.2} {:>10.3} {:>9} {:>7}  {}",
        parts.names[joint],
        error.to_degrees(),
        dof.effort,
        number(sim.current_a(servo), 2),
        number(told.temperature_c, 0),
        sim.limiter(joint).unwrap_or_default()
    )
}
