//! Smooth tracks of quantities over time, through timed keys.

use glam::DVec3;

/// Recorded frames per second. The pipeline resamples to 100.
pub(super) const RATE_HZ: f64 = 120.0;

/// A smooth function of time through keys.
///
/// Each span is the quintic polynomial that has the position and speed of both of its keys and zero acceleration
/// there: the minimum-jerk movement between them (Flash and Hogan 1985). The whole track is twice differentiable.
/// The speed at an inner key is the harmonic mean of the neighbouring slopes (Fritsch and Butland 1984): a track
/// never overshoots its keys, and it stops where it turns. The value is constant before the first key and after
/// the last, and zero without keys.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Track {
    keys: Vec<Key>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Key {
    time_s: f64,
    value: f64,
    speed: f64,
}

impl Track {
    /// Creates the track through `(time in seconds, value)`, times strictly rising.
    pub(super) fn new(points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let mut keys: Vec<Key> =
            points.into_iter().map(|(time_s, value)| Key { time_s, value, speed: 0.0 }).collect();
        for i in 1..keys.len().saturating_sub(1) {
            keys[i].speed = inner_speed(slope(keys[i - 1], keys[i]), slope(keys[i], keys[i + 1]));
        }
        Self { keys }
    }

    /// Returns the value at a time. Before and after the movement, which is most of a clip, no search is needed.
    #[inline]
    pub(super) fn at(&self, time_s: f64) -> f64 {
        let [first, .., last] = self.keys.as_slice() else {
            return self.keys.first().map_or(0.0, |key| key.value);
        };
        if time_s < first.time_s {
            first.value
        } else if time_s >= last.time_s {
            last.value
        } else {
            self.between_keys(time_s)
        }
    }

    fn between_keys(&self, time_s: f64) -> f64 {
        let next = self.keys.partition_point(|key| key.time_s <= time_s);
        quintic(self.keys[next - 1], self.keys[next], time_s)
    }
}

fn slope(from: Key, to: Key) -> f64 {
    debug_assert!(from.time_s < to.time_s, "keys out of order: {from:?}, {to:?}");
    (to.value - from.value) / (to.time_s - from.time_s)
}

/// Returns the speed at an inner key: zero at a turn, and at most twice the smaller slope. A quintic without end
/// accelerations is monotone up to 15/7 of its mean slope at both ends.
fn inner_speed(before: f64, after: f64) -> f64 {
    if before * after <= 0.0 { 0.0 } else { 2.0 * before * after / (before + after) }
}

fn quintic(from: Key, to: Key, time_s: f64) -> f64 {
    let span = to.time_s - from.time_s;
    let u = (time_s - from.time_s) / span;
    let (u3, u4, u5) = (u * u * u, u * u * u * u, u * u * u * u * u);
    let rise = 10.0 * u3 - 15.0 * u4 + 6.0 * u5;
    let leave = u - 6.0 * u3 + 8.0 * u4 - 3.0 * u5;
    let arrive = -4.0 * u3 + 7.0 * u4 - 3.0 * u5;
    from.value + (to.value - from.value) * rise + span * (from.speed * leave + to.speed * arrive)
}

/// Three tracks, one per axis.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Track3 {
    axes: [Track; 3],
}

impl Track3 {
    /// Creates the track through `(time in seconds, value)`, times strictly rising.
    pub(super) fn new(points: impl IntoIterator<Item = (f64, DVec3)>) -> Self {
        let points: Vec<(f64, DVec3)> = points.into_iter().collect();
        let axis =
            |axis: usize| Track::new(points.iter().map(|&(time_s, value)| (time_s, value[axis])));
        Self { axes: [axis(0), axis(1), axis(2)] }
    }

    /// Returns the value at a time.
    #[inline]
    pub(super) fn at(&self, time_s: f64) -> DVec3 {
        let [x, y, z] = &self.axes;
        DVec3::new(x.at(time_s), y.at(time_s), z.at(time_s))
    }
}

/// Times at which a movement leaves the guard, passes its keys, and is back in guard.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Beats {
    /// The start, one time per key, and the end, in seconds from the clip's start.
    times_s: Vec<f64>,
}

impl Beats {
    /// Creates the times of a movement from `start_s` to `end_s` through keys at `keys_s`.
    pub(super) fn new(start_s: f64, keys_s: impl IntoIterator<Item = f64>, end_s: f64) -> Self {
        Self { times_s: core::iter::once(start_s).chain(keys_s).chain([end_s]).collect() }
    }

    /// Returns the times of the same movement, earlier by `lead_s`: a proximal segment moves before the distal
    /// segments.
    pub(super) fn ahead_by(&self, lead_s: f64) -> Self {
        Self { times_s: self.times_s.iter().map(|time_s| time_s - lead_s).collect() }
    }

    /// Returns the times of the keys, without start and end.
    pub(super) fn keys_s(&self) -> &[f64] {
        &self.times_s[1..self.times_s.len() - 1]
    }

    /// Creates a track that is zero at both ends and has `values` at the keys.
    pub(super) fn track(&self, values: impl IntoIterator<Item = f64>) -> Track {
        Track::new(self.with_zero_ends(values, 0.0))
    }

    /// Creates a track like [`Beats::track`], for vectors.
    pub(super) fn track3(&self, values: impl IntoIterator<Item = DVec3>) -> Track3 {
        Track3::new(self.with_zero_ends(values, DVec3::ZERO))
    }

    fn with_zero_ends<T>(
        &self,
        values: impl IntoIterator<Item = T>,
        zero: T,
    ) -> impl Iterator<Item = (f64, T)>
    where
        T: Copy,
    {
        let ends = core::iter::once(zero);
        self.times_s.iter().copied().zip(ends.clone().chain(values).chain(ends))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_span_is_the_minimum_jerk_movement() {
        let track = Track::new([(1.0, 2.0), (3.0, 4.0)]);
        assert!((track.at(2.0) - 3.0).abs() < 1e-15);
        // The peak speed of a minimum-jerk movement is 15/8 of the mean.
        let speed = (track.at(2.0 + 1e-6) - track.at(2.0 - 1e-6)) / 2e-6;
        assert!((speed - 1.875).abs() < 1e-8, "{speed}");
    }

    #[test]
    fn stands_still_outside_and_is_zero_when_empty() {
        let track = Track::new([(1.0, 2.0), (3.0, 4.0)]);
        assert_eq!(
            [track.at(0.0), track.at(9.0), Track::default().at(1.0)].map(f64::to_bits),
            [2.0, 4.0, 0.0].map(f64::to_bits)
        );
    }

    #[test]
    fn passes_keys_smoothly_and_never_runs_past_them() {
        let points = [(0.0, 0.0), (0.1, 1.0), (0.5, 1.5), (0.6, 3.0), (0.9, -1.0), (1.0, -1.0)];
        let track = Track::new(points);
        for (time_s, value) in points {
            assert!((track.at(time_s) - value).abs() < 1e-12);
            let h = 1e-5;
            let slopes = [-h, 0.0]
                .map(|shift| (track.at(time_s + shift + h) - track.at(time_s + shift)) / h);
            assert!((slopes[0] - slopes[1]).abs() < 1e-2, "kink at {time_s}: {slopes:?}");
        }
        for pair in points.windows(2) {
            let (low, high) = (pair[0].1.min(pair[1].1), pair[0].1.max(pair[1].1));
            for step in 0..=100 {
                let time_s = pair[0].0 + (pair[1].0 - pair[0].0) * f64::from(step) / 100.0;
                let value = track.at(time_s);
                assert!(low - 1e-12 <= value && value <= high + 1e-12, "{value} at {time_s}");
            }
        }
    }
}
