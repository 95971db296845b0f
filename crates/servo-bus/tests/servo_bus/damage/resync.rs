//! Tests that both sides read the first whole packet after damage, wherever the stream is split.
//!
//! Damage that looks like a header with a length makes a parser wait for that many bytes, at most as many as it holds.
//! When their check is wrong, or when the line falls silent, the parser examines all of them again. Whole packets among
//! them are therefore late, but not lost. The parser takes a false header and the bytes after it for a packet only if
//! their check is right by chance: `reference` finds these places.

use proptest::collection::vec;
use proptest::prelude::*;
use sinew_servo_bus::dynamixel::table::{MODELS, Table};
use sinew_servo_bus::dynamixel::{
    self, Instruction, Mode, ServoSetup, Settings, Status, StatusError,
};
use sinew_servo_bus::feetech::{self, Family};
use sinew_servo_bus::{BusDevice, Schedule, ServoBus};

use super::{MASTER_WINDOW, TIMING};
use crate::reference::{self, Found};

/// Contents of a packet: id, instruction or status, and parameters.
type Content = (u8, u8, Vec<u8>);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Protocol {
    Dynamixel,
    Feetech,
}
use Protocol::{Dynamixel, Feetech};

impl Protocol {
    fn packet(self, (id, code, params): &Content) -> Vec<u8> {
        let mut out = [0; 300];
        match self {
            Dynamixel => {
                let mut frame = dynamixel::FrameWriter::new(&mut out, *id, *code);
                frame.extend(params);
                let len = frame.finish().unwrap();
                out[..len].to_vec()
            }
            // A status with any byte in the place of the instruction.
            Feetech => {
                let status = feetech::Status { id: *id, bits: *code, data: params };
                let len = status.encode(&mut out).unwrap();
                out[..len].to_vec()
            }
        }
    }

    fn header(self, id: u8, length: u16) -> Vec<u8> {
        let [low, high] = length.to_le_bytes();
        match self {
            Dynamixel => vec![0xFF, 0xFF, 0xFD, 0, id, low, high],
            Feetech => vec![0xFF, 0xFF, id, low],
        }
    }

    /// Returns the packets that the reference finds, as a receiver of packets up to `N` bytes.
    fn found<const N: usize>(self, stream: &[u8]) -> Vec<Found> {
        match self {
            Dynamixel => reference::dynamixel(stream, N),
            Feetech => reference::feetech(stream, N),
        }
    }

    /// Returns the packets that the crate's parser finds in the pieces of a stream, followed by silence.
    fn parse<'a, const N: usize>(self, pieces: impl IntoIterator<Item = &'a [u8]>) -> Vec<Content> {
        let mut found = Vec::new();
        match self {
            Dynamixel => {
                let mut parser = dynamixel::Parser::<N>::new();
                let mut note = |packet: dynamixel::Packet<'_>| {
                    found.push((packet.id, packet.instruction, packet.params.to_vec()));
                };
                for mut piece in pieces {
                    while let Some(packet) = parser.next(&mut piece) {
                        note(packet);
                    }
                }
                while let Some(packet) = parser.flush() {
                    note(packet);
                }
            }
            Feetech => {
                let mut parser = feetech::Parser::<N>::new();
                let mut note = |packet: feetech::Packet<'_>| {
                    found.push((packet.id, packet.code, packet.params.to_vec()));
                };
                for mut piece in pieces {
                    while let Some(packet) = parser.next(&mut piece) {
                        note(packet);
                    }
                }
                while let Some(packet) = parser.flush() {
                    note(packet);
                }
            }
        }
        found
    }

    fn check_parser<const N: usize>(self, stream: &[u8], pieces: &[&[u8]]) {
        let expected: Vec<Content> = self.found::<N>(stream).into_iter().map(content).collect();
        assert_eq!(self.parse::<N>(pieces.iter().copied()), expected, "{stream:02X?}");
        assert_eq!(self.parse::<N>(stream.chunks(1)), expected, "{stream:02X?}");
    }
}

fn content(found: Found) -> Content {
    (found.id, found.code, found.params)
}

fn byte() -> impl Strategy<Value = u8> {
    prop_oneof![4 => Just(0xFF), 2 => Just(0xFD), 1 => Just(0), 1 => 1..40_u8, 3 => any::<u8>()]
}

/// Generates a piece of a stream: a packet, a packet with a changed or lost byte, a cut packet, a header alone, or
/// random bytes.
fn segment() -> impl Strategy<Value = (u8, Content, prop::sample::Index, u8)> {
    let content = (0..=252_u8, any::<u8>(), vec(byte(), 0..20));
    (0..6_u8, content, any::<prop::sample::Index>(), any::<u8>())
}

fn bytes_of(protocol: Protocol, segments: &[(u8, Content, prop::sample::Index, u8)]) -> Vec<u8> {
    let mut stream = Vec::new();
    for (kind, content, at, byte) in segments {
        let mut packet = protocol.packet(content);
        let at = at.index(packet.len());
        match kind {
            0 => stream.extend(&content.2),
            1 => stream.extend(protocol.header(content.0, u16::from(*byte) / 4)),
            2 => packet[at] = *byte,
            3 => drop(packet.remove(at)),
            4 => packet.truncate(at),
            _ => {}
        }
        if *kind > 1 {
            stream.extend(packet);
        }
    }
    stream
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    /// Every parser finds the packets that a receiver with the whole stream finds, wherever the stream is split.
    #[test]
    fn parsers_find_every_whole_packet(
        segments in vec(segment(), 1..8),
        cuts in vec(any::<prop::sample::Index>(), 0..8),
    ) {
        for protocol in [Dynamixel, Feetech] {
            let stream = bytes_of(protocol, &segments);
            let mut ends: Vec<_> = cuts.iter().map(|cut| cut.index(stream.len() + 1)).collect();
            ends.extend([0, stream.len()]);
            ends.sort_unstable();
            let pieces: Vec<_> = ends.windows(2).map(|ends| &stream[ends[0]..ends[1]]).collect();
            // The window of the masters, and two windows of devices.
            protocol.check_parser::<MASTER_WINDOW>(&stream, &pieces);
            protocol.check_parser::<259>(&stream, &pieces);
            protocol.check_parser::<1024>(&stream, &pieces);
        }
    }
}

/// A stream of two packets with a false header first and damage between them, split in three parts in every way.
#[test]
fn every_split_gives_the_same_packets() {
    for protocol in [Dynamixel, Feetech] {
        let packets = [(3, 0x55, vec![0, 0xFF, 0xFF, 0xFD, 9]), (4, 0x55, vec![0xFF, 0xFF, 1])];
        let mut stream = protocol.header(1, 9);
        stream.extend(protocol.packet(&packets[0]));
        stream.extend(&protocol.packet(&(2, 0x55, vec![7; 5]))[..8]);
        stream.extend(protocol.packet(&packets[1]));
        for first in 0..=stream.len() {
            for second in first..=stream.len() {
                let pieces = [&stream[..first], &stream[first..second], &stream[second..]];
                assert_eq!(
                    protocol.parse::<MASTER_WINDOW>(pieces),
                    packets,
                    "{protocol:?} {first} {second}"
                );
            }
        }
    }
}

/// Returns false headers of every length up to `most`: all that a receiver waits for, and the first that it refuses.
fn false_headers(protocol: Protocol, most: u16) -> impl Iterator<Item = Vec<u8>> {
    let ids = [0, 1, 2, 252, 254];
    (0..=most).flat_map(move |length| ids.map(|id| protocol.header(id, length)))
}

/// Checks a receiver after each false header. `is_read` receives the header and returns whether the packet after it was
/// read.
fn behind_false_headers(
    protocol: Protocol,
    most: u16,
    packet: &[u8],
    is_read: impl Fn(&[u8]) -> bool,
) {
    let (mut read, mut all) = (0, 0);
    for header in false_headers(protocol, most) {
        let stream = [&header[..], packet].concat();
        let found = protocol.found::<1100>(&stream);
        all += 1;
        if found.first().is_some_and(|found| found.start == header.len()) {
            assert!(is_read(&header), "{protocol:?} behind {header:02X?}");
            read += 1;
        } else {
            // The check is right by chance, which is frequent with 8 bits. No real packet begins there.
            assert_eq!((protocol, found[0].start), (Feetech, 0), "{header:02X?}");
        }
    }
    // Among lengths that end within the packet, one in 256 has a right sum. Longer lengths never end.
    assert!(all - read <= 2, "{protocol:?}: {read} of {all}");
}

#[test]
fn a_dynamixel_master_reads_the_first_whole_reply() {
    let model = MODELS.iter().find(|model| model.number == 1200).unwrap();
    let setups = [1, 2].map(|id| ServoSetup {
        id,
        model,
        mode: Mode::Position,
        range_rad: [0.0, 6.0],
        current_a: 1.0,
        pwm: 1.0,
        speed_rad_s: 10.0,
    });
    let schedule = Schedule::new(TIMING, &dynamixel::traffic(2, 4, false), 100).unwrap();
    let reply = |id| {
        let mut out = [0; 64];
        let status = Status { id, error: StatusError::NONE, data: &[0, 0, 0, 0, 0, 0, 9, 4, 0, 0] };
        let len = status.encode(&mut out).unwrap();
        out[..len].to_vec()
    };
    behind_false_headers(Dynamixel, 1100, &reply(1), |header| {
        let settings = Settings { fast: false, retries: 0 };
        let mut bus = dynamixel::Bus::<2>::new(&setups, schedule, settings).unwrap();
        let mut out = [0; 256];
        bus.plan(&mut out).unwrap();
        bus.reply(header);
        bus.reply(&reply(1));
        bus.reply(&reply(2));
        assert_eq!(bus.plan_more(0, &mut out), Ok(None));
        (0..2).all(|servo| bus.feedback(servo).is_some())
    });
}

#[test]
fn a_feetech_master_reads_the_first_whole_reply() {
    let setups = [1, 2].map(|id| feetech::ServoSetup {
        id,
        mode: feetech::Mode::Position,
        range_rad: [0.0, 4.0],
        pwm: 1.0,
        speed_rad_s: 10.0,
    });
    let schedule = Schedule::new(TIMING, &feetech::traffic(Family::Sts, 2), 100).unwrap();
    let reply = |id| {
        let data = [9, 4, 0, 0, 0, 0, 74, 30, 0, 0, 0, 0, 0, 0, 0];
        Feetech.packet(&(id, 0, data.to_vec()))
    };
    behind_false_headers(Feetech, 255, &reply(1), |header| {
        let settings =
            feetech::Settings { family: Family::Sts, echo: false, retries: 0, speed_counts: 1 };
        let mut bus = feetech::Bus::<2>::new(&setups, schedule, settings).unwrap();
        let mut out = [0; 256];
        bus.plan(&mut out).unwrap();
        bus.reply(header);
        bus.reply(&reply(1));
        bus.reply(&reply(2));
        assert_eq!(bus.plan_more(0, &mut out), Ok(None));
        (0..2).all(|servo| bus.feedback(servo).is_some())
    });
}

/// A servo reads the first whole instruction, and answers as without damage.
#[test]
fn a_dynamixel_servo_obeys_the_first_whole_instruction() {
    let table = Table::of(1200, 52).unwrap();
    let mut ping = [0; 16];
    let len = Instruction::Ping.encode(1, &mut ping).unwrap();
    let ping = &ping[..len];
    behind_false_headers(Dynamixel, 1100, ping, |header| {
        let mut memory = vec![0; table.size()];
        let mut device = dynamixel::Device::<1024>::new(table, 1, &mut memory);
        device.hear(&[header, ping].concat());
        device.silence();
        let mut out = [0; 64];
        let len = device.speak(&mut out);
        let mut parser = dynamixel::Parser::<64>::new();
        let status = Status::of(parser.next(&mut &out[..len]).unwrap()).unwrap();
        status.answers(1, 3) && status.error == StatusError::NONE
    });
}

#[test]
fn a_feetech_servo_obeys_the_first_whole_instruction() {
    for (family, model) in [(Family::Sts, "STS3215"), (Family::Scs, "SCS0009")] {
        let table = feetech::Table::of(model).unwrap();
        let mut ping = [0; 16];
        let len = feetech::Instruction::Ping.encode(family, 1, &mut ping).unwrap();
        let ping = &ping[..len];
        behind_false_headers(Feetech, 255, ping, |header| {
            let mut memory = [0; 256];
            let mut device = feetech::Device::new(table, 1, &mut memory);
            device.hear(header);
            device.hear(ping);
            device.silence();
            let mut out = [0; 64];
            let len = device.speak(&mut out);
            let mut parser = feetech::Parser::<64>::new();
            let status = feetech::Status::of(parser.next(&mut &out[..len]).unwrap()).unwrap();
            status.answers(1, 0)
        });
    }
}
