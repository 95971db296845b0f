//! Servo buses: codecs, both sides of a bus line, and a rig's side of each protocol, with arbitrary bytes.

use core::hint::black_box;

use sinew_servo_bus::settings::{self, Mode, ServoRequirements};
use sinew_servo_bus::table::{ByteOrder, Item};
use sinew_servo_bus::{
    BusDevice, Command, Compared, Effort, Line, Plausible, Schedule, ServoBus, Timing, Traffic,
    dynamixel, feetech, pca9685,
};

use super::{slice, slice_mut};

/// Number of servos of a rig.
const SERVOS: usize = 20;

/// Returns the requirements of a rig for a servo's registers.
fn requirements() -> ServoRequirements {
    black_box(ServoRequirements {
        mode: Mode::Current,
        range_rad: [1.0, 2.0],
        torque_nm: 1.0,
        stall_nm: 1.0,
        friction_nm: 1.0,
        torque_constant_nm_a: 1.0,
        shutdown_c: 1.0,
        gain_ratio: 1.0,
    })
}

/// Calls every function of a bus that a rig may call.
fn serve(mut bus: impl ServoBus) {
    let commands = [
        Command::Torque(black_box(true)),
        Command::Position(black_box(1.0)),
        Command::PositionWithin { position_rad: black_box(1.0), current_a: black_box(1.0) },
        Command::PositionAt { position_rad: black_box(1.0), speed_rad_s: black_box(1.0) },
        Command::Current(black_box(1.0)),
        Command::Pwm(black_box(1.0)),
        Command::Stiffness(black_box(1)),
    ];
    for command in black_box(commands) {
        black_box(&bus.command(black_box(1), command));
    }
    bus.compare(black_box(Some((1, requirements()))));
    black_box(&bus.plan(slice_mut()));
    black_box(&bus.plan_more(black_box(1), slice_mut()));
    black_box(bus.reply(slice()));
    if let Compared::Differs(difference) = black_box(bus.compared()) {
        black_box(difference.is_torque());
    }
    black_box(bus.feedback(black_box(1)).map(|feedback| match feedback.effort {
        Effort::Current(effort) | Effort::Load(effort) => effort,
    }));
    black_box((&bus.health(black_box(1)), bus.len(), bus.is_empty()));
}

fn schedule(traffic: &Traffic) -> Option<Schedule> {
    let timing = black_box(Timing { baud: 1, return_delay_us: 1, turnaround_us: 1 });
    black_box((
        timing.request_us(black_box(1), black_box(1)),
        Schedule::fastest_hz(&timing, traffic),
    ));
    let schedule = black_box(Schedule::new(timing, traffic, black_box(1)).ok()?);
    black_box((schedule.tick_us(), schedule.groups(), schedule.busy_us(), schedule.read_hz()));
    black_box((schedule.timing(), schedule.reads(black_box(1), black_box(1))));
    Some(schedule)
}

fn item(item: Option<Item>) {
    let Some(item) = black_box(item) else { return };
    black_box((item.contains(black_box(1)), item.value(slice(), black_box(ByteOrder::Big))));
    black_box(item.bytes(black_box(1), black_box(ByteOrder::Big)));
}

/// Calls every function that simulated devices have on a line.
fn exchange(devices: &mut [impl BusDevice]) {
    let mut line = Line::new(devices);
    line.exchange(slice(), slice_mut(), |bytes, delay_us| _ = black_box((bytes.len(), delay_us)));
    line.silence(slice_mut(), |bytes, delay_us| _ = black_box((bytes.len(), delay_us)));
}

#[inline(never)]
pub(crate) fn dynamixel_bus() {
    use dynamixel::{Bus, Settings, traffic};
    let traffic = traffic(black_box(1), black_box(1), black_box(true)).with_goal(black_box(1));
    let Some(schedule) = schedule(&black_box(traffic)) else { return };
    let settings = black_box(Settings { fast: true, retries: 1 });
    black_box(black_box(dynamixel::Mode::Position).number());
    black_box(dynamixel::table::Model::of_kind(black_box("XL330-M288-T")));
    if let Ok(bus) = Bus::<SERVOS>::new(slice(), schedule, settings) {
        serve(black_box(bus));
    }
}

#[inline(never)]
pub(crate) fn dynamixel_packets() {
    use dynamixel::crc::Crc;
    use dynamixel::{
        ErrorCode, FrameWriter, Instruction, Parser, ResetScope, Status, StatusError, factory_reset,
    };
    let mut parser = black_box(Parser::<300>::new());
    let mut input = slice();
    while let Some(packet) = parser.next(&mut input) {
        if let Ok(instruction) = Instruction::decode(&packet) {
            black_box((instruction.code(), instruction.is_group()));
            black_box(&instruction.encode(black_box(1), slice_mut()));
        }
        if let Some(status) = Status::of(packet) {
            black_box((&status.encode(slice_mut()), status.answers(black_box(1), black_box(1))));
        }
    }
    while let Some(packet) = parser.flush() {
        black_box(packet.id);
    }
    black_box((parser.damaged(), parser.take_damaged()));
    parser.clear();
    black_box(&factory_reset(black_box(1), black_box(ResetScope::All), slice_mut()));
    let error = StatusError::new(black_box(Some(ErrorCode::Crc)), black_box(true));
    black_box((error.byte(), error.alert()));
    black_box(StatusError::from_byte(black_box(1)).code().map(ErrorCode::number));
    let mut frame = FrameWriter::new(slice_mut(), black_box(1), black_box(1));
    frame.push_u16(black_box(1));
    frame.extend(slice());
    black_box((&frame.finish(), Crc::of(slice())));
}

#[inline(never)]
pub(crate) fn dynamixel_groups() {
    use dynamixel::fast::{FastReader, FastTurn, answer_len};
    use dynamixel::group::{
        BulkEntry, BulkWriter, SyncWriter, bulk_blocks, bulk_entries, sync_blocks,
    };
    use dynamixel::{Status, StatusError};
    let mut writer = SyncWriter::new(slice_mut(), black_box(1), black_box(2));
    writer.push(black_box(1), slice());
    black_box(&writer.finish());
    let mut writer = BulkWriter::new(slice_mut());
    writer.push(black_box(1), black_box(1), slice());
    black_box(&writer.finish());
    black_box(bulk_entries(slice()).map(BulkEntry::bytes).last());
    black_box((sync_blocks(slice(), black_box(1)).last(), bulk_blocks(slice()).last()));
    let lengths = || slice::<u16>().iter().copied();
    let mut reader = black_box(FastReader::<40>::new(answer_len(lengths())));
    let mut input = slice();
    while let Some(status) = reader.next(black_box(1), black_box(4), &mut input) {
        black_box(status.data);
    }
    black_box(reader.is_broken());
    let mut turn = black_box(FastTurn::new(lengths(), lengths()));
    turn.hear(black_box(1));
    let status =
        Status { id: black_box(1), error: StatusError::from_byte(black_box(1)), data: slice() };
    black_box((turn.is_first(), turn.is_due(), &turn.encode(&status, slice_mut())));
}

#[inline(never)]
pub(crate) fn dynamixel_device() {
    use dynamixel::Device;
    use dynamixel::table::Table;
    let Some(table) = Table::of(black_box(1200), black_box(52)) else { return };
    item(table.at(black_box(1)));
    item(table.named(black_box("")));
    item(table.items().last());
    black_box((table.size(), &table.indirect()));
    black_box(settings::dynamixel(table, requirements()).last());
    let mut device = black_box(Device::<300>::new(table, black_box(1), slice_mut()));
    device.pass_time(black_box(1));
    device.memory_mut().set(black_box(1), black_box(1));
    device.memory_mut().restrict(slice());
    black_box((device.memory().get(black_box(1)), device.memory().torque_is_on()));
    black_box(device.memory().table());
    black_box((device.baud(), &device.next_event()));
    exchange(&mut [device]);
}

#[inline(never)]
pub(crate) fn feetech_bus() {
    use feetech::{Bus, Family, Settings, traffic};
    let family = black_box(Family::Sts);
    let Some(schedule) = schedule(&black_box(traffic(family, black_box(1)))) else { return };
    black_box(settings::feetech(family, requirements()).last());
    black_box(feetech::Model::of_kind(black_box("STS3215-12V")));
    let settings = black_box(Settings { family, echo: true, retries: 1, speed_counts: 1 });
    if let Ok(bus) = Bus::<SERVOS>::new(slice(), schedule, settings) {
        serve(black_box(bus));
    }
}

#[inline(never)]
pub(crate) fn feetech_packets() {
    use feetech::{
        Family, Instruction, Parser, Status, SyncWriter, factory_reset, open_eeprom, set_middle,
        sync_blocks,
    };
    let family = || black_box(Family::Scs);
    let mut parser = black_box(Parser::<259>::new());
    let mut input = slice();
    while let Some(packet) = parser.next(&mut input) {
        if let Some(instruction) = Instruction::decode(&packet) {
            black_box((instruction.code(), &instruction.encode(family(), 1, slice_mut())));
        }
        if let Some(status) = Status::of(packet) {
            black_box((&status.encode(slice_mut()), status.answers(black_box(1), black_box(1))));
        }
    }
    while let Some(packet) = parser.flush() {
        black_box(packet.id);
    }
    black_box(parser.damaged());
    parser.clear();
    black_box(&open_eeprom(family(), black_box(1), slice_mut()));
    black_box(&set_middle(black_box(1), slice_mut()));
    black_box(&factory_reset(black_box(1), slice_mut()));
    let mut writer = SyncWriter::new(slice_mut(), family(), black_box(1), black_box(2));
    writer.push(black_box(1), slice());
    black_box((&writer.finish(), sync_blocks(slice(), black_box(1)).last()));
    black_box((family().order(), family().lock(), family().most_count(), family().rad_per_count()));
}

#[inline(never)]
pub(crate) fn feetech_device() {
    use feetech::{Device, Table};
    let Some(table) = Table::of(black_box("")) else { return };
    let table = black_box(table.with_phase(black_box(1)));
    item(table.at(black_box(1)));
    item(table.named(black_box("")));
    item(table.items().last());
    let mut device = black_box(Device::new(table, black_box(1), slice_mut()));
    device.set(black_box(1), black_box(1));
    device.restrict(slice());
    black_box((device.get(black_box(1)), device.baud(), &device.next_event(), &device.table()));
    exchange(&mut [device]);
}

#[inline(never)]
pub(crate) fn pca9685() {
    use pca9685::{Bus, Device, Prescale, all_off, start};
    let mut chip = black_box(Device::new(black_box(25e6)));
    chip.write(slice());
    chip.read(slice_mut());
    black_box(chip.pulse_us(black_box(1)));
    let Ok(prescale) = Prescale::new(black_box(25e6), black_box(50.0)) else { return };
    let prescale = black_box(prescale);
    black_box((prescale.divider(), prescale.step_us(), prescale.rate_hz()));
    black_box((start(&prescale).map(|transfer| transfer.bytes().len()), all_off()));
    if let Ok(bus) = Bus::new(slice(), prescale, black_box(1)) {
        serve(black_box(bus));
    }
}

#[inline(never)]
pub(crate) fn readings() {
    let mut plausible = black_box(Plausible::new(black_box([0, 1]), black_box(1)));
    black_box(plausible.accept(black_box(1), black_box(1)));
}
