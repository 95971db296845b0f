//! The path of an axis over time.

use sinew_host_util::random::{Random, Subject};

use super::axis::Axis;
use super::settings::ExerciseSettings;

/// A profile of an axis: its positions over time.
#[derive(Debug, Clone)]
pub(super) struct Profile {
    pub(super) home: f64,
    /// Moves in the order of time.
    pub(super) moves: Vec<Move>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Move {
    pub(super) from_s: f64,
    pub(super) duration_s: f64,
    pub(super) to: f64,
}

impl Profile {
    pub(super) fn end_s(&self) -> f64 {
        self.moves.last().map_or(0.0, |last| last.from_s + last.duration_s)
    }

    /// Appends a move that begins at the time `from_s` and ends at the position `to`.
    fn go(&mut self, axis: &Axis, from_s: f64, to: f64, share: f64) {
        let from = self.moves.last().map_or(self.home, |last| last.to);
        self.moves.push(Move { from_s, duration_s: axis.duration_s(to - from, share), to });
    }

    /// Returns the position at a time.
    pub(super) fn at(&self, time_s: f64) -> f64 {
        let begun = self.moves.partition_point(|one| one.from_s <= time_s);
        let Some(last) = begun.checked_sub(1) else { return self.home };
        let from = last.checked_sub(1).map_or(self.home, |before| self.moves[before].to);
        let Move { from_s, duration_s, to } = self.moves[last];
        if time_s - from_s >= duration_s {
            return to;
        }
        let t = (time_s - from_s) / duration_s;
        from + (to - from) * t * t * t * (10.0 + t * (6.0 * t - 15.0))
    }
}

/// Plans a motion in which each axis moves to one end, to the opposite end and home, one axis after the other.
pub(super) fn plan_in_turn(axes: &[Vec<Axis>], share: f64) -> Vec<Vec<Profile>> {
    let mut now_s = 0.0;
    let mut profile = |axis: &Axis| {
        let mut profile = Profile { home: axis.home, moves: Vec::new() };
        for to in [axis.least, axis.most, axis.home] {
            profile.go(axis, now_s, to, share);
            now_s = profile.end_s();
        }
        profile
    };
    axes.iter().map(|axes| axes.iter().map(&mut profile).collect()).collect()
}

/// Plans a motion in which every axis moves between random positions in its range, each with its own timing.
pub(super) fn plan_together(
    axes: &[Vec<Axis>],
    share: f64,
    settings: &ExerciseSettings,
) -> Vec<Vec<Profile>> {
    let mut number = 0;
    let mut profile = |axis: &Axis| {
        let mut random = Random::numbered(settings.seed, number, Subject::Exercise);
        number += 1;
        let mut profile = Profile { home: axis.home, moves: Vec::new() };
        // An axis whose range is a point stays there.
        while profile.end_s() < settings.seconds && axis.most > axis.least {
            let from_s = profile.end_s();
            profile.go(axis, from_s, random.between(axis.least, axis.most), share);
        }
        profile
    };
    axes.iter().map(|axes| axes.iter().map(&mut profile).collect()).collect()
}
