//! Draws random pairs of poses.

use sinew_host_util::random::{Random, Subject};

use crate::recordings::{Class, Pose, Recordings, Sequence};

/// Origin of the poses of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pairing {
    /// Any two poses.
    Any,
    /// Two poses of one recording.
    OneRecording,
    /// Two poses of two people.
    TwoPeople,
}

/// A pose of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment<'a> {
    /// Recording that contains the pose.
    pub sequence: &'a Sequence,
    /// Index of the frame.
    pub frame: usize,
}

impl<'a> Moment<'a> {
    /// Returns the pose at this frame.
    pub fn pose(&self) -> &'a Pose {
        &self.sequence.frames[self.frame]
    }
}

/// Returns all moments of recordings of one class, or of all.
pub(super) fn moments(recordings: &Recordings, class: Option<Class>) -> Vec<Moment<'_>> {
    let of_class = recordings.sequences.iter().filter(|s| class.is_none_or(|c| c == s.class));
    let of = |sequence: &Sequence| 0..sequence.frames.len();
    of_class
        .flat_map(|sequence| of(sequence).map(move |frame| Moment { sequence, frame }))
        .collect()
}

/// Draws `count` pairs of different moments, each with equal probability. `None` if there are no such pairs.
pub(super) fn pairs<'a>(
    moments: &[Moment<'a>],
    pairing: Pairing,
    count: usize,
    seed: u64,
) -> Option<Vec<[Moment<'a>; 2]>> {
    let fits = |a: &Moment<'_>, b: &Moment<'_>| {
        let one = std::ptr::eq(a.sequence, b.sequence);
        match pairing {
            Pairing::Any => !one || a.frame != b.frame,
            Pairing::OneRecording => one && a.frame != b.frame,
            Pairing::TwoPeople => a.sequence.subject != b.sequence.subject,
        }
    };
    let first = moments.first()?;
    let others = moments.iter().any(|other| fits(first, other));
    if !others {
        return None;
    }
    let mut random = Random::new(seed, Subject::Pairs);
    let mut pairs = Vec::with_capacity(count);
    while pairs.len() < count {
        let one = moments[random.below(moments.len())];
        let fitting: Vec<&Moment<'_>> = moments.iter().filter(|other| fits(&one, other)).collect();
        if !fitting.is_empty() {
            pairs.push([one, *fitting[random.below(fitting.len())]]);
        }
    }
    Some(pairs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_what_was_asked_for_and_the_same_for_a_seed() {
        let recordings = Recordings::built_in();
        let all = moments(&recordings, None);
        let draw = |pairing, seed| pairs(&all, pairing, 40, seed).unwrap();
        for [a, b] in draw(Pairing::OneRecording, 1) {
            assert!(a.sequence.file == b.sequence.file && a.frame != b.frame);
        }
        for [a, b] in draw(Pairing::TwoPeople, 1) {
            assert_ne!(a.sequence.subject, b.sequence.subject);
        }
        assert_eq!(draw(Pairing::Any, 1), draw(Pairing::Any, 1));
        assert_ne!(draw(Pairing::Any, 1), draw(Pairing::Any, 2));
        assert!(pairs(&moments(&recordings, Some(Class::Walk)), Pairing::Any, 1, 1).is_none());
    }
}
