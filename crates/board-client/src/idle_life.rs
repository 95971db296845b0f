//! Idle life: a loop of poses that a host sends to the board. After an interruption, for example by a show, the loop
//! continues where it was, so that it does not repeat its beginning.

use std::time::Duration;

use crate::Journey;

/// Time in which the loop reaches its pace from standstill.
const RUN_IN_S: f64 = 1.0;

/// A loop of poses, with its place.
#[derive(Debug, Clone)]
pub struct IdleLife {
    /// Poses, one after the other. The last pose is followed by the first.
    rows: Vec<f32>,
    rate_hz: f64,
    /// First coordinate and number of coordinates of each joint.
    blocks: Vec<(usize, usize)>,
    coordinates: usize,
    place_s: f64,
    /// `None` before the first motion.
    phase: Option<Phase>,
}

/// Part of the motion.
#[derive(Debug, Clone)]
enum Phase {
    /// The rig goes to the pose of the loop's place.
    Way(Journey),
    /// The loop runs from a place, s, since a time.
    Runs { from_s: f64, since: Duration },
}

impl IdleLife {
    /// Creates a loop at its beginning. `rows`: its poses, `rate_hz` of them per second; `blocks`: first coordinate and
    /// number of coordinates of each joint. Returns `None` without poses, with poses that do not fit the blocks, or if
    /// the rate is not positive and finite.
    pub fn new(rows: &[Vec<f32>], rate_hz: f64, blocks: &[(usize, usize)]) -> Option<Self> {
        let coordinates = blocks.iter().map(|(first, count)| first + count).max()?;
        let fits = !rows.is_empty() && rows.iter().all(|row| row.len() == coordinates);
        (fits && rate_hz > 0.0 && rate_hz.is_finite()).then(|| Self {
            rows: rows.concat(),
            rate_hz,
            blocks: blocks.to_vec(),
            coordinates,
            place_s: 0.0,
            phase: None,
        })
    }

    /// Returns the duration of a round, s.
    pub fn loop_s(&self) -> f64 {
        (self.rows.len() / self.coordinates) as f64 / self.rate_hz
    }

    /// Returns the place in the loop, s.
    pub fn place_s(&self) -> f64 {
        self.place_s
    }

    /// Begins, or continues after a pause: the rig first goes from a pose to the pose of the loop's place, at
    /// `most_rad_s` at most. There the loop starts softly.
    pub fn begin(&mut self, from: &[f32], most_rad_s: f32, now: Duration) {
        let to = self.pose(self.place_s);
        self.phase = Some(Phase::Way(Journey::new(from, &to, &self.blocks, most_rad_s, now)));
    }

    /// Returns the pose to send now. `commanded`: the pose that the board commands, if it is known. Before
    /// [`Self::begin`], this is the pose of the loop's place.
    pub fn step(&mut self, commanded: Option<&[f32]>, now: Duration) -> Vec<f32> {
        match &self.phase {
            None => {}
            Some(Phase::Way(way)) if !way.is_over(commanded, now) => return way.at(now),
            Some(Phase::Way(_)) => {
                self.phase = Some(Phase::Runs { from_s: self.place_s, since: now });
            }
            Some(Phase::Runs { from_s, since }) => {
                let run_s = now.saturating_sub(*since).as_secs_f64();
                self.place_s = (from_s + run(run_s)).rem_euclid(self.loop_s());
            }
        }
        self.pose(self.place_s)
    }

    /// Returns the pose at a place, s: linear between two poses.
    fn pose(&self, place_s: f64) -> Vec<f32> {
        let count = self.rows.len() / self.coordinates;
        let at = place_s * self.rate_hz;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "within the loop"
        )]
        let row = (at.floor() as usize).min(count - 1);
        #[expect(clippy::cast_possible_truncation, reason = "from 0 to 1")]
        let part = (at - row as f64).clamp(0.0, 1.0) as f32;
        let row_at = |row: usize| &self.rows[row * self.coordinates..][..self.coordinates];
        let (from, to) = (row_at(row), row_at((row + 1) % count));
        let mut q: Vec<f32> = from.iter().zip(to).map(|(a, b)| a + part * (b - a)).collect();
        for (first, _) in self.blocks.iter().filter(|(_, count)| *count == 4) {
            // A rotation: both signs of a quaternion are the same rotation, and its length must stay 1.
            let own = *first..first + 4;
            let dot: f32 = own.clone().map(|k| from[k] * to[k]).sum();
            if dot < 0.0 {
                own.clone().for_each(|k| q[k] = from[k] - part * (from[k] + to[k]));
            }
            let length = own.clone().map(|k| q[k] * q[k]).sum::<f32>().sqrt();
            own.for_each(|k| q[k] /= length);
        }
        q
    }
}

/// Returns the time in the loop after a time of running, s. The pace increases smoothly from 0 to 1.
fn run(run_s: f64) -> f64 {
    let share = (run_s / RUN_IN_S).min(1.0);
    let run_in_s = RUN_IN_S * (share.powi(3) - 0.5 * share.powi(4));
    run_in_s + (run_s - RUN_IN_S).max(0.0)
}

#[cfg(test)]
#[expect(clippy::expect_used, reason = "a test may fail by panicking")]
mod tests {
    use super::*;

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    /// A loop of 2 s: a hinge that goes up and down, and a ball that turns.
    fn idle() -> IdleLife {
        let row = |k: u8| {
            let (sin, cos) = (0.1 * f32::from(k)).sin_cos();
            vec![f32::from(k.min(20 - k)) / 10.0, sin, 0.0, 0.0, cos]
        };
        let rows: Vec<Vec<f32>> = (0..20).map(row).collect();
        IdleLife::new(&rows, 10.0, &[(0, 1), (1, 4)]).expect("poses that fit")
    }

    #[test]
    fn it_goes_to_its_place_starts_softly_and_continues_where_it_was() {
        let mut idle = idle();
        let there = idle.step(None, ms(0));
        let mut away = there.clone();
        away[0] = 0.3;
        idle.begin(&away, 0.3, ms(0));
        let mut before = idle.step(Some(&away), ms(0));
        assert!((before[0] - 0.3).abs() < 1e-6);
        let (mut time_ms, mut step) = (0, 0.0_f32);
        while idle.place_s() < 1.35 {
            time_ms += 10;
            // The board commands the pose of the last message.
            let pose = idle.step(Some(&before), ms(time_ms));
            step = step.max((pose[0] - before[0]).abs());
            let length: f32 = pose[1..].iter().map(|x| x * x).sum();
            assert!((length - 1.0).abs() < 1e-5);
            before = pose;
        }
        // The hinge moves 1 per second in the loop, and on its way there at 0.3 per second at most.
        assert!((0.0099..0.0102).contains(&step), "{step}");
        let (place_s, pose) = (idle.place_s(), before);
        idle.begin(&there, 0.3, ms(60_000));
        assert!((idle.step(Some(&there), ms(60_000))[0] - there[0]).abs() < 1e-6);
        assert!((idle.step(Some(&pose), ms(80_000))[0] - pose[0]).abs() < 1e-6);
        assert!((idle.step(Some(&pose), ms(80_500))[0] - pose[0]).abs() < 0.2);
        assert!(idle.place_s() > place_s && idle.place_s() < place_s + 0.2);
    }

    #[test]
    fn a_round_is_followed_by_the_next() {
        let mut idle = idle();
        assert!((idle.loop_s() - 2.0).abs() < 1e-9);
        let first = idle.step(None, ms(0));
        idle.begin(&first, 1.0, ms(0));
        for time_ms in [100, 110, 2605, 2615] {
            idle.step(Some(&first), ms(time_ms));
        }
        // 0.5 s are the cost of the soft start.
        assert!((0.0..0.02).contains(&idle.place_s()), "{}", idle.place_s());
    }

    #[test]
    fn poses_that_do_not_fit_are_refused() {
        assert!(IdleLife::new(&[], 100.0, &[(0, 1)]).is_none());
        assert!(IdleLife::new(&[vec![0.0, 0.0]], 100.0, &[(0, 1)]).is_none());
        for rate_hz in [0.0, f64::NAN, f64::INFINITY] {
            assert!(IdleLife::new(&[vec![0.0]], rate_hz, &[(0, 1)]).is_none());
        }
        assert!(IdleLife::new(&[vec![0.0]], 100.0, &[]).is_none());
    }
}
