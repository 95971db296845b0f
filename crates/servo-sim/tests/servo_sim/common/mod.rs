//! Servos on a bench, and a master for them.

use sinew_servo_bus::dynamixel::table::MODELS;
use sinew_servo_bus::dynamixel::{Bus, Mode, ServoSetup, Settings, traffic};
use sinew_servo_bus::{Command, Schedule, ServoBus, Timing};
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::{MEMORY_LEN, Servo};
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::model::Parameters;
use sinew_servo_sim::supply::Supply;

pub(crate) const BAUD: u32 = 2_000_000;
pub(crate) const MIDDLE: f32 = std::f32::consts::PI;
pub(crate) type Registers = Vec<[u8; MEMORY_LEN]>;

pub(crate) fn registers(count: usize) -> Registers {
    vec![[0; MEMORY_LEN]; count]
}

/// Creates a bench with an XL330 for each memory, with ids from 1, a return delay of 2 us, and no answers to writes.
pub(crate) fn bench(memory: &mut Registers, arm: Arm, supply: Supply) -> Bench<'_, Vec<Arm>> {
    let kind = Parameters::built_in("XL330-M288-T").unwrap();
    let arms = vec![arm; memory.len()];
    let servos = (1..).zip(memory).map(|(id, memory)| {
        let mut servo = Servo::new(&kind, id, memory).unwrap();
        servo.set_baud(BAUD).unwrap();
        servo.set(9, 1);
        servo.set(68, 1);
        servo
    });
    Bench::new(servos.collect(), arms, supply)
}

pub(crate) fn master<const N: usize>(mode: Mode, rate_hz: u32) -> Bus<N> {
    let timing = Timing { baud: BAUD, return_delay_us: 2, turnaround_us: 5 };
    let model = MODELS.iter().find(|model| model.name == "XL330-M288").unwrap();
    let setups = (1..).take(N).map(|id| ServoSetup {
        id,
        model,
        mode,
        range_rad: [0.5, 5.8],
        current_a: 1.5,
        pwm: 1.0,
        speed_rad_s: 15.0,
    });
    let setups: Vec<_> = setups.collect();
    let servos = u32::try_from(N).unwrap();
    let schedule = Schedule::new(timing, &traffic(servos, 4, false), rate_hz).unwrap();
    let mut bus = Bus::new(&setups, schedule, Settings { fast: false, retries: 1 }).unwrap();
    for servo in 0..N {
        bus.command(servo, Command::Torque(true)).unwrap();
        if mode == Mode::Position {
            bus.command(servo, Command::Position(MIDDLE)).unwrap();
        }
    }
    bus
}
