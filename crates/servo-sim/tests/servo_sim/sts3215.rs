//! The simulated STS3215 against published and measured behaviour of the real one.
//!
//! Sources: Feetech's memory table of magnetic STS servos, section 3.1 (bits of Phase); dumps of new SO-101 servos
//! (Phase 12 or 76); `lerobot` 0.4.4, `motors/feetech/feetech.py` (the present position is the actual one without the
//! homing offset); `FTServo` SDK, `CalibrationOfs` (128 in Torque Enable, without opening EEPROM).

use sinew_servo_bus::BusDevice;
use sinew_servo_bus::feetech::table::phase;
use sinew_servo_sim::device::{MEMORY_LEN, STEP_S, Servo};
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::model::Parameters;

const PHASE: u8 = 18;
const OFFSET: u8 = 31;
const MODE: u8 = 33;
const TORQUE: u8 = 40;
const GOAL: u8 = 42;
const SPEED: u8 = 46;
const LOCK: u8 = 55;
const POSITION: u8 = 56;
const PRESENT_SPEED: u8 = 58;

/// A servo with a light arm, and packets to it.
struct Bench<'m>(Servo<'m>);

impl<'m> Bench<'m> {
    fn new(memory: &'m mut [u8]) -> Self {
        let kind = Parameters::built_in("STS3215-7.4V").unwrap();
        Self(Servo::new(&kind, 1, memory).unwrap())
    }

    /// Sends an instruction and returns the answer. Does not use the codec, which refuses what a controller must not do
    /// by accident.
    fn ask(&mut self, instruction: u8, parameters: &[u8]) -> Vec<u8> {
        let length = u8::try_from(parameters.len() + 2).unwrap();
        let mut packet = vec![0xFF, 0xFF, 1, length, instruction];
        packet.extend(parameters);
        packet.push(!packet[2..].iter().fold(0, |sum: u8, byte| sum.wrapping_add(*byte)));
        self.0.hear(&packet);
        let mut out = [0; 64];
        let len = self.0.speak(&mut out);
        out[..len].to_vec()
    }

    fn reboot(&mut self) {
        self.ask(8, &[]);
        self.run(2.0);
    }

    fn write(&mut self, address: u8, data: &[u8]) {
        self.ask(3, &[&[address], data].concat());
    }

    fn write_word(&mut self, address: u8, value: i32) {
        let sign = if value < 0 { 0x8000 } else { 0 };
        let word = u16::try_from(value.unsigned_abs()).unwrap() | sign;
        self.write(address, &word.to_le_bytes());
    }

    /// Reads a word whose bit `sign` is its sign.
    fn read(&mut self, address: u8, sign: u8) -> i32 {
        let reply = self.ask(2, &[address, 2]);
        let word = i32::from(u16::from_le_bytes([reply[5], reply[6]]));
        let magnitude = word & ((1 << sign) - 1);
        if word & (1 << sign) == 0 { magnitude } else { -magnitude }
    }

    fn position(&mut self) -> i32 {
        self.read(POSITION, 15)
    }

    fn run(&mut self, time_s: f64) {
        let arm = Arm { inertia_kg_m2: 1e-3, ..Arm::default() };
        let mut left_s = time_s;
        while left_s > 0.0 {
            self.0.step(7.4, &arm);
            left_s -= STEP_S;
        }
    }

    /// Writes an EEPROM register as masters do it.
    fn keep(&mut self, address: u8, data: &[u8]) {
        self.write(LOCK, &[0]);
        self.write(address, data);
        self.write(LOCK, &[1]);
    }

    /// Turns in speed mode at a goal of 1000 and returns the speed, counts/s, and the reported speed.
    fn wheel(&mut self) -> (f64, i32) {
        self.keep(MODE, &[1]);
        self.write(TORQUE, &[1]);
        self.write_word(SPEED, 1000);
        self.run(1.0);
        let before = self.0.shaft().position_rad;
        self.run(1.0);
        let counts = (self.0.shaft().position_rad - before) / std::f64::consts::TAU * 4096.0;
        (counts, self.read(PRESENT_SPEED, 15))
    }
}

#[test]
fn it_begins_as_it_is_shipped() {
    let mut memory = [0; MEMORY_LEN];
    let mut servo = Bench::new(&mut memory);
    assert_eq!(servo.read(PHASE, 15) & 0xFF, phase::SHIPPED);
    assert_eq!(phase::SHIPPED, 12);
    assert_eq!((servo.position(), servo.read(OFFSET, 11)), (2048, 0));
}

#[test]
fn bit_2_of_phase_is_the_unit_of_speed() {
    for (phase, counts_s, told) in [(12, 1000.0, 1000), (76, 1000.0, 1000), (8, 3403.0, 68)] {
        let mut memory = [0; MEMORY_LEN];
        let mut servo = Bench::new(&mut memory);
        servo.keep(PHASE, &[phase]);
        let (speed, reported) = servo.wheel();
        assert!((speed / counts_s - 1.0).abs() < 0.02, "Phase {phase}: {speed} counts/s");
        assert!((reported - told).abs() <= 20, "Phase {phase}: {reported} counts of speed");
    }
}

#[test]
fn bit_3_of_phase_decides_whether_a_speed_of_0_moves() {
    for (phase, there) in [(12, 3000), (4, 2048)] {
        let mut memory = [0; MEMORY_LEN];
        let mut servo = Bench::new(&mut memory);
        servo.keep(PHASE, &[phase]);
        servo.write_word(GOAL, 3000);
        servo.run(2.0);
        let position = servo.position();
        assert!((position - there).abs() < 10, "Phase {phase}: {position}");
    }
}

#[test]
fn bit_4_of_phase_counts_turns() {
    for (phase, is_within) in [(12, true), (28, false)] {
        let mut memory = [0; MEMORY_LEN];
        let mut servo = Bench::new(&mut memory);
        servo.keep(PHASE, &[phase]);
        servo.wheel();
        servo.run(4.0);
        let turned = servo.0.shaft().position_rad / std::f64::consts::TAU * 4096.0;
        let position = servo.position();
        assert!(turned > 7000.0);
        let expected = if is_within { turned.rem_euclid(4096.0) } else { turned };
        assert!((f64::from(position) - expected).abs() < 2.0, "{phase}: {position} of {turned}");
        servo.write_word(SPEED, 0);
        servo.run(1.0);
        // A reboot forgets whole turns.
        servo.reboot();
        let position = servo.position();
        assert!((0..4096).contains(&position), "{phase}: {position} after a reboot");
    }
}

#[test]
fn bits_0_and_7_together_reverse_the_servo_and_one_alone_runs_away() {
    for (bits, there) in [(0, 2600), (129, 2600)] {
        let mut memory = [0; MEMORY_LEN];
        let mut servo = Bench::new(&mut memory);
        servo.keep(PHASE, &[12 + bits]);
        servo.write_word(GOAL, there);
        servo.run(2.0);
        let (position, shaft) = (servo.position(), servo.0.shaft().position_rad);
        assert!((position - there).abs() < 10, "{bits}: {position}");
        let is_forwards = shaft > std::f64::consts::PI;
        assert_eq!(is_forwards, bits == 0, "{bits}: {shaft} rad");
    }
    let mut memory = [0; MEMORY_LEN];
    let mut servo = Bench::new(&mut memory);
    servo.keep(PHASE, &[13]);
    servo.write_word(GOAL, 2100);
    servo.run(1.0);
    assert!((servo.0.shaft().position_rad - std::f64::consts::PI).abs() > 1.0);
}

#[test]
fn the_middle_is_kept_in_register_31_over_a_reboot() {
    for start in [100, 1000, 2048, 3500, 4095] {
        let mut memory = [0; MEMORY_LEN];
        let mut servo = Bench::new(&mut memory);
        servo.0.place(f64::from(start) / 4096.0 * std::f64::consts::TAU);
        servo.run(0.1);
        assert_eq!(servo.position(), start);
        servo.write(TORQUE, &[128]);
        servo.run(0.1);
        // The register has 11 bits and a sign.
        let offset = (start - 2048).clamp(-2047, 2047);
        assert_eq!((servo.position(), servo.read(OFFSET, 11)), (2048, offset), "from {start}");
        servo.reboot();
        assert_eq!((servo.position(), servo.read(OFFSET, 11)), (2048, offset), "from {start}");
        // The servo moves as it counts.
        servo.write_word(GOAL, 2500);
        servo.run(2.0);
        let position = servo.position();
        assert!((position - 2500).abs() < 10, "from {start}: {position}");
    }
}

#[test]
fn an_offset_is_subtracted_within_a_turn_at_once() {
    let mut memory = [0; MEMORY_LEN];
    let mut servo = Bench::new(&mut memory);
    for (offset, bytes) in [(1000, [0xE8, 0x03]), (-2047, [0xFF, 0x0F]), (2047, [0xFF, 0x07])] {
        servo.keep(OFFSET, &bytes);
        servo.run(0.01);
        assert_eq!(servo.read(OFFSET, 11), offset);
        assert_eq!(servo.position(), (2048 - offset).rem_euclid(4096));
        // A goal at the present position does not turn the servo round.
        let (position, before) = (servo.position(), servo.0.shaft().position_rad);
        servo.write_word(GOAL, position);
        servo.run(0.5);
        assert!((servo.0.shaft().position_rad - before).abs() < 0.01, "{offset}");
        servo.write(TORQUE, &[0]);
    }
}
