//! Damaged shows are refused, or play within their bounds: truncations, bit flips, and random changes with corrected
//! CRCs, like those of a faulty writer or an attacker.

#![expect(clippy::cast_possible_truncation, reason = "small numbers")]

use crate::examples::example;
use crc::{CRC_32_ISO_HDLC, Crc};
use sinew_show::write::{Motion, Settings, write};
use sinew_show::{Joint, Player, Position, Rate, Show, ShowError};

const COORDS: usize = 16;
const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
/// Number of random changes in a run: about 10 s on two cores.
const MUTATIONS: u64 = 1_000_000;

fn small(is_loop: bool) -> Vec<u8> {
    let joints = vec![Joint::Spherical, Joint::Revolute, Joint::Prismatic];
    let example = example(joints, 36, Rate { samples: 30, seconds: 1 }, is_loop, 3);
    let cues = [(0, "curtain"), (10, "lights")];
    let motion = Motion { cues: &cues, ..example.motion() };
    let settings = Settings { block_s: 0.4, ..Settings::default() };
    write(&motion, &settings).expect("a motion that can be").bytes
}

/// Plays a whole show, if it opens. Refusals are valid; numbers that no joint can have are not.
fn play(bytes: &[u8]) -> Result<(), ShowError> {
    let show = Show::open(bytes)?;
    assert!(show.cues().all(|cue| cue.name.len() < 256));
    let mut player = Player::<COORDS>::new(show)?;
    let (mut q, mut qd, mut qdd) = ([0.0f32; COORDS], [0.0f32; COORDS], [0.0f32; COORDS]);
    let mut outcome = Ok(());
    // Positions near block borders and the end, backwards, and far beyond.
    let places = [0, 1, 11, 12, 23, 25, 34, 35, 36, 37, 5, 1 << 20];
    for sample in places {
        let played = player.state_at(Position::from_samples(sample), &mut q, &mut qd, &mut qdd);
        outcome = outcome.and(played);
        let mut at = 0;
        for joint in show.joints() {
            if at + joint.coordinate_count() > COORDS {
                break;
            }
            if joint.turns_freely() && played.is_ok() {
                let squared: f32 = q[at..at + 4].iter().map(|x| x * x).sum();
                assert!((squared - 1.0).abs() < 1e-4, "{squared}");
            }
            at += joint.coordinate_count();
        }
        assert!(q.iter().all(|x| x.abs() <= 1.1e6), "{q:?}");
        assert!(qd.iter().chain(&qdd).all(|x| x.is_finite()), "{qd:?} {qdd:?}");
    }
    outcome
}

#[test]
fn a_whole_one_plays() {
    for is_loop in [false, true] {
        play(&small(is_loop)).expect("a whole show");
    }
}

#[test]
fn every_truncation_and_addition_is_refused() {
    for is_loop in [false, true] {
        let mut bytes = small(is_loop);
        for len in 0..bytes.len() {
            let refused = Show::open(&bytes[..len]).expect_err("it is cut off");
            assert!(
                matches!(refused, ShowError::Length { found, .. } if found == len),
                "{refused}"
            );
        }
        bytes.push(0);
        assert!(matches!(Show::open(&bytes), Err(ShowError::Length { .. })));
    }
}

#[test]
fn every_flipped_bit_is_refused() {
    for is_loop in [false, true] {
        let whole = small(is_loop);
        for bit in 0..whole.len() * 8 {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            let refused = Show::open(&bytes).and_then(|show| show.check_blocks());
            assert!(refused.is_err(), "bit {bit}");
            assert!(play(&bytes).is_err(), "bit {bit}");
        }
    }
}

/// Corrects all CRCs that can be found.
fn seal(bytes: &mut [u8]) {
    let word = |bytes: &[u8], at: usize| -> Option<usize> {
        Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?) as usize)
    };
    let Some(head_len) = word(bytes, 12).filter(|len| len.saturating_add(4) <= bytes.len()) else {
        return;
    };
    // Finds blocks by the show's index, the last part of the head.
    let mut starts: Vec<usize> = Vec::new();
    let mut at = head_len;
    while let Some(start) = at.checked_sub(4).and_then(|at| word(bytes, at)) {
        if start < head_len + 4
            || starts.last().is_some_and(|last| start >= *last)
            || start > bytes.len()
        {
            break;
        }
        starts.push(start);
        at -= 4;
    }
    let mut end = bytes.len();
    for start in starts {
        if end >= start + 4 {
            let crc = CHECKSUM.checksum(&bytes[start + 4..end]);
            bytes[start..start + 4].copy_from_slice(&crc.to_le_bytes());
        }
        end = start;
    }
    let crc = CHECKSUM.checksum(&bytes[..head_len]);
    bytes[head_len..head_len + 4].copy_from_slice(&crc.to_le_bytes());
}

/// Returns how many shows are refused, and how many play, for the random changes `first`, `first + step`, ...
fn mutate(wholes: &[Vec<u8>; 2], first: u64, step: usize) -> [u32; 2] {
    let [mut refused, mut played] = [0, 0];
    let mut bytes = Vec::new();
    for round in (first..MUTATIONS).step_by(step) {
        // The seed depends only on the round, so each change is the same for any number of threads.
        let mut random = round.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut next = |below: usize| {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (random >> 33) as usize % below
        };
        bytes.clone_from(&wholes[next(2)]);
        for _ in 0..=next(4) {
            let at = next(bytes.len());
            bytes[at] = match next(4) {
                0 => bytes[at] ^ (1 << next(8)),
                1 => [0, 1, 0x7f, 0x80, 0xff][next(5)],
                _ => next(256) as u8,
            };
        }
        // In one round of eight the CRCs are not corrected.
        if round % 8 != 0 {
            seal(&mut bytes);
        }
        match play(&bytes) {
            Ok(()) => played += 1,
            Err(_) => refused += 1,
        }
    }
    [refused, played]
}

#[test]
fn random_changes_are_refused_or_harmless() {
    let wholes = &[small(false), small(true)];
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let counts: Vec<[u32; 2]> = std::thread::scope(|scope| {
        let runs: Vec<_> = (0..threads as u64)
            .map(|first| scope.spawn(move || mutate(wholes, first, threads)))
            .collect();
        runs.into_iter().map(|run| run.join().expect("no panic")).collect()
    });
    let [refused, played] = [0, 1].map(|k| counts.iter().map(|count| count[k]).sum::<u32>());
    // If either count were small, this test would check almost nothing.
    assert!(refused > 1000 && played > 1000, "{refused} {played}");
}

#[test]
fn refusals_are_in_words() {
    let words = |bytes: &[u8]| Show::open(bytes).expect_err("no show").to_string();
    let mut bytes = small(false);
    bytes[4] = 1;
    assert_eq!(
        words(&bytes),
        "the show is of version 1, which is no longer read: bake it again from its clip, with `sinew bake CLIP --rig \
         RIG`"
    );
    bytes[4] = 3;
    assert_eq!(words(&bytes), "the show is of version 3; this program performs version 2");
    assert_eq!(
        words(b"RIFF and more"),
        "not a show: it begins with [52, 49, 46, 46] instead of `SNWS`"
    );
    let bytes = small(false);
    let show = Show::open(&bytes).expect("a show");
    let refused = Player::<5>::new(show).expect_err("six coordinates");
    assert_eq!(refused.to_string(), "the show has 6 joint coordinates, the board holds 5");
    assert_eq!(show.check_rig(0x1234_abcd), Ok(()));
    assert_eq!(
        show.check_rig(0xdead_beef).expect_err("another rig").to_string(),
        "the show was made for rig 1234abcd, here is rig deadbeef: bake it again for this rig"
    );
    let kinds = [sinew_core::JointKind::Spherical; 3];
    assert_eq!(
        show.check_joints(kinds.into_iter()).expect_err("other joints").to_string(),
        "joint 1 is revolute in the show, spherical in the rig"
    );
}

#[test]
fn cues_and_time_code_come_back() {
    use sinew_show::{Cue, TimeCode, TimeCodeKind};
    let example = example(vec![Joint::Revolute], 60, Rate { samples: 30, seconds: 1 }, false, 3);
    let time_code = TimeCode {
        hours: 10,
        minutes: 0,
        seconds: 59,
        frames: 24,
        frames_per_second: 25,
        kind: TimeCodeKind::Whole,
    };
    let cues = [(0, "curtain"), (10, ""), (10, "Licht aus, später"), (59, "end")];
    let motion = Motion { cues: &cues, time_code: Some(time_code), ..example.motion() };
    let bytes = write(&motion, &Settings::default()).expect("a motion that can be").bytes;
    let show = Show::open(&bytes).expect("a show");
    assert_eq!(show.time_code(), Some(time_code));
    let found: Vec<_> = show.cues().map(|Cue { sample, name }| (sample, name)).collect();
    assert_eq!(found, cues);
    let between = show.cues_between(Position::from_samples(10), Position::from_samples(59));
    assert_eq!(between.map(|cue| cue.name).collect::<Vec<_>>(), ["", "Licht aus, später"]);
}

#[test]
fn the_time_code_of_a_slowed_show_follows_its_performance() {
    use sinew_show::{TimeCode, TimeCodeKind};
    let example = example(vec![Joint::Revolute], 100, Rate { samples: 50, seconds: 1 }, false, 3);
    let (hours, minutes, seconds, frames) = (9, 59, 59, 20);
    let kind = TimeCodeKind::Whole;
    let begin = TimeCode { hours, minutes, seconds, frames, frames_per_second: 25, kind };
    // Half speed from 0.4 s to 1.2 s; original speed before and after.
    let course = [(20, 20), (60, 40)];
    let motion = Motion { course: &course, time_code: Some(begin), ..example.motion() };
    let bytes = write(&motion, &Settings::default()).expect("a motion that can be").bytes;
    let show = Show::open(&bytes).expect("a show");
    assert_eq!(show.course().collect::<Vec<_>>(), course);
    // Two samples per frame: 0, 10, 15, 20 and 30 frames of the performance.
    for (sample, frames) in [(0, 0), (20, 10), (40, 15), (60, 20), (80, 30)] {
        assert_eq!(show.time_code_at(sample), Some(begin.after(frames)), "{sample}");
    }
    assert_eq!(begin.after(5), TimeCode { hours: 10, minutes: 0, seconds: 0, frames: 0, ..begin });
    for course in [&[(0, 0)][..], &[(20, 20), (20, 30)], &[(20, 20), (30, 10)], &[(1 << 31, 0)]] {
        let motion = Motion { course, ..motion };
        assert!(write(&motion, &Settings::default()).is_err(), "{course:?}");
        // A board reads the pairs from a file: it must refuse them too.
        let mut bytes = bytes.clone();
        let at = usize::from(u16::from_le_bytes([bytes[40], bytes[41]])) + 56 + 1 + 16;
        let pairs: Vec<u8> = course
            .iter()
            .flat_map(|(at, of): &(u32, u32)| [*at, *of])
            .flat_map(u32::to_le_bytes)
            .collect();
        bytes[at + 2..at + 2 + pairs.len()].copy_from_slice(&pairs);
        seal(&mut bytes);
        let refused = Show::open(&bytes).map(|_| ()).expect_err("a course that goes back");
        assert!(refused.to_string().contains("course"), "{course:?}: {refused}");
    }
}
