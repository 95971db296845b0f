//! Bits of a Dynamixel's Drive Mode. Source: e-manual, Drive Mode.

use sinew_servo_bus::BusDevice;
use sinew_servo_bus::dynamixel::Instruction;
use sinew_servo_sim::device::{MEMORY_LEN, STEP_S, Servo};
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::model::Parameters;

const DRIVE_MODE: u16 = 10;
const MODE: u16 = 11;
const TORQUE: u16 = 64;
const GOAL_PWM: u16 = 100;
const GOAL_CURRENT: u16 = 102;
const GOAL_VELOCITY: u16 = 104;
const GOAL_POSITION: u16 = 116;
const POSITION: u16 = 132;
const VELOCITY: u16 = 128;

struct Bench<'m>(Servo<'m>);

impl<'m> Bench<'m> {
    /// Creates a servo with a light arm, in an operating mode, and with a Drive Mode.
    fn new(memory: &'m mut [u8], mode: u8, drive_mode: u8) -> Self {
        let kind = Parameters::built_in("XL330-M288-T").unwrap();
        let mut servo = Self(Servo::new(&kind, 1, memory).unwrap());
        assert_eq!(servo.write(DRIVE_MODE, &[drive_mode]), 0);
        assert_eq!(servo.write(MODE, &[mode]), 0);
        servo.run(0.01);
        servo
    }

    /// Writes, and returns the error byte of the answer.
    fn write(&mut self, address: u16, data: &[u8]) -> u8 {
        let mut out = [0; 64];
        let len = Instruction::Write { address, data }.encode(1, &mut out).unwrap();
        self.0.hear(&out[..len]);
        self.0.speak(&mut out);
        out[8]
    }

    fn get(&mut self, address: u16) -> i32 {
        // A packet makes the servo publish what it measures.
        self.write(65, &[0]);
        self.0.get(address)
    }

    fn run(&mut self, time_s: f64) {
        let arm = Arm { inertia_kg_m2: 2e-4, ..Arm::default() };
        let mut left_s = time_s;
        while left_s > 0.0 {
            self.0.step(5.0, &arm);
            left_s -= STEP_S;
        }
    }
}

#[test]
fn bit_0_reverses_goals_and_readings_of_all_modes() {
    let word = |value: i16| value.to_le_bytes();
    for (mode, address, data) in [
        (0, GOAL_CURRENT, word(300).to_vec()),
        (1, GOAL_VELOCITY, 100_i32.to_le_bytes().to_vec()),
        (3, GOAL_POSITION, 2600_i32.to_le_bytes().to_vec()),
        (5, GOAL_POSITION, 2600_i32.to_le_bytes().to_vec()),
        (16, GOAL_PWM, word(300).to_vec()),
    ] {
        let moved = [0, 1].map(|reversed| {
            let mut memory = [0; MEMORY_LEN];
            let mut servo = Bench::new(&mut memory, mode, reversed);
            assert_eq!(servo.get(POSITION), 2048);
            let before = servo.0.shaft().position_rad;
            assert_eq!(servo.write(TORQUE, &[1]), 0);
            assert_eq!(servo.write(address, &data), 0, "mode {mode}");
            servo.run(0.1);
            let velocity = servo.get(VELOCITY);
            assert!(velocity > 0, "mode {mode}: {velocity}");
            servo.run(0.4);
            let position = servo.get(POSITION);
            assert!(position > 2100, "mode {mode}: {position}");
            servo.0.shaft().position_rad - before
        });
        assert!(moved[0] > 0.05 && (moved[0] + moved[1]).abs() < 0.02, "mode {mode}: {moved:?}");
    }
}

#[test]
fn bit_3_switches_torque_on_by_the_goal_of_the_mode_only() {
    for (drive_mode, goal, comes_on) in
        [(0, GOAL_POSITION, false), (8, GOAL_POSITION, true), (8, GOAL_VELOCITY, false)]
    {
        let mut memory = [0; MEMORY_LEN];
        let mut servo = Bench::new(&mut memory, 3, drive_mode);
        assert_eq!(servo.write(goal, &100_i32.to_le_bytes()), 0);
        servo.run(0.5);
        let torque = servo.get(TORQUE) == 1;
        assert_eq!(torque, comes_on, "Drive Mode {drive_mode}, goal at {goal}");
        assert_eq!(servo.get(POSITION) < 1900, comes_on);
    }
}

#[test]
fn the_bit_of_a_slave_is_refused() {
    let mut memory = [0; MEMORY_LEN];
    let mut servo = Bench::new(&mut memory, 3, 0);
    for value in [2, 3, 6, 7, 10, 11] {
        assert_ne!(servo.write(DRIVE_MODE, &[value]), 0, "{value}");
        assert_eq!(servo.get(DRIVE_MODE), 0);
    }
}
