//! What must hold for any bytes: used by the replay of the corpus, and by the fuzz targets in `../fuzz`.

use sinew_bus::dynamixel::table::{MODELS, Table, address};
use sinew_bus::dynamixel::{self, Instruction, Mode, ServoSetup, Settings, Status};
use sinew_bus::feetech::{self, Family};
use sinew_bus::{BusDevice, Schedule, ServoBus, Timing, pca9685};

/// A decoder and its name.
pub(crate) type Decoder = (&'static str, fn(&[u8]));

/// All decoders, of both sides.
pub(crate) const DECODERS: [Decoder; 5] = [
    ("dynamixel_controller", dynamixel_controller),
    ("dynamixel_servo", dynamixel_servo),
    ("feetech_controller", feetech_controller),
    ("feetech_servo", feetech_servo),
    ("pca9685_chip", pca9685_chip),
];

const TIMING: Timing = Timing { baud: 1_000_000, return_delay_us: 0, turnaround_us: 0 };

/// What is decoded is written as the same bytes again, and what is believed is within bounds.
pub(crate) fn dynamixel_controller(bytes: &[u8]) {
    let mut parser = dynamixel::Parser::<512>::new();
    let mut input = bytes;
    while let Some(packet) = parser.next(&mut input) {
        let mut out = [0; 1024];
        if let Some(status) = Status::of(packet) {
            let len = status.encode(&mut out).unwrap();
            let mut again = dynamixel::Parser::<1024>::new();
            let packet = again.next(&mut &out[..len]).unwrap();
            // A fast answer has the id of all servos, and is not stuffed.
            assert!(packet.id == dynamixel::BROADCAST || Status::of(packet) == Some(status));
        } else if let Ok(instruction) = Instruction::decode(&packet)
            && let Ok(len) = instruction.encode(packet.id, &mut out)
        {
            let mut again = dynamixel::Parser::<1024>::new();
            assert_eq!(
                Instruction::decode(&again.next(&mut &out[..len]).unwrap()),
                Ok(instruction)
            );
        }
    }
    let model = MODELS.iter().find(|model| model.number == 1200).unwrap();
    let setup = |id| ServoSetup {
        id,
        model,
        mode: Mode::Position,
        range_rad: [0.0, 6.0],
        current_a: 1.0,
        pwm: 1.0,
        speed_rad_s: 10.0,
    };
    for fast in [false, true] {
        let schedule = Schedule::new(TIMING, &dynamixel::traffic(2, 4, fast), 100).unwrap();
        let setups = [setup(1), setup(2)];
        let mut bus =
            dynamixel::Bus::<2>::new(&setups, schedule, Settings { fast, retries: 2 }).unwrap();
        drive(&mut bus, bytes);
    }
}

/// Whatever a servo has heard, it answers a ping afterwards.
pub(crate) fn dynamixel_servo(bytes: &[u8]) {
    let table = Table::of(1200, 52).unwrap();
    let mut memory = vec![0; table.size()];
    let mut device = dynamixel::Device::<1024>::new(table, 1, &mut memory);
    device.hear(bytes);
    device.silence();
    let mut out = [0; 1024];
    device.speak(&mut out);
    device.pass_time(3_000_000);
    let id = u8::try_from(device.memory().get(address::ID)).unwrap();
    let len = Instruction::Ping.encode(id, &mut out).unwrap();
    device.hear(&out[..len]);
    assert!(device.due_us().is_some());
    let len = device.speak(&mut out);
    let mut parser = dynamixel::Parser::<64>::new();
    let status = Status::of(parser.next(&mut &out[..len]).unwrap()).unwrap();
    assert!(status.answers(id, 3));
}

/// What is decoded is written as the same bytes again, and what is believed is within bounds.
pub(crate) fn feetech_controller(bytes: &[u8]) {
    let mut parser = feetech::Parser::<259>::new();
    let mut input = bytes;
    while let Some(packet) = parser.next(&mut input) {
        let mut out = [0; 300];
        if let Some(status) = feetech::Status::of(packet) {
            let len = status.encode(&mut out).unwrap();
            let mut again = feetech::Parser::<259>::new();
            assert_eq!(feetech::Status::of(again.next(&mut &out[..len]).unwrap()), Some(status));
        }
    }
    for family in [Family::Sts, Family::Scs] {
        let schedule = Schedule::new(TIMING, &feetech::traffic(family, 2), 100).unwrap();
        let setups = [1, 2].map(|id| feetech::ServoSetup {
            id,
            mode: feetech::Mode::Position,
            range_rad: [0.0, 4.0],
            pwm: 1.0,
            speed_rad_s: 10.0,
        });
        let settings = feetech::Settings { family, echo: false, retries: 2, speed_counts: 1 };
        let mut bus = feetech::Bus::<2>::new(&setups, schedule, settings).unwrap();
        drive(&mut bus, bytes);
    }
}

/// Whatever a servo has heard, it answers a ping afterwards; but for an id that nobody can call.
pub(crate) fn feetech_servo(bytes: &[u8]) {
    let table = feetech::Table::of("STS3215").unwrap();
    let mut memory = [0; 256];
    let mut device = feetech::Device::new(table, 1, &mut memory);
    device.hear(bytes);
    device.silence();
    let mut out = [0; 300];
    device.speak(&mut out);
    let id = u8::try_from(device.get(feetech::table::address::ID)).unwrap();
    if id <= feetech::MAX_ID {
        let len = feetech::Instruction::Ping.encode(Family::Sts, id, &mut out).unwrap();
        device.hear(&out[..len]);
        assert!(device.due_us().is_some());
    }
}

/// A pulse is never longer than its period, nor a number that is none.
pub(crate) fn pca9685_chip(bytes: &[u8]) {
    let mut chip = pca9685::Device::new(25e6);
    for transfer in bytes.split(|byte| *byte == 0xA5) {
        chip.write(transfer);
    }
    for channel in 0..16 {
        assert!(chip.pulse_us(channel).is_none_or(|us| (0.0..=42_000.0).contains(&us)));
    }
}

fn drive(bus: &mut impl ServoBus, bytes: &[u8]) {
    let mut out = [0; 256];
    for piece in bytes.chunks(40) {
        bus.plan(&mut out).unwrap();
        bus.reply(piece);
        while bus.plan_more(10_000, &mut out).unwrap().is_some() {
            bus.reply(piece);
        }
        for servo in 0..bus.len() {
            let feedback = bus.feedback(servo);
            assert!(feedback.is_none_or(|feedback| {
                feedback.position_rad.abs() <= 1610.0 && feedback.velocity_rad_s.is_finite()
            }));
        }
    }
}
