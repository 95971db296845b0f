//! Traces over time, thinned and packed for a page's script: see `assets/traces.js`.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;

/// Minimum and maximum number of samples per second on a page.
pub(super) const SAMPLES_HZ: [f64; 2] = [10.0, 50.0];
/// Maximum number of values on a page, which take 4 MB.
pub(super) const MOST: usize = 1_500_000;
/// Code of an unknown value.
const UNKNOWN: i16 = i16::MIN;

/// A trace over time, quantised to 16 bits. A sample n represents the value `middle + unit · n`.
#[derive(Debug, Serialize)]
pub(super) struct Channel {
    middle: f64,
    unit: f64,
    /// Samples as i16, little-endian, base64; empty if the trace is constant.
    data: String,
}

/// Returns how many readings a page uses after the first reading, and the number of readings per sample. There are
/// `looks` readings after the first one, at `look_hz`. A sample has `width` numbers, and all samples at most `most`
/// numbers in total: readings are thinned first, then the end is cut.
pub(super) fn spacing(looks: usize, look_hz: f64, width: usize, most: usize) -> (usize, usize) {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative")]
    let [thin, fine] = SAMPLES_HZ.map(|hz| ((look_hz / hz).round() as usize).max(1));
    let rows = (most / width.max(1)).max(2);
    let every = looks.div_ceil(rows - 1).clamp(fine, thin);
    (looks.min((rows - 1) * every), every)
}

/// Packs a trace. A number that is not finite becomes an unknown value.
pub(super) fn pack(course: &[f64]) -> Channel {
    let known = || course.iter().copied().filter(|x| x.is_finite());
    let least = known().fold(f64::INFINITY, f64::min);
    let most = known().fold(f64::NEG_INFINITY, f64::max);
    let middle = if least <= most { f64::midpoint(least, most) } else { 0.0 };
    let unit = if most > least { (most - least) / 2.0 / f64::from(i16::MAX) } else { 0.0 };
    let is_flat = unit == 0.0 && known().count() == course.len();
    let mut bytes = Vec::new();
    if !is_flat {
        for x in course {
            #[expect(clippy::cast_possible_truncation, reason = "within the least and the most")]
            let steps = match x.is_finite() {
                true if unit > 0.0 => ((x - middle) / unit).round() as i16,
                true => 0,
                false => UNKNOWN,
            };
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
        assert_eq!(spacing(2500, 250.0, 100, MOST), (2500, 5));
        for (looks, is_whole) in [(72_500, true), (300_000, true), (900_000, false)] {
            let (taken, every) = spacing(looks, 250.0, 100, MOST);
            assert!((taken / every + 1) * 100 <= MOST);
            assert_eq!(taken == looks, is_whole, "{looks}");
        }
        // Below the page's minimum rate: each reading is a sample.
        assert_eq!(spacing(90, 9.0, 100, MOST), (90, 1));
    }

    #[test]
    fn a_packed_course_is_itself_within_half_a_step() {
        let mut course: Vec<f64> = (0..500).map(|i| libm::sin(0.1 * f64::from(i)) - 3.0).collect();
        course[7] = f64::NAN;
        let channel = pack(&course);
        let bytes = STANDARD.decode(&channel.data).unwrap();
        assert_eq!(bytes.len(), 1000);
        for (two, x) in bytes.as_chunks::<2>().0.iter().zip(&course) {
            let steps = i16::from_le_bytes(*two);
            let read = channel.middle + channel.unit * f64::from(steps);
            assert_eq!(steps == UNKNOWN, x.is_nan());
            assert!(x.is_nan() || (read - x).abs() <= 0.51 * channel.unit, "{read} {x}");
        }
        assert_eq!(pack(&[2.5; 9]).data, "");
        let gap = pack(&[2.5, f64::NAN]);
        assert_eq!(
            (gap.middle.to_bits(), gap.data),
            (2.5_f64.to_bits(), STANDARD.encode([0, 0, 0, 128]))
        );
    }
}
