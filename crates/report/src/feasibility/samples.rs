//! Samples of a performance, packed for the page's script.

use serde::Serialize;
use sinew_retarget::feasibility::{CheckError, Efforts, Instant, Performance};
use sinew_rig::Mechanism;

use crate::traces::{Channel, MOST, pack, spacing};

/// Rate at which the performance is evaluated, Hz.
const LOOK_HZ: f64 = 250.0;

/// Samples of a performance.
#[derive(Debug, Serialize)]
pub(super) struct Samples {
    /// Number of samples.
    pub(super) count: usize,
    /// Time between samples, s.
    pub(super) dt_s: f64,
    /// Joint coordinates at the samples.
    coordinates: Vec<Channel>,
    courses: Traces,
}

/// Traces by dof. A sample is the value farthest from zero among all evaluations near it, which preserves peaks.
#[derive(Debug, Serialize)]
struct Traces {
    speed: Vec<Channel>,
    acceleration: Vec<Channel>,
    effort: Vec<Channel>,
}

impl Samples {
    /// Samples a performance. `dofs` selects dofs by their index in `qd`.
    pub(super) fn of(
        mechanism: &Mechanism,
        performance: &impl Performance,
        dofs: &[usize],
    ) -> Result<Self, CheckError> {
        let coordinates = mechanism.coordinate_count();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative")]
        let looks = (performance.duration_s() * LOOK_HZ).floor() as usize;
        let (looks, every) = spacing(looks, LOOK_HZ, coordinates + 3 * dofs.len(), MOST);
        let count = looks / every + 1;
        let mut rows = vec![vec![0.0; count]; coordinates];
        let mut peaks = [(); 3].map(|()| vec![vec![0.0_f64; count]; dofs.len()]);
        let mut dynamics = Efforts::of(mechanism)?;
        let (mut instant, mut efforts) = (Instant::default(), Vec::new());
        for look in 0..=looks {
            let time_s = look as f64 / LOOK_HZ;
            performance.at(time_s, &mut instant);
            dynamics
                .at(&instant, &mut efforts)
                .map_err(|source| CheckError::Instant { time_s, source })?;
            let sample = ((look + every / 2) / every).min(count - 1);
            for (peaks, now) in peaks.iter_mut().zip([&instant.qd, &instant.qdd, &efforts]) {
                for (course, dof) in peaks.iter_mut().zip(dofs) {
                    let peak = &mut course[sample];
                    if now[*dof].abs() > peak.abs() {
                        *peak = now[*dof];
                    }
                }
            }
            if look.is_multiple_of(every) {
                for (course, now) in rows.iter_mut().zip(&instant.q) {
                    course[look / every] = *now;
                }
            }
        }
        let packed = |courses: &[Vec<f64>]| courses.iter().map(|course| pack(course)).collect();
        let [speed, acceleration, effort] = peaks.each_ref().map(|courses| packed(courses));
        let dt_s = every as f64 / LOOK_HZ;
        let courses = Traces { speed, acceleration, effort };
        Ok(Self { count, dt_s, coordinates: packed(&rows), courses })
    }

    /// Returns the time of the last sample, s.
    pub(super) fn end_s(&self) -> f64 {
        (self.count - 1) as f64 * self.dt_s
    }
}
