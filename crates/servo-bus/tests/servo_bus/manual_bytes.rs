//! Writes and reads packets as the makers' manuals print them. A comment marks each packet that is not printed
//! anywhere.

use sinew_servo_bus::dynamixel::fast::{FastReader, FastTurn, answer_len};
use sinew_servo_bus::dynamixel::group::{BulkEntry, BulkWriter, SyncWriter, bulk_entries};
use sinew_servo_bus::dynamixel::{
    self, BROADCAST, ErrorCode, Instruction, ResetScope, Span, Status, StatusError,
};
use sinew_servo_bus::feetech::{self, Family};
use sinew_servo_bus::{EncodeError, dynamixel as dxl};

fn hex(text: &str) -> Vec<u8> {
    text.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect()
}

fn check_instruction(id: u8, instruction: Instruction<'_>, bytes: &str) {
    let mut out = [0; 64];
    let len = match instruction {
        Instruction::FactoryReset(scope) => dynamixel::factory_reset(id, scope, &mut out).unwrap(),
        _ => instruction.encode(id, &mut out).unwrap(),
    };
    assert_eq!(out[..len], hex(bytes), "{instruction:?}");
    let mut parser = dxl::Parser::<64>::new();
    let packet = parser.next(&mut &out[..len]).unwrap();
    assert_eq!((packet.id, Instruction::decode(&packet)), (id, Ok(instruction)));
}

fn check_status(status: Status<'_>, bytes: &str) {
    let mut out = [0; 64];
    let len = status.encode(&mut out).unwrap();
    assert_eq!(out[..len], hex(bytes));
    let mut parser = dxl::Parser::<64>::new();
    assert_eq!(Status::of(parser.next(&mut &out[..len]).unwrap()), Some(status));
}

/// Source: e-manual, "Protocol 2.0". The packets for the fast read, torque off and the watchdog are computed from its
/// rules.
#[test]
fn dynamixel_instructions() {
    let position = |ids| Span { address: 132, length: 4, ids };
    check_instruction(1, Instruction::Ping, "FF FF FD 00 01 03 00 01 19 4E");
    check_instruction(BROADCAST, Instruction::Ping, "FF FF FD 00 FE 03 00 01 31 42");
    let read = Instruction::Read { address: 132, length: 4 };
    check_instruction(1, read, "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15");
    let write = Instruction::Write { address: 116, data: &[0, 2, 0, 0] };
    check_instruction(1, write, "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89");
    let register = Instruction::RegWrite { address: 104, data: &[200, 0, 0, 0] };
    check_instruction(1, register, "FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E");
    check_instruction(1, Instruction::Action, "FF FF FD 00 01 03 00 05 02 CE");
    let reset = Instruction::FactoryReset(ResetScope::ButId);
    check_instruction(1, reset, "FF FF FD 00 01 04 00 06 01 A1 E6");
    check_instruction(1, Instruction::Reboot, "FF FF FD 00 01 03 00 08 2F 4E");
    check_instruction(1, Instruction::ClearTurns, "FF FF FD 00 01 08 00 10 01 44 58 4C 22 B1 DC");
    let sync = Instruction::SyncRead(position(&[1, 2]));
    check_instruction(BROADCAST, sync, "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA");
    let fast = Instruction::FastSyncRead(position(&[3, 7, 4]));
    check_instruction(BROADCAST, fast, "FF FF FD 00 FE 0A 00 8A 84 00 04 00 03 07 04 20 F2");
    let torque_off = Instruction::Write { address: 64, data: &[0] };
    check_instruction(BROADCAST, torque_off, "FF FF FD 00 FE 06 00 03 40 00 00 2E 16");
    let watchdog = Instruction::Write { address: 98, data: &[5] };
    check_instruction(1, watchdog, "FF FF FD 00 01 06 00 03 62 00 05 68 E4");
    let bulk = [0x01, 0x90, 0x00, 0x02, 0x00, 0x02, 0x92, 0x00, 0x01, 0x00];
    let printed = "FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05";
    check_instruction(BROADCAST, Instruction::BulkRead(&bulk), printed);
    let entry = BulkEntry { id: 2, address: 146, length: 1 };
    assert_eq!((bulk_entries(&bulk).last(), &entry.bytes()[..]), (Some(entry), &bulk[5..]));
}

/// Source: e-manual, "Protocol 2.0".
#[test]
fn dynamixel_writes_for_several_servos() {
    let mut out = [0; 64];
    let mut sync = SyncWriter::new(&mut out, 116, 4);
    sync.push(1, &150_i32.to_le_bytes());
    sync.push(2, &170_i32.to_le_bytes());
    let len = sync.finish().unwrap();
    let printed = "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87";
    assert_eq!(out[..len], hex(printed));
    let mut bulk = BulkWriter::new(&mut out);
    bulk.push(1, 32, &[0xA0, 0x00]);
    bulk.push(2, 31, &[0x50]);
    let len = bulk.finish().unwrap();
    let printed = "FF FF FD 00 FE 10 00 93 01 20 00 02 00 A0 00 02 1F 00 01 00 50 B7 68";
    assert_eq!(out[..len], hex(printed));
}

/// Source: e-manual, "Protocol 2.0"; the last three packets are computed from its rules.
#[test]
fn dynamixel_replies() {
    let status = |id, error, data| Status { id, error: StatusError::from_byte(error), data };
    check_status(status(1, 0, &[0x06, 0x04, 0x26]), "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D");
    check_status(status(2, 0, &[0x06, 0x04, 0x26]), "FF FF FD 00 02 07 00 55 00 06 04 26 6F 6D");
    check_status(status(1, 0, &[0xA6, 0, 0, 0]), "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0");
    check_status(status(2, 0, &[0x1F, 0x08, 0, 0]), "FF FF FD 00 02 08 00 55 00 1F 08 00 00 BA BE");
    check_status(status(1, 0, &[0x77, 0]), "FF FF FD 00 01 06 00 55 00 77 00 C3 69");
    check_status(status(2, 0, &[0x24]), "FF FF FD 00 02 05 00 55 00 24 8B A9");
    check_status(status(1, 0, &[]), "FF FF FD 00 01 04 00 55 00 A1 0C");
    check_status(status(1, 7, &[]), "FF FF FD 00 01 04 00 55 07 B0 8C");
    check_status(status(1, 0x84, &[]), "FF FF FD 00 01 04 00 55 84 B9 0F");
    let error = StatusError::from_byte(0x84);
    assert_eq!((error.alert(), error.code()), (true, Some(ErrorCode::DataRange)));
}

/// Stuffed packets, computed from the rules of the e-manual; and a header that begins late, as in the tests of
/// `rustypot`.
#[test]
fn dynamixel_stuffing() {
    let write = Instruction::Write { address: 116, data: &[0xFF, 0xFF, 0xFD, 0] };
    check_instruction(1, write, "FF FF FD 00 01 0A 00 03 74 00 FF FF FD FD 00 21 E7");
    let status = Status { id: 1, error: StatusError::NONE, data: &[0xFF, 0xFF, 0xFD, 0xA6] };
    check_status(status, "FF FF FD 00 01 09 00 55 00 FF FF FD FD A6 0C 9F");
    let mut out = [0; 64];
    let late =
        Instruction::Write { address: 0, data: &[0xFF, 0xFF, 0xFF, 0xFD, 0xFD, 0xFF, 0xFF, 0xFD] };
    let len = late.encode(1, &mut out).unwrap();
    assert_eq!(out[10..len - 2], hex("FF FF FF FD FD FD FF FF FD FD"));
}

/// Python's `dynamixel-sdk` 4.1.0 writes the data FF FF FD 00 without stuffing. Our parser leaves them unchanged.
#[test]
fn unstuffed_data_are_taken_as_they_stand() {
    let mut bytes = hex("FF FF FD 00 01 09 00 03 74 00 FF FF FD 00");
    bytes.extend(dynamixel::crc::Crc::of(&bytes).to_le_bytes());
    let mut parser = dxl::Parser::<64>::new();
    let packet = parser.next(&mut &bytes[..]).unwrap();
    let write = Instruction::Write { address: 116, data: &[0xFF, 0xFF, 0xFD, 0] };
    assert_eq!(Instruction::decode(&packet), Ok(write));
}

/// Source: e-manual, as `rustypot` 1.13.1 cites it in its tests of protocol 2.
#[test]
fn fast_sync_read() {
    let blocks = [
        (3, "00 03 A6 00 00 00 84 08"),
        (7, "00 07 1F 08 00 00 16 CA"),
        (4, "00 04 FF 03 00 00 D1 9E"),
    ];
    let head = hex("FF FF FD 00 FE 19 00 55");
    let answer: Vec<u8> =
        head.iter().copied().chain(blocks.iter().flat_map(|(_, block)| hex(block))).collect();
    assert_eq!(answer_len([4; 3].into_iter()), answer.len());

    let mut input = &answer[..];
    let mut reader = FastReader::<16>::new(answer.len());
    let values = [166, 2079, 1023];
    for ((id, _), value) in blocks.iter().zip(values) {
        let status = reader.next(*id, 4, &mut input).unwrap();
        assert_eq!((status.id, status.data), (*id, &u32::to_le_bytes(value)[..]));
    }

    let mut said = Vec::new();
    for (index, (id, _)) in blocks.iter().enumerate() {
        let mut turn = FastTurn::new([4_u16; 3].into_iter().take(index), [4; 3].into_iter());
        for byte in &said {
            turn.hear(*byte);
        }
        assert!(turn.is_due());
        let data = u32::to_le_bytes(values[index]);
        let mut out = [0; 32];
        let status = Status { id: *id, error: StatusError::NONE, data: &data };
        let len = turn.encode(&status, &mut out).unwrap();
        said.extend_from_slice(&out[..len]);
    }
    assert_eq!(said, answer);
}

#[test]
fn what_must_be_asked_for_by_name_is_refused() {
    let mut out = [0; 64];
    let reset = Instruction::FactoryReset(ResetScope::All);
    assert_eq!(reset.encode(1, &mut out), Err(EncodeError::OnlyByName("factory_reset")));
    assert_eq!(
        dynamixel::factory_reset(BROADCAST, ResetScope::All, &mut out),
        Err(EncodeError::Id(BROADCAST))
    );
    let read = Instruction::Read { address: 0, length: 2 };
    assert_eq!(read.encode(BROADCAST, &mut out), Err(EncodeError::Id(BROADCAST)));
    for id in [253, 255] {
        assert_eq!(Instruction::Ping.encode(id, &mut out), Err(EncodeError::Id(id)));
    }

    let refused = |address, data| {
        feetech::Instruction::Write { address, data }
            .encode(Family::Sts, 1, &mut [0; 64])
            .unwrap_err()
    };
    assert_eq!(refused(55, &[0]), EncodeError::OnlyByName("open_eeprom"));
    assert_eq!(refused(48, &[1, 1, 0, 0, 0, 0, 0, 0]), EncodeError::OnlyByName("open_eeprom"));
    assert_eq!(refused(40, &[128, 0]), EncodeError::OnlyByName("set_middle"));
    let torque_limit = feetech::Instruction::Write { address: 48, data: &[0, 0] };
    assert!(torque_limit.encode(Family::Sts, 1, &mut out).is_ok());
    let lock = EncodeError::OnlyByName("open_eeprom");
    assert_eq!(torque_limit.encode(Family::Scs, 1, &mut out), Err(lock));
    let sync = feetech::Instruction::SyncWrite { address: 55, length: 1, blocks: &[1, 1, 2, 0] };
    assert_eq!(sync.encode(Family::Sts, BROADCAST, &mut out), Err(lock));
}

fn check_feetech(id: u8, instruction: feetech::Instruction<'_>, bytes: &str) {
    let mut out = [0; 64];
    let len = instruction.encode(Family::Sts, id, &mut out).unwrap();
    assert_eq!(out[..len], hex(bytes), "{instruction:?}");
    let mut parser = feetech::Parser::<64>::new();
    let packet = parser.next(&mut &out[..len]).unwrap();
    assert_eq!((packet.id, feetech::Instruction::decode(&packet)), (id, Some(instruction)));
}

/// Source: Feetech's protocol manual, as in `scs_communication_protocol.md` of vassar-robotics/feetech-servo-sdk; the
/// packets for the sync read and torque off are computed from its rules.
#[test]
fn feetech_packets() {
    use feetech::Instruction::{Action, ClearTurns, Ping, Read, SyncRead, SyncWrite, Write};
    check_feetech(1, Ping, "FF FF 01 02 01 FB");
    check_feetech(1, Read { address: 56, length: 2 }, "FF FF 01 04 02 38 02 BE");
    let goal = [0x00, 0x08, 0x00, 0x00, 0xE8, 0x03];
    check_feetech(1, Write { address: 42, data: &goal }, "FF FF 01 09 03 2A 00 08 00 00 E8 03 D5");
    check_feetech(BROADCAST, Action, "FF FF FE 02 05 FA");
    check_feetech(1, ClearTurns, "FF FF 01 02 0A F2");
    let blocks: Vec<u8> = (1..=4).flat_map(|id| [&[id], &goal[..]].concat()).collect();
    let printed = "FF FF FE 20 83 2A 06 01 00 08 00 00 E8 03 02 00 08 00 00 E8 03 \
                   03 00 08 00 00 E8 03 04 00 08 00 00 E8 03 58";
    check_feetech(BROADCAST, SyncWrite { address: 42, length: 6, blocks: &blocks }, printed);
    let read = SyncRead { address: 56, length: 8, ids: &[1, 2] };
    check_feetech(BROADCAST, read, "FF FF FE 06 82 38 08 01 02 36");
    check_feetech(BROADCAST, Write { address: 40, data: &[0] }, "FF FF FE 04 03 28 00 D2");
    let scs = Write { address: 42, data: &[2, 0, 0, 0, 0, 0] };
    check_feetech(1, scs, "FF FF 01 09 03 2A 02 00 00 00 00 00 C6");

    let mut out = [0; 16];
    for (data, bytes) in
        [(&[][..], "FF FF 01 02 00 FC"), (&[0x18, 0x05], "FF FF 01 04 00 18 05 DD")]
    {
        let status = feetech::Status { id: 1, bits: 0, data };
        let len = status.encode(&mut out).unwrap();
        assert_eq!(out[..len], hex(bytes));
        let mut parser = feetech::Parser::<64>::new();
        assert_eq!(feetech::Status::of(parser.next(&mut &out[..len]).unwrap()), Some(status));
    }
}
