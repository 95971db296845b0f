//! The time of the sound compared with that of the jaw: start, drift, and the clocks of both.

/// Share of its way at which an opening jaw counts, and the share below which it counts as closed again.
const OPEN: f64 = 0.5;
const CLOSED: f64 = 0.25;

/// How far the sound is behind the jaw.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::struct_field_names, reason = "the unit of each is s")]
pub(super) struct Offsets {
    /// At the first click, s.
    pub(super) start_s: f64,
    /// Largest change since the first click, s.
    pub(super) most_s: f64,
    /// Change over the whole time by a straight line through all clicks, s.
    pub(super) slope_s: f64,
}

impl Offsets {
    /// Compares times of clicks with times of the jaw, s.
    pub(super) fn of(clicks: &[f64], jaw: &[f64]) -> Self {
        assert_eq!(clicks.len(), jaw.len(), "clicks, and openings of the jaw");
        let late: Vec<f64> = clicks.iter().zip(jaw).map(|(click, jaw)| click - jaw).collect();
        let count = late.len() as f64;
        let mean = |of: &[f64]| of.iter().sum::<f64>() / count;
        let (at, by) = (mean(jaw), mean(&late));
        let sum = |of: &dyn Fn(f64, f64) -> f64| {
            jaw.iter().zip(&late).map(|(t, late)| of(t - at, late - by)).sum::<f64>()
        };
        let slope = sum(&|t, late| t * late) / sum(&|t, _| t * t);
        Self {
            start_s: late[0],
            most_s: late.iter().map(|each| (each - late[0]).abs()).fold(0.0, f64::max),
            slope_s: slope * (jaw[jaw.len() - 1] - jaw[0]),
        }
    }

    /// Returns whether the limits of a show with a sound are kept: 40 ms at the start, 20 ms of drift.
    pub(super) fn is_in_time(&self) -> bool {
        self.start_s.abs() < 0.04 && self.most_s < 0.02 && self.slope_s.abs() < 0.02
    }
}

/// Returns the times at which a jaw opens by half: `positions` are times and positions; the last is that of the closed
/// jaw. The way from closed to open is the whole range of the positions.
pub(super) fn openings(positions: &[(f64, f64)]) -> Vec<f64> {
    let all = || positions.iter().map(|(_, position)| *position);
    let (least, most) = (all().fold(f64::MAX, f64::min), all().fold(f64::MIN, f64::max));
    let last = positions[positions.len() - 1].1;
    let (closed, open) = if last - least < most - last { (least, most) } else { (most, least) };
    let share = |position: f64| (position - closed) / (open - closed);
    let (mut was_closed, mut times) = (true, Vec::new());
    for pair in positions.windows(2) {
        let [(from_s, from), (to_s, to)] = [pair[0], pair[1]].map(|(at, q)| (at, share(q)));
        was_closed |= from < CLOSED;
        if was_closed && to >= OPEN {
            was_closed = false;
            times.push(from_s + (to_s - from_s) * (OPEN - from) / (to - from));
        }
    }
    times
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns times of clicks: at the times of the jaw, later, at another speed, and with a deviation of their own.
    fn clicks(jaw: &[f64], late_s: f64, speed: f64, own: impl Fn(usize) -> f64) -> Vec<f64> {
        let late = |(index, at): (usize, &f64)| late_s + at / speed + own(index);
        jaw.iter().enumerate().map(late).collect()
    }

    /// A page that delays the sound by 100 ms, does not correct 0.1 % of speed, or leaves the time once, is found.
    #[test]
    fn a_wrong_page_is_found() {
        let jaw: Vec<f64> = (1..600).map(f64::from).collect();
        let of = |late_s, speed, own: &dyn Fn(usize) -> f64| {
            Offsets::of(&clicks(&jaw, late_s, speed, own), &jaw)
        };
        let trembling = |index: usize| 0.004 * (index as f64).sin();
        assert!(of(0.02, 1.0, &trembling).is_in_time());
        assert!(!of(0.1, 1.0, &trembling).is_in_time());
        assert!(!of(-0.05, 1.0, &trembling).is_in_time());
        let fast = of(0.0, 1.001, &|_| 0.0);
        assert!((fast.slope_s + 0.598).abs() < 0.001 && !fast.is_in_time(), "{fast:?}");
        assert!(!of(0.0, 1.0 + 4e-5, &|_| 0.0).is_in_time(), "40 ppm are 24 ms in 10 minutes");
        assert!(!of(0.0, 1.0, &|index| if index == 300 { 0.03 } else { 0.0 }).is_in_time());
    }

    #[test]
    fn a_jaw_opens_where_its_way_is_half_over() {
        let at = |index: u32| f64::from(index) / 100.0;
        // Opens downwards from 0.8 s to 1.2 s, trembles, and closes.
        let position = |t: f64| match t % 2.0 {
            t if t < 0.8 => -0.1,
            t if t < 1.2 => -0.1 - (t - 0.8),
            t if t < 1.6 => -0.5 + 0.02 * (t * 100.0).sin(),
            _ => -0.1,
        };
        let positions: Vec<_> = (0..1000).map(|index| (at(index), position(at(index)))).collect();
        let times = openings(&positions);
        assert_eq!(times.len(), 5);
        for (time, index) in times.iter().zip(0..) {
            // Trembling makes the way 5 % longer.
            assert!((time - (1.0 + 2.0 * f64::from(index))).abs() < 0.015, "{time}");
        }
    }
}
