//! The keys of one coordinate, and the curve through them.

use super::easing::{Easing, smooth};

/// Share of a joint's limits that a step uses.
const STEP_SHARE: f64 = 0.9;

/// A key of one coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Key {
    /// Time, s.
    pub(super) time_s: f64,
    /// Value, rad or m; a part of a quaternion without unit.
    pub(super) value: f64,
    /// Easing to the next key.
    pub(super) easing: Easing,
    /// Line of the file.
    pub(super) line: u64,
}

/// The keys of one coordinate, at least one, in the order of time.
#[derive(Debug, Clone)]
pub(super) struct Track {
    pub(super) keys: Vec<Key>,
    /// Maximum speed, rad/s or m/s: that of the joint, or a default.
    pub(super) speed: f64,
    /// Maximum acceleration, rad/s² or m/s²; infinite without limit.
    pub(super) acceleration: f64,
}

/// A change between two neighbouring keys that is faster than the joint's maximum speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fast {
    /// Index of the later key.
    pub(super) to: usize,
    /// Mean speed, rad/s or m/s.
    pub(super) speed: f64,
}

impl Track {
    /// Returns the value at a time, s. Before the first key and after the last the value is that of the key.
    pub(super) fn at(&self, time_s: f64) -> f64 {
        let next = self.keys.partition_point(|key| key.time_s <= time_s);
        let Some(to) = self.keys.get(next) else { return self.keys[next - 1].value };
        let Some(from) = next.checked_sub(1).map(|last| self.keys[last]) else { return to.value };
        let (span_s, change) = (to.time_s - from.time_s, to.value - from.value);
        let time = (time_s - from.time_s) / span_s;
        if let Some(share) = from.easing.share(time) {
            return from.value + share * change;
        }
        if from.easing == Easing::Step {
            let moving = (self.step_s(change) / span_s).clamp(1e-9, 1.0);
            return from.value + change * smooth(((time - 1.0) / moving + 1.0).max(0.0));
        }
        let [begin, end] = [self.slope(next - 1, next), self.slope(next, next)];
        // Hermite's cubic: the values and slopes of both ends.
        let rest = 1.0 - time;
        let bend = rest * begin - time * end;
        from.value + change * smooth(time) + span_s * time * rest * bend
    }

    /// Returns the duration that the motion of a step needs, s. The largest speed of `smooth` is 1.5 times its mean
    /// speed; its largest acceleration is 6 times the change divided by the squared duration.
    fn step_s(&self, change: f64) -> f64 {
        let way = change.abs() / STEP_SHARE;
        f64::max(1.5 * way / self.speed, (6.0 * way / self.acceleration).sqrt())
    }

    fn mean_slope(&self, to: usize) -> f64 {
        let [from, to] = [self.keys[to - 1], self.keys[to]];
        (to.value - from.value) / (to.time_s - from.time_s)
    }

    /// Returns the slope at the key `key` of the cubic that ends at the key `to`. If the neighbouring piece is not a
    /// cubic, the slope is that of this piece, limited to three times the cubic's own mean slope. Between two cubics it
    /// is a weighted harmonic mean (Fritsch and Butland, 1984). Both rules keep a cubic between the values of its keys.
    fn slope(&self, key: usize, to: usize) -> f64 {
        if key == 0 || key + 1 == self.keys.len() {
            return 0.0;
        }
        let own = self.mean_slope(to);
        // The neighbour ends at this key, or begins there.
        let (neighbour, end) = if key == to { (key + 1, 0) } else { (key, 1) };
        let other = self.mean_slope(neighbour);
        if own * other <= 0.0 {
            return 0.0;
        }
        if let Some(speeds) = self.keys[neighbour - 1].easing.end_speeds() {
            let slope = other * speeds[end];
            slope.abs().min(3.0 * own.abs()).copysign(own)
        } else {
            let span_s = |to: usize| self.keys[to].time_s - self.keys[to - 1].time_s;
            let [own_s, other_s] = [span_s(to), span_s(neighbour)];
            let (a, b) = (2.0 * other_s + own_s, 2.0 * own_s + other_s);
            (a + b) / (a / own + b / other)
        }
    }

    /// Returns the changes between neighbouring keys whose mean speed is above the limit.
    pub(super) fn too_fast(&self, limit: f64) -> impl Iterator<Item = Fast> {
        (1..self.keys.len())
            .map(|to| Fast { to, speed: self.mean_slope(to).abs() })
            .filter(move |fast| fast.speed > limit)
    }
}
