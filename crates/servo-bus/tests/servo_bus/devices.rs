//! Tests the answers of simulated servos against the text of the protocols.

use sinew_servo_bus::dynamixel::table::{Table, address};
use sinew_servo_bus::dynamixel::{
    self, BROADCAST, ErrorCode, Event, Instruction, ResetScope, Span, Status,
};
use sinew_servo_bus::feetech::{self, Family};
use sinew_servo_bus::{BusDevice, Line};

type Device<'m> = dynamixel::Device<'m, 512>;

/// A reply: id, error byte, data.
type Reply = (u8, u8, Vec<u8>);

fn new(memory: &mut Vec<u8>, id: u8) -> Device<'_> {
    let table = Table::of(1200, 52).unwrap();
    memory.resize(table.size(), 0);
    Device::new(table, id, memory)
}

fn say<D: BusDevice>(devices: &mut [D], bytes: &[u8]) -> (Vec<u8>, u32) {
    let (mut said, mut waited_us) = (Vec::new(), 0);
    let mut answer = |bytes: &[u8], delay_us| {
        said.extend_from_slice(bytes);
        waited_us += delay_us;
    };
    let mut line = Line::new(devices);
    line.exchange(bytes, &mut [0; 512], &mut answer);
    line.silence(&mut [0; 512], &mut answer);
    (said, waited_us)
}

fn ask(devices: &mut [Device<'_>], id: u8, instruction: Instruction<'_>) -> Vec<Reply> {
    let mut out = [0; 256];
    let len = match instruction {
        Instruction::FactoryReset(scope) => dynamixel::factory_reset(id, scope, &mut out),
        _ => instruction.encode(id, &mut out),
    };
    let (said, _) = say(devices, &out[..len.unwrap()]);
    let mut parser = dynamixel::Parser::<512>::new();
    let (mut input, mut replies) = (&said[..], Vec::new());
    while let Some(packet) = parser.next(&mut input) {
        let status = Status::of(packet).unwrap();
        replies.push((status.id, status.error.byte(), status.data.to_vec()));
    }
    assert_eq!(parser.damaged(), 0);
    replies
}

fn write(devices: &mut [Device<'_>], address: u16, data: &[u8]) -> Option<ErrorCode> {
    let replies = ask(devices, 1, Instruction::Write { address, data });
    assert_eq!(replies.len(), 1);
    dynamixel::StatusError::from_byte(replies[0].1).code()
}

#[test]
fn writes_are_checked() {
    let mut memory = Vec::new();
    let mut devices = [new(&mut memory, 1)];
    let goal = |position: i32| position.to_le_bytes();
    assert_eq!(write(&mut devices, 116, &goal(3000)), None);
    assert_eq!(write(&mut devices, 116, &goal(4096)), Some(ErrorCode::DataLimit));
    assert_eq!(write(&mut devices, 116, &goal(-1)), Some(ErrorCode::DataLimit));
    assert_eq!(write(&mut devices, 102, &1751_i16.to_le_bytes()), Some(ErrorCode::DataLimit));
    assert_eq!(write(&mut devices, 116, &[1, 2]), Some(ErrorCode::DataLength));
    assert_eq!(write(&mut devices, 118, &[1, 2]), Some(ErrorCode::DataLength));
    assert_eq!(write(&mut devices, 132, &goal(0)), Some(ErrorCode::Access));
    assert_eq!(write(&mut devices, 66, &[0]), Some(ErrorCode::Access));
    assert_eq!(write(&mut devices, 64, &[2]), Some(ErrorCode::DataRange));
    assert_eq!(write(&mut devices, 9, &[255]), Some(ErrorCode::DataRange));
    assert_eq!(devices[0].memory().get(address::GOAL_POSITION), 3000);

    // A write of several registers is executed completely or not at all.
    let block = [&[0, 0][..], &[100, 0], &[0; 12], &goal(2000), &[0]].concat();
    assert_eq!(write(&mut devices, 100, &block[..20]), None);
    assert_eq!(
        write(&mut devices, 100, &block),
        Some(ErrorCode::Access),
        "its last byte is Realtime Tick"
    );
    assert_eq!(devices[0].memory().get(address::GOAL_CURRENT), 100);

    // EEPROM cannot be written while torque is on.
    assert_eq!(write(&mut devices, 9, &[1]), None);
    assert_eq!(write(&mut devices, 64, &[1]), None);
    assert_eq!(write(&mut devices, 9, &[2]), Some(ErrorCode::Access));
    assert_eq!(write(&mut devices, 84, &900_u16.to_le_bytes()), None);
    assert_eq!(devices[0].memory().get(address::RETURN_DELAY), 1);
}

#[test]
fn reads_errors_and_the_alert() {
    let mut memory = Vec::new();
    let mut devices = [new(&mut memory, 1)];
    devices[0].memory_mut().set(address::PRESENT_POSITION, -2);
    let read = |address, length| Instruction::Read { address, length };
    assert_eq!(ask(&mut devices, 1, read(132, 4)), [(1, 0, vec![0xFE, 0xFF, 0xFF, 0xFF])]);
    assert_eq!(ask(&mut devices, 1, read(500, 4)), [(1, 7, vec![])]);
    assert_eq!(ask(&mut devices, 1, read(66, 1)), [(1, 7, vec![])]);
    assert_eq!(ask(&mut devices, 1, read(0, 147))[0].2.len(), 147);
    assert_eq!(ask(&mut devices, 2, read(132, 4)), []);
    devices[0].memory_mut().set(address::HARDWARE_ERROR, 1);
    assert_eq!(ask(&mut devices, 1, read(70, 1)), [(1, 0x80, vec![1])]);
    assert_eq!(write(&mut devices, 66, &[0]), Some(ErrorCode::Access));
    // Only a reboot clears the error.
    assert_eq!(ask(&mut devices, 1, Instruction::Reboot), [(1, 0x80, vec![])]);
    assert_eq!(ask(&mut devices, 1, Instruction::Ping), [(1, 0, vec![0xB0, 0x04, 52])]);
}

#[test]
fn status_levels_and_delays() {
    let mut memory = Vec::new();
    let mut devices = [new(&mut memory, 1)];
    let read = Instruction::Read { address: 132, length: 4 };
    let led = Instruction::Write { address: 65, data: &[1] };
    for (level, answers) in [(0, [1, 0, 0]), (1, [1, 1, 0]), (2, [1, 1, 1])] {
        devices[0].memory_mut().set(address::STATUS_LEVEL, level);
        let found = [Instruction::Ping, read, led]
            .map(|instruction| ask(&mut devices, 1, instruction).len());
        assert_eq!(found, answers, "level {level}");
        assert_eq!(ask(&mut devices, BROADCAST, led), []);
    }
    let mut out = [0; 32];
    let len = Instruction::Ping.encode(1, &mut out).unwrap();
    assert_eq!(say(&mut devices, &out[..len]).1, 500, "the factory's return delay");
}

#[test]
fn damaged_and_unknown_packets_are_told() {
    let mut memory = Vec::new();
    let mut devices = [new(&mut memory, 1)];
    let crc = [0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x03, 0x00, 0x01, 0x19, 0x4F];
    assert_eq!(say(&mut devices, &crc).0, [0xFF, 0xFF, 0xFD, 0, 1, 4, 0, 0x55, 3, 0xAB, 0x0C]);
    let mut out = [0; 32];
    let frame = dynamixel::FrameWriter::new(&mut out, 1, 0x77);
    let len = frame.finish().unwrap();
    let (said, _) = say(&mut devices, &out[..len]);
    assert_eq!(said[8], ErrorCode::Instruction.number());
    // A cut packet is not answered, and does not disturb the next packet.
    assert!(say(&mut devices, &crc[..9]).0.is_empty());
    assert_eq!(ask(&mut devices, 1, Instruction::Ping).len(), 1);
}

#[test]
fn registered_writes_wait_for_action() {
    let (mut one, mut two) = (Vec::new(), Vec::new());
    let mut devices = [new(&mut one, 1), new(&mut two, 2)];
    assert_eq!(ask(&mut devices, 1, Instruction::Action), [(1, 2, vec![])]);
    for id in [1, 2] {
        let goal = Instruction::RegWrite { address: 116, data: &[id, 1, 0, 0] };
        assert_eq!(ask(&mut devices, id, goal), [(id, 0, vec![])]);
    }
    assert_eq!(
        ask(&mut devices, 1, Instruction::Read { address: 69, length: 1 }),
        [(1, 0, vec![1])]
    );
    assert_eq!(devices[0].memory().get(address::GOAL_POSITION), 0);
    assert_eq!(ask(&mut devices, BROADCAST, Instruction::Action), []);
    let goals = [0, 1].map(|device: usize| devices[device].memory().get(address::GOAL_POSITION));
    assert_eq!(goals, [257, 258]);
    assert_eq!(devices[0].memory().get(address::REGISTERED), 0);
    let too_far = Instruction::RegWrite { address: 116, data: &[0, 0, 1, 0] };
    assert_eq!(ask(&mut devices, 1, too_far), [(1, 6, vec![])]);
}

#[test]
fn several_answer_in_the_order_of_the_list() {
    let mut memories = vec![Vec::new(); 3];
    let mut devices: Vec<_> =
        memories.iter_mut().zip([1, 2, 3]).map(|(memory, id)| new(memory, id)).collect();
    let ids = |replies: Vec<Reply>| replies.into_iter().map(|(id, ..)| id).collect::<Vec<_>>();
    let span = |ids| Span { address: 6, length: 2, ids };
    assert_eq!(ids(ask(&mut devices, BROADCAST, Instruction::Ping)), [1, 2, 3]);
    assert_eq!(
        ids(ask(&mut devices, BROADCAST, Instruction::SyncRead(span(&[3, 1, 2])))),
        [3, 1, 2]
    );
    // Servo 9 is absent: the servo after it answers after a silence.
    assert_eq!(ids(ask(&mut devices, BROADCAST, Instruction::SyncRead(span(&[3, 9, 2])))), [3, 2]);
    let bulk = [2, 6, 0, 1, 0, 1, 7, 0, 1, 0];
    let replies = ask(&mut devices, BROADCAST, Instruction::BulkRead(&bulk));
    assert_eq!(replies, [(2, 0, vec![52]), (1, 0, vec![1])]);

    let mut out = [0; 64];
    let mut fast = |instruction: Instruction<'_>, devices: &mut Vec<Device<'_>>| {
        let len = instruction.encode(BROADCAST, &mut out).unwrap();
        say(devices, &out[..len]).0
    };
    let said = fast(Instruction::FastSyncRead(span(&[3, 1, 2])), &mut devices);
    assert_eq!(
        (said.len(), &said[..8]),
        (8 + 3 * 6, &[0xFF, 0xFF, 0xFD, 0, 0xFE, 19, 0, 0x55][..])
    );
    assert_eq!([said[8], said[9], said[10], said[11]], [0, 3, 52, 3]);
    assert_eq!(dynamixel::crc::Crc::of(&said[..24]).to_le_bytes(), said[24..]);
    let said = fast(Instruction::FastBulkRead(&bulk), &mut devices);
    assert_eq!((said.len(), said[9], said[14]), (8 + 2 * 5, 2, 1));
    // If the first servo is dead, all servos after it are silent.
    assert!(fast(Instruction::FastSyncRead(span(&[9, 1, 2])), &mut devices).is_empty());
    assert_eq!(fast(Instruction::FastSyncRead(span(&[1, 9, 2])), &mut devices).len(), 8 + 6);
    // The next packet is still received.
    assert_eq!(
        ids(ask(&mut devices, BROADCAST, Instruction::SyncRead(span(&[1, 2, 3])))),
        [1, 2, 3]
    );
}

#[test]
fn writes_for_several() {
    let mut memories = vec![Vec::new(); 2];
    let mut devices: Vec<_> =
        memories.iter_mut().zip([1, 2]).map(|(memory, id)| new(memory, id)).collect();
    let sync = Instruction::SyncWrite { address: 65, length: 1, blocks: &[2, 1, 9, 1] };
    assert_eq!(ask(&mut devices, BROADCAST, sync), []);
    let leds = |devices: &[Device<'_>]| [devices[0].memory().get(65), devices[1].memory().get(65)];
    assert_eq!(leds(&devices), [0, 1]);
    let bulk = Instruction::BulkWrite(&[2, 65, 0, 1, 0, 0, 1, 65, 0, 1, 0, 1]);
    assert_eq!(ask(&mut devices, BROADCAST, bulk), []);
    assert_eq!(leds(&devices), [1, 0]);
    // A servo obeys its second id, but does not answer it.
    for device in &mut devices {
        device.memory_mut().set(address::SECONDARY_ID, 7);
    }
    assert_eq!(ask(&mut devices, 7, Instruction::Write { address: 65, data: &[1] }), []);
    assert_eq!(leds(&devices), [1, 1]);
}

#[test]
fn ids_bauds_and_resets() {
    let mut memory = Vec::new();
    let mut devices = [new(&mut memory, 1)];
    assert_eq!(devices[0].baud(), 57_600);
    assert_eq!(write(&mut devices, 8, &[4]), None);
    assert_eq!(devices[0].baud(), 2_000_000);
    assert_eq!(write(&mut devices, 7, &[5]), None, "the old id answers");
    assert_eq!(ask(&mut devices, 1, Instruction::Ping), []);
    let reset = |scope| Instruction::FactoryReset(scope);
    assert_eq!(ask(&mut devices, 5, reset(ResetScope::ButIdAndBaud)), [(5, 0, vec![])]);
    assert_eq!((ask(&mut devices, 5, Instruction::Ping).len(), devices[0].baud()), (1, 2_000_000));
    assert_eq!(ask(&mut devices, 5, reset(ResetScope::ButId)).len(), 1);
    assert_eq!((ask(&mut devices, 5, Instruction::Ping).len(), devices[0].baud()), (1, 57_600));
    assert_eq!(ask(&mut devices, 5, reset(ResetScope::All)).len(), 1);
    assert_eq!(ask(&mut devices, 1, Instruction::Ping).len(), 1);
    let events: Vec<_> = std::iter::from_fn(|| devices[0].next_event()).collect();
    assert_eq!(events[0], Event::Written { address: 8, length: 1 });
    assert_eq!(events[2..], [Event::FactoryReset; 3]);
}

#[test]
fn a_reboot_forgets_ram_and_keeps_eeprom() {
    let mut memory = Vec::new();
    let mut devices = [new(&mut memory, 1)];
    assert_eq!(write(&mut devices, 48, &3000_u32.to_le_bytes()), None);
    assert_eq!(write(&mut devices, 64, &[1]), None);
    assert_eq!(ask(&mut devices, 1, Instruction::Reboot).len(), 1);
    let memory = devices[0].memory();
    assert_eq!((memory.get(address::TORQUE_ENABLE), memory.get(address::MAX_POSITION)), (0, 3000));
}

#[test]
fn modes_turns_and_gains() {
    let mut memory = Vec::new();
    let mut devices = [new(&mut memory, 1)];
    assert_eq!(write(&mut devices, 84, &999_u16.to_le_bytes()), None);
    assert_eq!(write(&mut devices, 11, &[4]), None);
    assert_eq!(
        devices[0].memory().get(address::POSITION_P),
        400,
        "a change of mode sets gains back"
    );
    assert_eq!(write(&mut devices, 116, &100_000_i32.to_le_bytes()), None);
    assert_eq!(write(&mut devices, 116, &1_048_576_i32.to_le_bytes()), Some(ErrorCode::DataRange));
    devices[0].memory_mut().set(address::PRESENT_POSITION, -5000);
    devices[0].memory_mut().set(address::MOVING, 1);
    assert_eq!(ask(&mut devices, 1, Instruction::ClearTurns), [(1, 1, vec![])]);
    devices[0].memory_mut().set(address::MOVING, 0);
    assert_eq!(ask(&mut devices, 1, Instruction::ClearTurns), [(1, 0, vec![])]);
    assert_eq!(devices[0].memory().get(address::PRESENT_POSITION), 3192);
}

#[test]
fn the_bus_watchdog_runs_out() {
    let mut memory = Vec::new();
    let mut devices = [new(&mut memory, 1)];
    assert_eq!(write(&mut devices, 98, &[5]), None);
    devices[0].pass_time(200_000);
    assert_eq!(devices[0].memory().get(address::BUS_WATCHDOG), 5, "torque is off");
    assert_eq!(write(&mut devices, 64, &[1]), None);
    devices[0].pass_time(100_000);
    assert_eq!(devices[0].memory().get(address::BUS_WATCHDOG), 5);
    // Any instruction restarts the watchdog, also an instruction to another servo.
    assert_eq!(ask(&mut devices, 9, Instruction::Ping), []);
    devices[0].pass_time(100_001);
    assert_eq!(
        ask(&mut devices, 1, Instruction::Read { address: 98, length: 1 }),
        [(1, 0, vec![0xFF])]
    );
    assert_eq!(write(&mut devices, 116, &[0; 4]), Some(ErrorCode::DataRange));
    assert_eq!(write(&mut devices, 98, &[5]), Some(ErrorCode::DataRange));
    assert_eq!(write(&mut devices, 98, &[0]), None);
    assert_eq!(write(&mut devices, 116, &[0; 4]), None);
}

#[test]
fn indirect_data_lead_elsewhere() {
    let mut memory = Vec::new();
    let mut devices = [new(&mut memory, 1)];
    let pointers: Vec<u8> =
        [126, 127, 132, 133, 134, 135, 146].iter().flat_map(|to: &u16| to.to_le_bytes()).collect();
    assert_eq!(write(&mut devices, 168, &pointers), None);
    devices[0].memory_mut().set(address::PRESENT_CURRENT, -3);
    devices[0].memory_mut().set(address::PRESENT_POSITION, 0x0102_0304);
    devices[0].memory_mut().set(address::PRESENT_TEMPERATURE, 33);
    let read = Instruction::Read { address: 208, length: 7 };
    assert_eq!(ask(&mut devices, 1, read), [(1, 0, vec![0xFD, 0xFF, 4, 3, 2, 1, 33])]);
    assert_eq!(write(&mut devices, 208, &[0, 0]), Some(ErrorCode::Access));
    let goal: Vec<u8> = (116..120_u16).flat_map(u16::to_le_bytes).collect();
    assert_eq!(write(&mut devices, 168, &goal), None);
    assert_eq!(write(&mut devices, 208, &2500_i32.to_le_bytes()), None);
    assert_eq!(devices[0].memory().get(address::GOAL_POSITION), 2500);
    assert_eq!(write(&mut devices, 208, &5000_i32.to_le_bytes()), Some(ErrorCode::DataLimit));
    assert_eq!(write(&mut devices, 208, &[1, 2]), Some(ErrorCode::DataLength));
    assert_eq!(write(&mut devices, 168, &[63, 0]), Some(ErrorCode::DataRange));
}

fn ask_feetech(
    devices: &mut [feetech::Device<'_>],
    id: u8,
    instruction: feetech::Instruction<'_>,
) -> Vec<Reply> {
    let family = devices[0].table().model.family;
    let mut out = [0; 256];
    let len = instruction.encode(family, id, &mut out).unwrap();
    listen_feetech(devices, &out[..len])
}

fn listen_feetech(devices: &mut [feetech::Device<'_>], bytes: &[u8]) -> Vec<Reply> {
    let (said, _) = say(devices, bytes);
    let mut parser = feetech::Parser::<259>::new();
    let (mut input, mut replies) = (&said[..], Vec::new());
    while let Some(packet) = parser.next(&mut input) {
        let status = feetech::Status::of(packet).unwrap();
        replies.push((status.id, status.bits, status.data.to_vec()));
    }
    replies
}

#[test]
fn feetech_servos() {
    use feetech::Instruction::{Action, Ping, Read, Reboot, RegWrite, SyncRead, Write};
    let table = feetech::Table::of("sts3215").unwrap();
    let mut memories = vec![[0; 256]; 3];
    let mut devices: Vec<_> = memories
        .iter_mut()
        .zip([1, 2, 3])
        .map(|(memory, id)| feetech::Device::new(table, id, memory))
        .collect();
    assert_eq!(ask_feetech(&mut devices, 2, Ping), [(2, 0, vec![])]);
    assert_eq!(
        ask_feetech(&mut devices, 1, Read { address: 3, length: 3 }),
        [(1, 0, vec![9, 3, 1])]
    );
    // A value written to EEPROM with the lock shut is lost at a reboot.
    assert_eq!(ask_feetech(&mut devices, 1, Write { address: 13, data: &[60] }), [(1, 0, vec![])]);
    assert_eq!(devices[0].get(13), 60);
    assert_eq!(ask_feetech(&mut devices, 1, Reboot), []);
    assert_eq!(devices[0].get(13), 70);
    let mut out = [0; 16];
    let len = feetech::open_eeprom(Family::Sts, 1, &mut out).unwrap();
    assert_eq!(listen_feetech(&mut devices, &out[..len]).len(), 1);
    assert_eq!(ask_feetech(&mut devices, 1, Write { address: 13, data: &[60] }).len(), 1);
    assert_eq!(ask_feetech(&mut devices, 1, Reboot), []);
    assert_eq!((devices[0].get(13), devices[0].get(55)), (60, 1), "stored, and shut again");
    // A goal position switches torque on; a measured value cannot be written.
    assert_eq!(ask_feetech(&mut devices, 1, Write { address: 42, data: &[0xE8, 0x83] }).len(), 1);
    assert_eq!((devices[0].get(40), devices[0].get(42)), (1, -1000));
    assert_eq!(ask_feetech(&mut devices, 1, Write { address: 56, data: &[1, 1] }).len(), 1);
    assert_eq!(devices[0].get(56), 0);
    assert_eq!(ask_feetech(&mut devices, 2, RegWrite { address: 42, data: &[7, 0] }).len(), 1);
    assert_eq!((devices[1].get(42), devices[1].get(64)), (0, 1));
    assert_eq!(ask_feetech(&mut devices, feetech::BROADCAST, Action), []);
    assert_eq!((devices[1].get(42), devices[1].get(64)), (7, 0));
    let read = |ids| SyncRead { address: 5, length: 1, ids };
    let all = ask_feetech(&mut devices, feetech::BROADCAST, read(&[3, 1, 2]));
    assert_eq!(all, [(3, 0, vec![3]), (1, 0, vec![1]), (2, 0, vec![2])]);
    let present = ask_feetech(&mut devices, feetech::BROADCAST, read(&[3, 9, 2]));
    assert_eq!(present, [(3, 0, vec![3]), (2, 0, vec![2])]);
    let len = feetech::set_middle(3, &mut out).unwrap();
    assert_eq!(listen_feetech(&mut devices, &out[..len]).len(), 1);
    assert_eq!(
        (devices[2].next_event(), devices[2].get(40)),
        (Some(feetech::Event::PositionSet(2048)), 0)
    );
    devices[0].set(8, 0);
    assert_eq!(ask_feetech(&mut devices, 1, Write { address: 42, data: &[0, 0] }), []);
    devices[0].set(65, i32::from(feetech::status_bit::OVERLOAD));
    assert_eq!(ask_feetech(&mut devices, 1, Ping), [(1, 0x20, vec![])]);
}
