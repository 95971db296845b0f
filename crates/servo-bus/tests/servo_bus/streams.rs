//! Tests that any packet, split anywhere, is read unchanged, and that arbitrary bytes cause no failure.

use proptest::collection::vec;
use proptest::prelude::*;
use sinew_servo_bus::dynamixel::fast::{FastReader, FastTurn, answer_len};
use sinew_servo_bus::dynamixel::{
    self, BROADCAST, Instruction, ResetScope, Span, Status, StatusError, table::Table,
};
use sinew_servo_bus::feetech::{self, Family};
use sinew_servo_bus::{BusDevice, pca9685};

const LONGEST: usize = 512;

/// Generates bytes among which the protocol's special bytes are frequent.
fn byte() -> impl Strategy<Value = u8> {
    prop_oneof![3 => Just(0xFF), 3 => Just(0xFD), 1 => Just(0), 1 => Just(0xFE), 1 => Just(0x55), 4 => any::<u8>()]
}

fn bytes(most: usize) -> impl Strategy<Value = Vec<u8>> {
    vec(byte(), 0..most)
}

#[derive(Debug, Clone)]
struct Lists {
    address: u16,
    length: u16,
    data: Vec<u8>,
}

fn instruction(kind: u8, lists: &Lists) -> Instruction<'_> {
    let Lists { address, length, ref data } = *lists;
    let span = Span { address, length, ids: data };
    match kind {
        0 => Instruction::Ping,
        1 => Instruction::Read { address, length },
        2 => Instruction::Write { address, data },
        3 => Instruction::RegWrite { address, data },
        4 => Instruction::Action,
        5 => Instruction::FactoryReset(ResetScope::ButIdAndBaud),
        6 => Instruction::Reboot,
        7 => Instruction::ClearTurns,
        8 => Instruction::SyncRead(span),
        9 => Instruction::FastSyncRead(span),
        10 => Instruction::SyncWrite { address, length, blocks: data },
        11 => Instruction::BulkRead(data),
        12 => Instruction::FastBulkRead(data),
        _ => Instruction::BulkWrite(data),
    }
}

fn encode(id: u8, instruction: &Instruction<'_>) -> Vec<u8> {
    let mut out = [0; LONGEST];
    let len = match *instruction {
        Instruction::FactoryReset(scope) => dynamixel::factory_reset(id, scope, &mut out),
        _ => instruction.encode(id, &mut out),
    };
    out[..len.unwrap()].to_vec()
}

fn encode_status(id: u8, error: u8, data: &[u8]) -> Vec<u8> {
    let mut out = [0; LONGEST];
    let len = Status { id, error: StatusError::from_byte(error), data }.encode(&mut out).unwrap();
    out[..len].to_vec()
}

fn feetech_instruction(kind: u8, lists: &Lists) -> feetech::Instruction<'_> {
    use feetech::Instruction as I;
    let ([address, _], [length, _]) = (lists.address.to_le_bytes(), lists.length.to_le_bytes());
    let data = &lists.data;
    match kind {
        0 => I::Ping,
        1 => I::Read { address, length },
        2 => I::Write { address, data },
        3 => I::RegWrite { address, data },
        4 => I::Action,
        5 => I::Reboot,
        6 => I::ClearTurns,
        7 => I::SyncRead { address, length, ids: data },
        _ => I::SyncWrite { address, length, blocks: data },
    }
}

/// Generates the positions at which a stream is split, in thousandths of its length.
fn cuts() -> impl Strategy<Value = Vec<usize>> {
    vec(0..=1000_usize, 0..12)
}

fn pieces<'a>(stream: &'a [u8], cuts: &[usize]) -> Vec<&'a [u8]> {
    let mut ends: Vec<_> =
        cuts.iter().map(|cut| cut * stream.len() / 1000).chain([stream.len()]).collect();
    ends.sort_unstable();
    let mut start = 0;
    let pieces = ends.into_iter().map(|end| {
        let piece = &stream[start..end];
        start = end;
        piece
    });
    pieces.collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn dynamixel_instructions(
        packets in vec((0..14_u8, 0..=252_u8, any::<u16>(), any::<u16>(), bytes(60)), 1..8),
        cuts in cuts(),
    ) {
        let packets: Vec<_> = packets
            .into_iter()
            .map(|(kind, id, address, length, data)| (kind, id, Lists { address, length, data }))
            .collect();
        let sent: Vec<_> = packets.iter().map(|(kind, id, lists)| {
            let instruction = instruction(*kind, lists);
            (if instruction.is_group() { BROADCAST } else { *id }, instruction)
        }).collect();
        let stream: Vec<u8> = sent.iter().flat_map(|(id, instruction)| encode(*id, instruction)).collect();
        let mut parser = dynamixel::Parser::<LONGEST>::new();
        let mut expected = sent.iter();
        for mut piece in pieces(&stream, &cuts) {
            while let Some(packet) = parser.next(&mut piece) {
                let (id, instruction) = expected.next().unwrap();
                prop_assert_eq!(packet.id, *id);
                prop_assert_eq!(&Instruction::decode(&packet).unwrap(), instruction);
            }
        }
        prop_assert!(expected.next().is_none());
        prop_assert_eq!(parser.damaged(), 0);
    }

    #[test]
    fn dynamixel_replies(packets in vec((0..=252_u8, any::<u8>(), bytes(60)), 1..8), cuts in cuts()) {
        let stream: Vec<u8> = packets.iter().flat_map(|(id, error, data)| encode_status(*id, *error, data)).collect();
        let mut parser = dynamixel::Parser::<LONGEST>::new();
        let mut expected = packets.iter();
        for mut piece in pieces(&stream, &cuts) {
            while let Some(packet) = parser.next(&mut piece) {
                let status = Status::of(packet).unwrap();
                let (id, error, data) = expected.next().unwrap();
                prop_assert_eq!((status.id, status.error.byte(), status.data), (*id, *error, &data[..]));
            }
        }
        prop_assert!(expected.next().is_none());
    }

    /// All devices answer in turn, after random bytes, split anywhere.
    #[test]
    fn fast_replies(
        rubbish in bytes(20),
        parts in vec((0..=252_u8, any::<u8>(), bytes(12)), 1..8),
        cuts in cuts(),
        torn in 0..=1000_usize,
    ) {
        let lengths: Vec<u16> = parts.iter().map(|(.., data)| u16::try_from(data.len()).unwrap()).collect();
        let mut said = Vec::new();
        for (index, (id, error, data)) in parts.iter().enumerate() {
            let mut turn = FastTurn::new(lengths[..index].iter().copied(), lengths.iter().copied());
            for byte in &said {
            turn.hear(*byte);
        }
            prop_assert!(turn.is_due());
            let mut out = [0; 64];
            let len = turn.encode(&Status { id: *id, error: StatusError::from_byte(*error), data }, &mut out).unwrap();
            said.extend_from_slice(&out[..len]);
        }
        prop_assert_eq!(said.len(), answer_len(lengths.iter().copied()));
        let whole = said.len() * torn / 1000;
        let stream = [&rubbish[..], &said[..whole]].concat();
        let mut reader = FastReader::<16>::new(said.len());
        let (mut next, mut end) = (0, 8);
        for mut piece in pieces(&stream, &cuts) {
            while let Some((id, error, data)) = parts.get(next) {
                let Some(status) = reader.next(*id, lengths[next], &mut piece) else { break };
                prop_assert_eq!((status.id, status.error.byte(), status.data), (*id, *error, &data[..]));
                end += data.len() + 4;
                next += 1;
            }
        }
        // All parts before the interruption were read, and no part after it.
        prop_assert!(next == parts.len() || whole < end + parts[next].2.len() + 4);
        prop_assert!(whole >= end || next == 0);
    }

    #[test]
    fn feetech_instructions(
        packets in vec((0..9_u8, 0..=253_u8, any::<u16>(), any::<u16>(), bytes(60)), 1..8),
        cuts in cuts(),
    ) {
        let packets: Vec<_> = packets
            .into_iter()
            .map(|(kind, id, address, length, data)| (kind, id, Lists { address, length, data }))
            .collect();
        let mut stream = Vec::new();
        let mut sent = Vec::new();
        for (kind, id, lists) in &packets {
            let id = if *kind >= 7 { feetech::BROADCAST } else { *id };
            let instruction = feetech_instruction(*kind, lists);
            let mut out = [0; 128];
            // Instructions that open the EEPROM or move the middle are refused.
            if let Ok(len) = instruction.encode(Family::Sts, id, &mut out) {
                stream.extend_from_slice(&out[..len]);
                sent.push((id, instruction));
            }
        }
        let mut parser = feetech::Parser::<259>::new();
        let mut expected = sent.iter();
        for mut piece in pieces(&stream, &cuts) {
            while let Some(packet) = parser.next(&mut piece) {
                let (id, instruction) = expected.next().unwrap();
                prop_assert_eq!(packet.id, *id);
                prop_assert_eq!(&feetech::Instruction::decode(&packet).unwrap(), instruction);
            }
        }
        prop_assert!(expected.next().is_none());
    }

    /// The places where a stream is split do not change the result, whatever the stream contains.
    #[test]
    fn splits_do_not_matter(stream in bytes(400), cuts in cuts()) {
        fn parse<'a>(pieces: impl IntoIterator<Item = &'a [u8]>) -> Vec<(u8, u8, Vec<u8>)> {
            let mut parser = dynamixel::Parser::<64>::new();
            let mut found = Vec::new();
            for mut piece in pieces {
                while let Some(packet) = parser.next(&mut piece) {
                    found.push((packet.id, packet.instruction, packet.params.to_vec()));
                }
            }
            while let Some(packet) = parser.flush() {
                found.push((packet.id, packet.instruction, packet.params.to_vec()));
            }
            found
        }
        prop_assert_eq!(parse([&stream[..]]), parse(pieces(&stream, &cuts)));
        prop_assert_eq!(parse([&stream[..]]), parse(stream.chunks(1)));
    }

    /// No stream of bytes makes a device fail, or answer with more than its buffer holds.
    #[test]
    fn devices_take_anything(stream in bytes(600), packets in vec((0..14_u8, bytes(40)), 0..6)) {
        let table = Table::of(1200, 52).unwrap();
        let mut memory = vec![0; table.size()];
        let mut device = dynamixel::Device::<256>::new(table, 1, &mut memory);
        let mut feetech_memory = [0; 256];
        let feetech_table = feetech::Table::of("STS3215").unwrap();
        let mut feetech_device = feetech::Device::new(feetech_table, 1, &mut feetech_memory);
        let mut chip = pca9685::Device::new(25e6);
        let mut out = [0; 300];
        device.hear(&stream);
        feetech_device.hear(&stream);
        chip.write(&stream);
        chip.read(&mut out);
        for (kind, data) in &packets {
            let lists = Lists { address: u16::from(data.first().copied().unwrap_or(7)), length: 4, data: data.clone() };
            let instruction = instruction(*kind, &lists);
            device.hear(&encode(if instruction.is_group() { BROADCAST } else { 1 }, &instruction));
            device.speak(&mut out);
            let mut packet = [0; 128];
            let written = feetech_instruction(kind % 9, &lists).encode(Family::Sts, 1, &mut packet);
            feetech_device.hear(&packet[..written.unwrap_or(0)]);
            feetech_device.speak(&mut out);
        }
        device.silence();
        feetech_device.silence();
        prop_assert!(device.speak(&mut out) <= 256);
        prop_assert!((0..20).all(|channel| chip.pulse_us(channel).is_none_or(f32::is_finite)));
    }
}
