//! Measures how still a rig stands: poses that are held, and statistics of the ticks within a window.

use sinew_retarget::feasibility::RigMotion;

use super::run::{Run, Sample};

/// Time between rows of a motion, s.
const DT_S: f64 = 0.01;
/// Time for which each pose is held, s.
const HOLD_S: f64 = 5.0;
/// Part of that time that is measured, s: the rig has settled, and does not yet move on.
const WINDOW_S: [f64; 2] = [1.5, 4.8];
/// Largest speed between poses, rad/s, and least time between poses, s.
const MOST_RAD_S: f64 = 0.872_664_6;
const LEAST_S: f64 = 1.0;
/// Time over which speeds are measured, s.
const SPEED_S: f64 = 0.01;

/// Six poses of an arm with six joints, deg.
pub(super) const POSES_DEG: [[f64; 6]; 6] = [
    [0.0, 20.0, 20.0, 0.0, 20.0, 20.0],
    [0.0, 60.0, 20.0, 0.0, 20.0, 20.0],
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [40.0, -50.0, -30.0, 30.0, -20.0, -20.0],
    [0.0, 90.0, 0.0, 0.0, 0.0, 0.0],
    [-40.0, 30.0, 60.0, -40.0, 30.0, 10.0],
];

/// Poses that are held one after the other.
pub(super) struct Poses {
    pub(super) motion: RigMotion,
    /// Begin and end of each pose's window, s of the motion.
    pub(super) windows_s: Vec<[f64; 2]>,
}

impl Poses {
    /// Returns the poses of an arm with six joints.
    pub(super) fn of_arm() -> Self {
        Self::of(&POSES_DEG.map(|pose| pose.map(f64::to_radians).to_vec()))
    }

    /// Returns poses with minimum-jerk motions between them.
    pub(super) fn of(poses: &[Vec<f64>]) -> Self {
        let rows_in = |time_s: f64| {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "rows")]
            let rows = (time_s / DT_S).round() as usize;
            rows
        };
        let (mut rows, mut windows_s) = (Vec::new(), Vec::new());
        let mut last = &poses[0];
        for (number, pose) in poses.iter().enumerate() {
            if number > 0 {
                let far = pose.iter().zip(last).map(|(to, from)| (to - from).abs());
                let way_s = far.fold(0.0, f64::max) * 1.875 / MOST_RAD_S;
                let steps = rows_in(way_s.max(LEAST_S));
                for step in 1..=steps {
                    let s = step as f64 / steps as f64;
                    let share = s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s);
                    let row = pose.iter().zip(last).map(|(to, from)| from + (to - from) * share);
                    rows.push(row.collect());
                }
            }
            let at_s = rows.len() as f64 * DT_S;
            windows_s.push(WINDOW_S.map(|time_s| at_s + time_s));
            rows.extend(std::iter::repeat_n(pose.clone(), rows_in(HOLD_S)));
            last = pose;
        }
        Self { motion: RigMotion { dt_s: DT_S, rows }, windows_s }
    }
}

/// Stillness of a dof within a window, in deg and A.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Stillness {
    pub(super) peak_to_peak_deg: f64,
    pub(super) speed_deg_s: f64,
    pub(super) offset_deg: f64,
    pub(super) alternating_a: f64,
}

impl Stillness {
    pub(super) fn of(samples: &[Sample], rate_hz: f64) -> Self {
        let count = samples.len() as f64;
        let mean = |of: &dyn Fn(&Sample) -> f64| samples.iter().map(of).sum::<f64>() / count;
        let offset = mean(&|sample| sample.measured - sample.commanded);
        let mean_a = mean(&|sample| sample.current_a);
        let alternating = mean(&|sample| (sample.current_a - mean_a).powi(2)).sqrt();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "ticks")]
        let apart = (SPEED_S * rate_hz).round().max(1.0) as usize;
        let over_s = apart as f64 / rate_hz;
        let speeds = samples.iter().zip(&samples[apart..]);
        let squares = speeds.map(|(a, b)| ((b.measured - a.measured) / over_s).powi(2));
        let speed = (squares.sum::<f64>() / (samples.len() - apart) as f64).sqrt();
        Self {
            peak_to_peak_deg: peak_to_peak(samples).to_degrees(),
            speed_deg_s: speed.to_degrees(),
            offset_deg: offset.abs().to_degrees(),
            alternating_a: alternating,
        }
    }

    /// Returns the larger of each number.
    pub(super) fn max(self, other: Self) -> Self {
        Self {
            peak_to_peak_deg: self.peak_to_peak_deg.max(other.peak_to_peak_deg),
            speed_deg_s: self.speed_deg_s.max(other.speed_deg_s),
            offset_deg: self.offset_deg.max(other.offset_deg),
            alternating_a: self.alternating_a.max(other.alternating_a),
        }
    }
}

/// Returns the largest minus the smallest position, rad.
pub(super) fn peak_to_peak(samples: &[Sample]) -> f64 {
    let ends = samples.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], sample| {
        [least.min(sample.measured), most.max(sample.measured)]
    });
    ends[1] - ends[0]
}

impl Run {
    /// Returns the ticks of a dof within a window.
    pub(super) fn window(&self, dof: usize, window_s: [f64; 2]) -> &[Sample] {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "ticks")]
        let [from, to] = window_s.map(|time_s| (time_s * self.rate_hz).round() as usize);
        &self.samples[dof][from..to]
    }

    /// Returns the stillness by window and dof.
    pub(super) fn stillness(&self, windows_s: &[[f64; 2]]) -> Vec<Vec<Stillness>> {
        let of_window = |window: &[f64; 2]| {
            let dofs = 0..self.names.len();
            dofs.map(|dof| Stillness::of(self.window(dof, *window), self.rate_hz)).collect()
        };
        windows_s.iter().map(of_window).collect()
    }
}
