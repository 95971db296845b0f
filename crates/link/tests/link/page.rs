//! The page `docs/link.md` contains the bytes, sizes and numbers that the code produces.

#![expect(clippy::cast_possible_truncation, reason = "counts and times are small")]

use std::collections::BTreeMap;
use std::fmt::{Debug, Write};

use serde::Serialize;
use sinew_link::message::*;
use sinew_link::rate::{RigSize, telemetry_hz};
use sinew_link::{BODY_MAX, FRAME_MAX};

use crate::common;
use crate::common::Random;
use crate::common::wire::{body_of, frame};

const PAGE: &str = include_str!("../../../../docs/link.md");

fn assert_on_page(text: &str) {
    assert!(PAGE.contains(text), "docs/link.md lacks this:\n{text}");
}

fn command(seq: u16, item: Command) -> ToController {
    ToController::Command(Numbered { session: 1, seq, item })
}

fn stream(seq: u16, item: Stream) -> ToController {
    ToController::Stream(Numbered { session: 1, seq, item })
}

fn answer(seq: u16, item: Outcome) -> ToHost {
    ToHost::Answer(Numbered { session: 1, seq, item })
}

const HELLO: ToController =
    ToController::Hello(Hello { protocol: Version { major: 1, minor: 0 }, nonce: 0x1234_5678 });

const WELCOME: ToHost = ToHost::Welcome(Welcome {
    nonce: 0x1234_5678,
    session: 1,
    about: About {
        protocol: Version { major: 1, minor: 0 },
        firmware: Release { major: 0, minor: 1, patch: 0 },
        rig: 0xC0FF_EE42,
        capacities: Capacities {
            bodies: 32,
            coordinates: 40,
            dofs: 32,
            servos: 24,
            slots: 1,
            slot_bytes: 131_072,
        },
    },
    verdict: Ok(0),
});

fn pose(count: usize) -> LiveFrame {
    LiveFrame { sent_us: 1_500_000, q: (0..count).map(|index| index as f32 * 0.5).collect() }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect::<Vec<_>>().join(" ")
}

#[test]
fn examples() {
    let telemetry = TelemetrySetting { rate_hz: 18.0, parts: TelemetryParts::ALL };
    let fault = FaultRecord {
        fault: 3,
        state: State::Playing,
        servo: Some(5),
        start: 12,
        time_us: 90_000_000,
        times: 1,
    };
    let to_controller = [
        ("Hello, version 1.0, nonce 0x12345678", HELLO),
        ("Arm, session 1, number 0", command(0, Command::Arm)),
        ("Play live frames, number 1", command(1, Command::Play(Feed::Live))),
        ("Heartbeat, number 300 of the stream", stream(300, Stream::Heartbeat)),
        (
            "Heard telemetry up to number 41, number 300 of the stream",
            stream(300, Stream::Heard(41)),
        ),
        ("Live frame of (0, 0.5), sent at 1.5 s, number 301", stream(301, Stream::Live(pose(2)))),
        (
            "Jog of degree of freedom 3 at 0.5 rad/s, number 302",
            stream(302, Stream::Jog { dof: 3, velocity: 0.5 }),
        ),
        ("EStop, number 3", command(3, Command::EStop)),
    ]
    .map(|(name, message)| (name, frame(&message)));
    let to_host = [
        ("Welcome to session 1", WELCOME),
        (
            "Answer to number 0: applied, the rig is arming",
            answer(0, Outcome::Applied(Applied::State(State::Arming))),
        ),
        (
            "Answer to number 2: limited to all telemetry at 18 Hz, by the line",
            answer(2, Outcome::Limited(Applied::Telemetry(telemetry), Limit::Link)),
        ),
        (
            "Answer to number 4: refused, the rig is off",
            answer(4, Outcome::Refused(Refusal::State(State::Off))),
        ),
        ("Fault 3 of servo 5, while playing, 90 s after start 12", ToHost::Fault(fault)),
    ]
    .map(|(name, message)| (name, frame(&message)));
    let mut text = String::new();
    for (name, frame) in to_controller.into_iter().chain(to_host) {
        let body = hex(&body_of(&frame));
        writeln!(text, "{name}\n  body  {body}\n  wire  {}", hex(&frame)).expect("into a string");
    }
    println!("{text}");
    assert_on_page(&text);
}

#[test]
fn sizes() {
    let item = Item {
        kind: Kind::Show,
        schema: 2,
        length: 65_536,
        hash: [7; 32],
        rig: 0xC0FF_EE42,
        approver: "A. N. Other".try_into().expect("it is short"),
    };
    let block = |len| Block { offset: 65_536, bytes: vec![7; len].into_iter().collect() };
    let mut rows = vec![
        ("Hello".to_owned(), frame(&HELLO).len()),
        ("Welcome".to_owned(), frame(&WELCOME).len()),
        (
            "Arm, and other commands without a value".to_owned(),
            frame(&command(1000, Command::Arm)).len(),
        ),
        (
            "its answer".to_owned(),
            frame(&answer(1000, Outcome::Applied(Applied::State(State::Arming)))).len(),
        ),
        ("Jog".to_owned(), frame(&stream(1000, Stream::Jog { dof: 3, velocity: 0.5 })).len()),
        ("Heartbeat".to_owned(), frame(&stream(1000, Stream::Heartbeat)).len()),
        ("Heard".to_owned(), frame(&stream(1000, Stream::Heard(1000))).len()),
    ];
    for count in [6, 20, 64] {
        rows.push((
            format!("live frame of {count} numbers"),
            frame(&stream(1000, Stream::Live(pose(count)))).len(),
        ));
    }
    rows.push((
        "begin of an upload, approver of 11 bytes".to_owned(),
        frame(&command(1000, Command::BeginUpload(item))).len(),
    ));
    rows.push((
        "block of 256 bytes".to_owned(),
        frame(&command(1000, Command::UploadBlock(block(256)))).len(),
    ));
    let mut table = String::from("| message | bytes |\n|---|---:|\n");
    for (name, len) in rows {
        writeln!(table, "| {name} | {len} |").expect("into a string");
    }
    writeln!(table, "| the longest | {FRAME_MAX} |").expect("into a string");
    println!("{table}");
    assert_on_page(&table);
    assert_on_page(&format!("at most {BODY_MAX} bytes"));
}

#[test]
fn rates() {
    let mut table = String::from("| telemetry | 115,200 baud | 1 Mbps |\n|---|---:|---:|\n");
    for count in [6, 20, 40, 64] {
        let size = RigSize { coordinates: count, dofs: count, servos: count };
        for (what, parts) in [
            ("summary and pose", TelemetryParts::SUMMARY.and(TelemetryParts::POSE)),
            ("all", TelemetryParts::ALL),
        ] {
            let [slow, fast] = [115_200, 1_000_000].map(|baud| telemetry_hz(baud, size, parts));
            writeln!(table, "| {count} servos, {what} | {slow} | {fast} |").expect("into a string");
        }
    }
    println!("{table}");
    assert_on_page(&table);
}

/// Returns the number and the name of a kind.
fn kind(value: &(impl Serialize + Debug)) -> (u8, String) {
    let number = postcard::to_slice(value, &mut [0; 300]).expect("there is room")[0];
    let name = format!("{value:?}");
    let end = name.find(|c: char| !c.is_alphanumeric()).unwrap_or(name.len());
    (number, name[..end].to_owned())
}

/// The page lists all kinds of random messages by number and name, without a gap in the numbers.
#[test]
fn kinds() {
    let mut random = Random(6);
    let mut kinds: BTreeMap<&str, BTreeMap<u8, String>> = BTreeMap::new();
    let mut see = |of, (number, name)| {
        let known = kinds.entry(of).or_default().entry(number).or_insert(name).clone();
        assert!(!known.is_empty());
    };
    for _ in 0..120_000 {
        let (a, b) =
            (common::messages::to_controller(&mut random), common::messages::to_host(&mut random));
        see("to the controller", kind(&a));
        see("to the host", kind(&b));
        match a {
            ToController::Command(command) => {
                see("command", kind(&command.item));
                match command.item {
                    Command::Play(feed) => see("feed", kind(&feed)),
                    Command::WriteSetting { value, .. } => see("value", kind(&value)),
                    Command::AskStored(place) => see("place", kind(&place)),
                    Command::BeginUpload(item) => see("item", kind(&item.kind)),
                    _ => {}
                }
            }
            ToController::Stream(stream) => see("stream", kind(&stream.item)),
            ToController::Hello(_) => {}
        }
        match b {
            ToHost::Welcome(Welcome { verdict: Err(misfit), .. }) => see("misfit", kind(&misfit)),
            ToHost::Answer(answer) => {
                see("outcome", kind(&answer.item));
                match answer.item {
                    Outcome::Limited(applied, limit) => {
                        see("applied", kind(&applied));
                        see("limit", kind(&limit));
                    }
                    Outcome::Refused(refusal) => {
                        see("refusal", kind(&refusal));
                        if let Refusal::State(state) = refusal {
                            see("state", kind(&state));
                            assert_eq!(kind(&state).0, state.number());
                        }
                    }
                    _ => {}
                }
            }
            ToHost::Telemetry(telemetry) => see("part", kind(&telemetry.part)),
            _ => {}
        }
    }
    for (of, rows) in &kinds {
        let numbers: Vec<u8> = rows.keys().copied().collect();
        assert_eq!(numbers, (0..rows.len() as u8).collect::<Vec<_>>(), "{of}");
        // Reads a list of a section with its name: `0 Name, 1 Name`, or a table of rows.
        let list = rows.iter().map(|(number, name)| format!("{number} {name}"));
        let list = list.collect::<Vec<_>>().join(", ");
        let joined = PAGE.replace('\n', " ");
        let in_table =
            rows.iter().all(|(number, name)| joined.contains(&format!("| {number} | `{name}` |")));
        assert!(in_table || joined.contains(&list), "docs/link.md lacks, of {of}: {list}");
    }
}
