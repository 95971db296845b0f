//! A snapshot is cut into frames, and the sizes computed in `rate` hold for them.

#![expect(clippy::cast_possible_truncation, reason = "counts and times are small")]

use sinew_link::message::*;
use sinew_link::rate::{RigSize, frame_len, frames_per_second, snapshot_len, telemetry_hz};
use sinew_link::{BODY_MAX, Decoder, FRAME_MAX};

use crate::common;
use crate::common::Random;
use crate::common::wire::frame;

/// The longest possible summary.
const LONGEST: Summary = Summary {
    state: State::Faulted,
    fault: Some(u8::MAX),
    errors: Some(Errors {
        mean_deg: 1.0,
        largest_deg: 2.0,
        mean_cm: 3.0,
        largest_cm: 4.0,
        worst: u8::MAX,
    }),
    tick_us: u16::MAX,
    tick_max_us: u16::MAX,
    overruns: u32::MAX,
    stack_free: u32::MAX,
    supply_v: 12.0,
    link_damaged: u32::MAX,
    link_lost: u32::MAX,
    live_age_ms: Some(u16::MAX),
    show_ms: u32::MAX,
};

const DOF: Dof = Dof { effort: 1.1, limiter: Some(Limit::Supply), target: i16::MIN };
const SERVO: Servo = Servo {
    temperature_c: Some(41),
    heat_percent: 30,
    bus_errors: u16::MAX,
    hardware_error: 1,
    supply: 120,
};

#[test]
fn all_of_a_snapshot_is_told_once() {
    let mut random = Random(5);
    for _ in 0..500 {
        let q: Vec<f32> = (0..random.below(200)).map(|_| random.finite()).collect();
        let dof = |random: &mut Random| Dof {
            target: random.bits() as i16,
            ..common::messages::dof(random)
        };
        let dofs: Vec<Dof> = (0..random.below(200)).map(|_| dof(&mut random)).collect();
        let servo = |random: &mut Random| Servo {
            supply: random.bits() as u8,
            ..common::messages::servo(random)
        };
        let servos: Vec<Servo> = (0..random.below(200)).map(|_| servo(&mut random)).collect();
        let summary = common::messages::summary(&mut random);
        let parts = TelemetryParts(random.below(64) as u8);
        let snapshot = Snapshot {
            tick: random.bits(),
            summary: &summary,
            q: &q,
            dofs: &dofs,
            servos: &servos,
        };

        let mut decoder = Decoder::<ToHost>::new();
        let mut told = (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for index in 0..snapshot.frames(parts) {
            let part = snapshot.frame(parts, index, index as u16).expect("it is one of them");
            assert_eq!((part.seq, part.tick), (index as u16, snapshot.tick));
            decoder.feed(&frame(&ToHost::Telemetry(part)), |message| {
                let ToHost::Telemetry(telemetry) = message else { unreachable!() };
                match telemetry.part {
                    SnapshotPart::Summary(summary) => told.0.push(summary),
                    SnapshotPart::Pose { first, q } => {
                        assert_eq!(usize::from(first), told.1.len());
                        told.1.extend(q);
                    }
                    SnapshotPart::Dofs { first, dofs } => {
                        assert_eq!(usize::from(first), told.2.len());
                        told.2.extend(dofs);
                    }
                    SnapshotPart::Servos { first, servos } => {
                        assert_eq!(usize::from(first), told.3.len());
                        told.3.extend(servos);
                    }
                    SnapshotPart::Targets { first, offsets } => {
                        assert_eq!(usize::from(first), told.4.len());
                        told.4.extend(offsets);
                    }
                    SnapshotPart::Supplies { first, supplies } => {
                        assert_eq!(usize::from(first), told.5.len());
                        told.5.extend(supplies);
                    }
                }
            });
        }
        assert_eq!(snapshot.frame(parts, snapshot.frames(parts), 0), None);
        assert_eq!(told.0 == [summary], parts.has(TelemetryParts::SUMMARY));
        assert_eq!(told.1 == q, parts.has(TelemetryParts::POSE) || q.is_empty());
        // The part of targets has them, not the part of dofs.
        let bare: Vec<Dof> = dofs.iter().map(|dof| Dof { target: 0, ..*dof }).collect();
        assert_eq!(told.2 == bare, parts.has(TelemetryParts::DOFS) || dofs.is_empty());
        let targets: Vec<i16> = dofs.iter().map(|dof| dof.target).collect();
        assert_eq!(told.4 == targets, parts.has(TelemetryParts::TARGETS) || dofs.is_empty());
        let supplies: Vec<u8> = servos.iter().map(|servo| servo.supply).collect();
        assert_eq!(told.5 == supplies, parts.has(TelemetryParts::SUPPLIES) || servos.is_empty());
        let servos: Vec<Servo> = servos.iter().map(|servo| Servo { supply: 0, ..*servo }).collect();
        assert_eq!(told.3 == servos, parts.has(TelemetryParts::SERVOS) || servos.is_empty());
    }
}

/// Returns the length of a snapshot in which every number takes the most room, in bytes.
fn written(size: RigSize, parts: TelemetryParts) -> usize {
    // No zero byte, so that COBS adds the most bytes.
    let q = vec![1.1; size.coordinates];
    let dofs = vec![DOF; size.dofs];
    let servos = vec![SERVO; size.servos];
    let snapshot =
        Snapshot { tick: u32::MAX, summary: &LONGEST, q: &q, dofs: &dofs, servos: &servos };
    (0..snapshot.frames(parts))
        .map(|index| snapshot.frame(parts, index, u16::MAX).expect("it is one of them"))
        .map(|telemetry| frame(&ToHost::Telemetry(telemetry)).len())
        .sum()
}

#[test]
fn the_rate_is_that_of_what_is_written() {
    for count in [0, 1, 6, 20, 42, 43, 64, 65, 100] {
        let size = RigSize { coordinates: count, dofs: count, servos: count };
        for parts in (0..64).map(TelemetryParts) {
            let (sum, written) = (snapshot_len(size, parts), written(size, parts));
            // Never above the computed size, and at most a byte below, which frames of up to 254 bytes save.
            assert!(written <= sum && sum <= written + 8, "{size:?} {parts:?}: {written}, {sum}");
            if written > 0 {
                let hz = telemetry_hz(1_000_000, size, parts) as usize;
                assert!(hz * written <= 75_000);
            }
        }
    }
    assert_eq!(frame_len(BODY_MAX), FRAME_MAX);
    assert_eq!(frames_per_second(115_200, BODY_MAX) as usize, 11_520 / FRAME_MAX);
    assert_eq!(frames_per_second(0, 10), 0);
}

#[test]
fn parts_are_bits() {
    let both = TelemetryParts::POSE.and(TelemetryParts::SERVOS);
    assert!(
        both.has(TelemetryParts::POSE)
            && both.has(TelemetryParts::SERVOS)
            && !both.has(TelemetryParts::DOFS)
    );
    let all = [
        TelemetryParts::SUMMARY,
        TelemetryParts::POSE,
        TelemetryParts::DOFS,
        TelemetryParts::SERVOS,
    ];
    assert_eq!(all.into_iter().reduce(TelemetryParts::and), Some(TelemetryParts::ALL));
    for later in [TelemetryParts::TARGETS, TelemetryParts::SUPPLIES] {
        assert!(!TelemetryParts::ALL.has(later));
    }
}
