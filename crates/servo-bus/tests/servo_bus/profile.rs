//! Tests positions with the servo's own motion profile: the register values, for both protocols.

use proptest::prelude::*;
use sinew_servo_bus::dynamixel::table::{MODELS, Table, address};
use sinew_servo_bus::feetech::table::address as feetech_address;
use sinew_servo_bus::feetech::{self, Family};
use sinew_servo_bus::{
    BusDevice, Command, CommandError, Limit, Line, Schedule, ServoBus, Timing, dynamixel,
};

const TIMING: Timing = Timing { baud: 1_000_000, return_delay_us: 2, turnaround_us: 5 };
const RANGE_RAD: [f32; 2] = [1.0, 5.0];
const COUNT_RAD: f32 = std::f32::consts::TAU / 4096.0;
/// Velocity of one Dynamixel count: 0.229 rev/min.
const DYNAMIXEL_RAD_S: f32 = 0.229 * std::f32::consts::TAU / 60.0;

fn dynamixel_bus() -> dynamixel::Bus<1> {
    let model = MODELS.iter().find(|model| model.number == 1200).unwrap();
    let setup = dynamixel::ServoSetup {
        id: 1,
        model,
        mode: dynamixel::Mode::Position,
        range_rad: RANGE_RAD,
        current_a: 0.8,
        pwm: 0.5,
        speed_rad_s: 11.0,
    };
    let traffic = dynamixel::traffic(1, 4, false).with_goal(8);
    assert_eq!(traffic.write.bytes(2), dynamixel::traffic(2, 8, false).write.bytes(2));
    let schedule = Schedule::new(TIMING, &traffic, 100).unwrap();
    dynamixel::Bus::new(&[setup], schedule, dynamixel::Settings { fast: false, retries: 0 })
        .unwrap()
}

fn feetech_bus(speed_counts: u8) -> feetech::Bus<1> {
    let mode = feetech::Mode::Position;
    let setup =
        feetech::ServoSetup { id: 1, mode, range_rad: RANGE_RAD, pwm: 1.0, speed_rad_s: 6.0 };
    let family = Family::Sts;
    let schedule = Schedule::new(TIMING, &feetech::traffic(family, 1).with_goal(6), 100).unwrap();
    let settings = feetech::Settings { family, echo: false, retries: 0, speed_counts };
    let mut bus = feetech::Bus::new(&[setup], schedule, settings).unwrap();
    bus.command(0, Command::Torque(true)).unwrap();
    bus
}

/// Sends the commanded packets, and passes the replies to the bus.
fn send(bus: &mut impl ServoBus, device: &mut impl BusDevice) {
    let (mut out, mut scratch) = ([0; 128], [0; 128]);
    let request = bus.plan(&mut out).unwrap();
    let devices = std::slice::from_mut(device);
    Line::new(devices).exchange(&out[..request.len], &mut scratch, |said, _| {
        bus.reply(said);
    });
}

proptest! {
    /// The goal is within its range, and the speed is rounded up to the next step: never to 0, which means "no limit".
    #[test]
    fn the_profile_keeps_up_and_never_runs_free(
        position_rad in proptest::num::f32::ANY,
        speed_rad_s in proptest::num::f32::ANY,
        slow in 0.0_f32..20.0,
        speed_counts in prop::sample::select(vec![1_u8, 50]),
    ) {
        for speed_rad_s in [slow, speed_rad_s] {
            let command = Command::PositionAt { position_rad, speed_rad_s };
            let mut memory = [0; 512];
            let mut device = dynamixel::Device::<512>::new(Table::of(1200, 52).unwrap(), 1, &mut memory);
            let mut bus = dynamixel_bus();
            let accepted = bus.command(0, command);
            prop_assert_eq!(accepted.is_ok(), position_rad.is_finite() && speed_rad_s.is_finite());
            if accepted.is_err() {
                continue;
            }
            send(&mut bus, &mut device);
            let memory = device.memory();
            let goal = memory.get(address::GOAL_POSITION) as f32 * COUNT_RAD;
            prop_assert!((RANGE_RAD[0]..=RANGE_RAD[1]).contains(&goal), "{} rad", goal);
            check_speed(memory.get(address::PROFILE_VELOCITY), DYNAMIXEL_RAD_S, speed_rad_s)?;

            let mut memory = [0; 256];
            let mut device = feetech::Device::new(feetech::Table::of("STS3215").unwrap(), 1, &mut memory);
            let mut bus = feetech_bus(speed_counts);
            bus.command(0, command).unwrap();
            send(&mut bus, &mut device);
            let goal = device.get(feetech_address::GOAL_POSITION) as f32 * COUNT_RAD;
            prop_assert!((RANGE_RAD[0]..=RANGE_RAD[1]).contains(&goal), "{} rad", goal);
            check_speed(device.get(46), f32::from(speed_counts) * COUNT_RAD, speed_rad_s)?;
            prop_assert_eq!(device.get(44), 0);
        }
    }
}

fn check_speed(counts: i32, scale: f32, asked: f32) -> Result<(), TestCaseError> {
    prop_assert!((1..=32_767).contains(&counts), "{counts}");
    let given = counts as f32 * scale;
    // Tolerance of a thousandth of a step for f32 rounding.
    prop_assert!(
        counts == 32_767 || given >= asked - 1.1e-3 * scale - 1e-6 * asked,
        "{given} for {asked}"
    );
    prop_assert!(
        counts == 1 || given <= asked + scale * 1.001 + 1e-6 * asked,
        "{given} for {asked}"
    );
    Ok(())
}

#[test]
fn the_last_of_two_goals_counts_and_others_refuse_a_speed() {
    let mut memory = [0; 512];
    let mut device = dynamixel::Device::<512>::new(Table::of(1200, 52).unwrap(), 1, &mut memory);
    device.memory_mut().set(address::PROFILE_VELOCITY, 77);
    let mut bus = dynamixel_bus();
    bus.command(0, Command::PositionAt { position_rad: 2.0, speed_rad_s: 1.0 }).unwrap();
    bus.command(0, Command::Position(3.0)).unwrap();
    send(&mut bus, &mut device);
    assert_eq!(device.memory().get(address::PROFILE_VELOCITY), 77);
    assert!(
        (device.memory().get(address::GOAL_POSITION) as f32 * COUNT_RAD - 3.0).abs() < COUNT_RAD
    );

    let mut bus = feetech_bus(1);
    bus.command(0, Command::Torque(false)).unwrap();
    let command = Command::PositionAt { position_rad: 2.0, speed_rad_s: 1.0 };
    assert_eq!(bus.command(0, command), Ok(Some(Limit::TorqueOff)));

    let setup = sinew_servo_bus::pca9685::ChannelSetup {
        channel: 0,
        range_rad: [-1.0, 1.0],
        pulse_us: [1000.0, 2000.0],
    };
    let prescale = sinew_servo_bus::pca9685::Prescale::new(25e6, 50.0).unwrap();
    let mut bus = sinew_servo_bus::pca9685::Bus::new(&[setup], prescale, 400_000).unwrap();
    assert_eq!(bus.command(0, command), Err(CommandError::Unsupported("position with a speed")));
}
