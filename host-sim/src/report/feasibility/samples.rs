//! A performance as samples, packed for the page's script.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use sinew_retarget::feasibility::{CheckError, Efforts, Instant, Performance};
use sinew_rig::Mechanism;

/// How often a second the performance is looked at.
const LOOK_HZ: f64 = 250.0;
/// Looks from sample to sample, least and most: 50 samples a second, and 10.
const EVERY: [usize; 2] = [5, 25];
/// The most numbers of a page: 4 MB of it.
const MOST: usize = 1_500_000;

/// A course over time, quantised to 16 bits. Its value is `middle + unit · n`.
#[derive(Debug, Serialize)]
pub(super) struct Channel {
    middle: f64,
    unit: f64,
    /// Little-endian, base64; empty if the course stays at its middle.
    data: String,
}

/// What the page knows of a performance.
#[derive(Debug, Serialize)]
pub(super) struct Samples {
    /// How many there are.
    pub(super) count: usize,
    /// From one to the next, s.
    pub(super) dt_s: f64,
    /// Joint coordinates at the samples.
    coordinates: Vec<Channel>,
    /// By freedom, of all looks next to a sample the one farthest from zero: no peak is lost.
    speed: Vec<Channel>,
    acceleration: Vec<Channel>,
    effort: Vec<Channel>,
}

impl Samples {
    /// Samples of a performance; of the degrees of freedom only those in `freedoms`, by their index in `qd`.
    pub(super) fn of(
        mechanism: &Mechanism,
        performance: &impl Performance,
        freedoms: &[usize],
    ) -> Result<Self, CheckError> {
        let coordinates = mechanism.coordinate_count();
        let (looks, every) =
            spacing(performance.duration_s(), coordinates + 3 * freedoms.len(), MOST);
        let count = looks / every + 1;
        let mut rows = vec![vec![0.0; count]; coordinates];
        let mut peaks = [(); 3].map(|()| vec![vec![0.0_f64; count]; freedoms.len()]);
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
                for (course, freedom) in peaks.iter_mut().zip(freedoms) {
                    let peak = &mut course[sample];
                    if now[*freedom].abs() > peak.abs() {
                        *peak = now[*freedom];
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
        Ok(Self { count, dt_s, coordinates: packed(&rows), speed, acceleration, effort })
    }

    /// Until when they reach, s.
    pub(super) fn end_s(&self) -> f64 {
        (self.count - 1) as f64 * self.dt_s
    }
}

/// How many looks there are after the first, and how many of them from sample to sample, so that samples of `width`
/// numbers are at most `most` numbers: first thinner, then cut.
fn spacing(duration_s: f64, width: usize, most: usize) -> (usize, usize) {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative")]
    let looks = (duration_s * LOOK_HZ).floor() as usize;
    let rows = (most / width.max(1)).max(2);
    let every = looks.div_ceil(rows - 1).clamp(EVERY[0], EVERY[1]);
    (looks.min((rows - 1) * every), every)
}

fn pack(course: &[f64]) -> Channel {
    let least = course.iter().copied().fold(f64::INFINITY, f64::min);
    let most = course.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let middle = f64::midpoint(least, most);
    let unit = (most - least) / 2.0 / f64::from(i16::MAX);
    let mut bytes = Vec::new();
    if unit > 0.0 {
        for x in course {
            #[expect(clippy::cast_possible_truncation, reason = "within the least and the most")]
            let steps = ((x - middle) / unit).round() as i16;
            bytes.extend(steps.to_le_bytes());
        }
    }
    Channel { middle, unit, data: STANDARD.encode(bytes) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_performances_are_thinned_then_cut() {
        // 10 s at 50 Hz.
        assert_eq!(spacing(10.0, 100, MOST), (2500, 5));
        for (duration_s, is_whole) in [(290.0, true), (1200.0, true), (3600.0, false)] {
            let (looks, every) = spacing(duration_s, 100, MOST);
            assert!((looks / every + 1) * 100 <= MOST);
            assert_eq!(looks as f64 / LOOK_HZ >= duration_s - 0.01, is_whole, "{duration_s} s");
        }
    }

    #[test]
    fn a_packed_course_is_itself_within_half_a_step() {
        let course: Vec<f64> = (0..500).map(|i| libm::sin(0.1 * f64::from(i)) - 3.0).collect();
        let channel = pack(&course);
        let bytes = STANDARD.decode(&channel.data).unwrap();
        assert_eq!(bytes.len(), 1000);
        for (two, x) in bytes.as_chunks::<2>().0.iter().zip(&course) {
            let read = channel.middle + channel.unit * f64::from(i16::from_le_bytes(*two));
            assert!((read - x).abs() <= 0.51 * channel.unit, "{read} {x}");
        }
        assert_eq!(pack(&[2.5; 9]).data, "");
    }
}
