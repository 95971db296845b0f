//! The time of the sound compared with that of the jaw: start, drift, and the clocks of both.

use std::fmt;

/// Share of its way at which an opening jaw counts, and the share below which it counts as closed again.
const OPEN: f64 = 0.5;
const CLOSED: f64 = 0.25;

/// Limits at the start, and of the drift, s. People notice a sound that is 45 ms early or 125 ms late (ITU-R BT.1359).
pub(super) const START_S: f64 = 0.04;
const DRIFT_S: f64 = 0.02;
/// Time before a click in which the machine must not have stopped board or sound, because a page needs it to follow;
/// and a shift that does not count, s.
pub(super) const CALM_S: u32 = 12;
pub(super) const CALM_SHIFT_S: f64 = 0.003;

/// Delay of the sound behind the jaw.
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
    /// Compares times, s: of the jaw, and of the clicks that belong to them.
    pub(super) fn of(pairs: &[(f64, f64)]) -> Self {
        let late = || pairs.iter().map(|(jaw, click)| click - jaw);
        let count = pairs.len() as f64;
        let at = pairs.iter().map(|(jaw, _)| jaw).sum::<f64>() / count;
        let by = late().sum::<f64>() / count;
        let sum = |of: &dyn Fn(f64, f64) -> f64| {
            pairs.iter().zip(late()).map(|((jaw, _), late)| of(jaw - at, late - by)).sum::<f64>()
        };
        let slope = sum(&|t, late| t * late) / sum(&|t, _| t * t);
        let (first, last) = (pairs[0], pairs[pairs.len() - 1]);
        let start_s = first.1 - first.0;
        Self {
            start_s,
            most_s: late().map(|each| (each - start_s).abs()).fold(0.0, f64::max),
            slope_s: slope * (last.0 - first.0),
        }
    }

    /// Returns whether start and drift are within the limits.
    pub(super) fn is_in_time(&self) -> bool {
        self.start_s.abs() < START_S && self.most_s < DRIFT_S && self.slope_s.abs() < DRIFT_S
    }
}

impl fmt::Display for Offsets {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [start, most, slope] = [self.start_s, self.most_s, self.slope_s].map(|s| 1e3 * s);
        write!(
            f,
            "{start:.1} ms at the start, then a change of at most {most:.1} ms, by a line {slope:.1} ms"
        )
    }
}

/// Returns the times at which a jaw opens by half. `positions`: times and positions; the last is that of the closed
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

/// The time of a simulated board, which must run in real time. A machine that is busy executes single ticks late; one
/// that is too busy stops the board, and so shifts its time, which no real board does.
pub(super) struct BoardClock {
    /// Times of the board, and by how much later they were here, s.
    delays: Vec<(f64, f64)>,
}

impl BoardClock {
    /// Takes the times of ticks: of the board, and here.
    pub(super) fn new(ticks: impl Iterator<Item = (f64, f64)>) -> Self {
        Self { delays: ticks.map(|(board_s, here_s)| (board_s, here_s - board_s)).collect() }
    }

    /// Returns the least delay of a tick within half a second of a time of the board.
    fn delay_s(&self, board_s: f64) -> f64 {
        let from = self.delays.partition_point(|(at, _)| *at < board_s - 0.5);
        let near = self.delays[from..].iter().take_while(|(at, _)| *at < board_s + 0.5);
        near.map(|(_, delay)| *delay).fold(f64::MAX, f64::min)
    }

    /// Returns the time here of a time of the board.
    pub(super) fn here_s(&self, board_s: f64) -> f64 {
        board_s + self.delay_s(board_s)
    }

    /// Returns whether the board ran in real time before a time, for the seconds in which a page would still follow a
    /// shift; not before `since_s`.
    pub(super) fn is_calm(&self, board_s: f64, since_s: f64) -> bool {
        let seconds = (0..CALM_S).map(|second| (board_s - f64::from(second)).max(since_s));
        let delays = seconds.map(|at| self.delay_s(at));
        let (low, high) = delays.fold((f64::MAX, f64::MIN), |(a, b), c| (a.min(c), b.max(c)));
        high - low < CALM_SHIFT_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A page that delays the sound by 100 ms, does not correct 0.1 % of speed, or leaves the time once, is found.
    #[test]
    fn a_wrong_page_is_found() {
        let of = |late_s: f64, speed: f64, own: &dyn Fn(u32) -> f64| {
            let pair =
                |second| (f64::from(second), late_s + f64::from(second) / speed + own(second));
            Offsets::of(&(1..600).map(pair).collect::<Vec<_>>())
        };
        let trembling = |second: u32| 0.004 * f64::from(second).sin();
        assert!(of(0.02, 1.0, &trembling).is_in_time());
        assert!(!of(0.1, 1.0, &trembling).is_in_time());
        assert!(!of(-0.05, 1.0, &trembling).is_in_time());
        let fast = of(0.0, 1.001, &|_| 0.0);
        assert!((fast.slope_s + 0.598).abs() < 0.001 && !fast.is_in_time(), "{fast:?}");
        assert!(!of(0.0, 1.0 + 4e-5, &|_| 0.0).is_in_time(), "40 ppm are 24 ms in 10 minutes");
        assert!(!of(0.0, 1.0, &|second| if second == 300 { 0.03 } else { 0.0 }).is_in_time());
    }

    /// A tick that is late changes nothing; a board that was stopped is noticed, and is behind from then on.
    #[test]
    fn a_stopped_board_is_noticed() {
        let here = |tick: u32| {
            let board_s = f64::from(tick) / 100.0;
            let late_s = if tick.is_multiple_of(7) { 0.02 } else { 0.0 };
            let stopped_s = if tick > 2000 { 0.1 } else { 0.0 };
            (board_s, 5.0 + board_s + late_s + stopped_s)
        };
        let clock = BoardClock::new((0..4000).map(here));
        for (board_s, here_s) in [(10.0, 15.0), (35.0, 40.1)] {
            assert!((clock.here_s(board_s) - here_s).abs() < 1e-9 && clock.is_calm(board_s, 0.0));
        }
        assert!(!clock.is_calm(22.0, 0.0) && clock.is_calm(22.0, 21.0));
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
