//! Six simulated servos of one family, two of them in PWM mode.

use sinew_servo_bus::feetech::{
    self, BROADCAST, Bus, Family, Instruction, Mode, Parser, ServoSetup, Settings, Status,
    sync_blocks,
};
use sinew_servo_bus::{Effort, Feedback, Schedule};

use super::flips;
use super::run::{Question, RATE_HZ, Reading, SERVOS, SPEED_RAD_S, Wire, most_move, step};
use super::{MASTER_WINDOW, TIMING};
use crate::reference;

const MODES: [Mode; SERVOS] =
    [Mode::Position, Mode::Position, Mode::Position, Mode::Pwm, Mode::Position, Mode::Pwm];
const TORQUE_ENABLE: u8 = 40;
const GOAL_POSITION: u8 = 42;
/// Address of the time register, which contains the PWM in PWM mode.
const GOAL_PWM: u8 = 44;
const PRESENT_POSITION: u8 = 56;

/// The test protocol of STS servos, or of SCS servos if `IS_SCS`.
pub(crate) struct Feetech<const IS_SCS: bool> {
    setups: [ServoSetup; SERVOS],
}

impl<const IS_SCS: bool> Feetech<IS_SCS> {
    const FAMILY: Family = if IS_SCS { Family::Scs } else { Family::Sts };

    pub(crate) fn new() -> Self {
        let setups = std::array::from_fn(|servo| {
            let nth = servo as f32;
            ServoSetup {
                id: id(servo),
                mode: MODES[servo],
                range_rad: [0.4 + 0.3 * nth, 4.9 - 0.2 * nth],
                pwm: 0.2004 + 0.1 * nth,
                speed_rad_s: SPEED_RAD_S,
            }
        });
        Self { setups }
    }

    pub(crate) fn bus(&self) -> Bus<SERVOS> {
        let schedule = Schedule::new(TIMING, &feetech::traffic(Self::FAMILY, 6), RATE_HZ).unwrap();
        assert_eq!(schedule.groups(), 1);
        let settings = Settings { family: Self::FAMILY, echo: false, retries: 2, speed_counts: 1 };
        Bus::new(&self.setups, schedule, settings).unwrap()
    }

    /// Returns the share of replies with flipped bits that have a right sum and a wrong but plausible position.
    pub(crate) fn believed_flips(&self) -> f64 {
        let [least, most] = Self::RANGE;
        // A larger error needs one more tick for each multiple of the reach. In each tick, the chance that the previous
        // reading was damaged is one half.
        let reach = step::<Self>() + most_move::<Self>();
        let of = |(position, servo): (i32, usize)| {
            let reply = Self::reply(servo, self.reading(servo, position));
            flips::believed(&reply, |bytes| {
                let came = Self::signed(bytes, 15);
                let can_be = (Self::BOUNDS[0]..=Self::BOUNDS[1]).contains(&came);
                let error = (came - position).abs();
                if can_be && error > 0 { 0.5_f64.powi((error - 1) / reach) } else { 0.0 }
            })
        };
        let samples = (least..most).step_by(89).zip((0..SERVOS).cycle());
        let all: Vec<_> = samples.map(of).collect();
        all.iter().sum::<f64>() / all.len() as f64
    }

    /// Returns the share of the places in a reply where a lost or added byte moves the position: the status and the
    /// position.
    pub(crate) fn moved_share(&self) -> f64 {
        3.0 / Self::reply(0, self.reading(0, Self::RANGE[0])).len() as f64
    }

    /// Returns the share of positions that are near the last position, which is at most two ticks old on average.
    #[expect(clippy::unused_self, reason = "beside the two above")]
    pub(crate) fn near_share(&self) -> f64 {
        let near = 2 * 2 * (step::<Self>() + most_move::<Self>()) + 1;
        f64::from(near) / f64::from(Self::BOUNDS[1] + 1)
    }

    fn number(bytes: [u8; 2]) -> u16 {
        if IS_SCS { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) }
    }

    fn bytes(number: i32) -> [u8; 2] {
        let number = u16::try_from(number).unwrap();
        if IS_SCS { number.to_be_bytes() } else { number.to_le_bytes() }
    }

    /// Decodes sign and magnitude.
    fn signed(bytes: [u8; 2], bit: u32) -> i32 {
        let number = i32::from(Self::number(bytes));
        let magnitude = number & ((1 << bit) - 1);
        if number >> bit & 1 == 1 { -magnitude } else { magnitude }
    }

    fn check_goal(&self, id: u8, address: u8, data: &[u8], is_on: [bool; SERVOS]) {
        let servo = usize::from(id).checked_sub(1).filter(|servo| *servo < SERVOS);
        let servo = servo.unwrap_or_else(|| panic!("a goal to servo {id}"));
        let setup = &self.setups[servo];
        let within = |value: f64, [least, most]: [f32; 2]| {
            let is_within = (f64::from(least)..=f64::from(most)).contains(&value);
            assert!(is_within, "servo {id}, {address}: {value} outside of {least} to {most}");
        };
        let position = |bytes| {
            let counts = Self::signed(bytes, 15);
            within(f64::from(counts) * f64::from(Self::RAD_PER_COUNT), setup.range_rad);
            assert_eq!(setup.mode, Mode::Position);
        };
        // A goal switches torque on by itself.
        assert!(address == TORQUE_ENABLE || is_on[servo], "a goal without torque: servo {id}");
        match (address, data) {
            (TORQUE_ENABLE, &[on]) => assert_eq!(on, u8::from(is_on[servo])),
            (GOAL_PWM, &[a, b]) => {
                let pwm = f64::from(Self::signed([a, b], 10)) / 1000.0;
                within(pwm, [-setup.pwm, setup.pwm]);
                assert_eq!(setup.mode, Mode::Pwm);
            }
            (GOAL_POSITION, &[a, b, 0, 0, c, d]) => {
                position([a, b]);
                // 0 would mean "no limit".
                assert!((1..=32_767).contains(&Self::signed([c, d], 15)));
            }
            (GOAL_POSITION, &[a, b]) => position([a, b]),
            _ => panic!("servo {id}: {data:?} at {address}"),
        }
    }

    fn reply(servo: usize, reading: Reading) -> Vec<u8> {
        let mut data = if IS_SCS { vec![0; 8] } else { vec![0; 15] };
        data[..2].copy_from_slice(&Self::bytes(reading.position));
        data[2..4].copy_from_slice(&Self::bytes(reading.tag));
        data[6] = 74;
        data[7] = 30;
        let rest = if IS_SCS { 4 } else { 13 };
        data[rest..rest + 2].copy_from_slice(&Self::bytes(reading.rest));
        let mut out = [0; 64];
        let len = Status { id: id(servo), bits: 0, data: &data }.encode(&mut out).unwrap();
        out[..len].to_vec()
    }
}

fn id(servo: usize) -> u8 {
    u8::try_from(servo + 1).unwrap()
}

impl<const IS_SCS: bool> Wire for Feetech<IS_SCS> {
    const REST: i32 = 37;
    const BOUNDS: [i32; 2] = [0, if IS_SCS { 1023 } else { 4095 }];
    const RANGE: [i32; 2] = if IS_SCS { [100, 900] } else { [500, 3500] };
    const RAD_PER_COUNT: f32 = Self::FAMILY.rad_per_count();

    fn hear(&self, sent: &[u8], is_on: [bool; SERVOS], goals: &mut usize) -> Question {
        let mut question = Question::default();
        let mut parser = Parser::<259>::new();
        let mut input = sent;
        while let Some(packet) = parser.next(&mut input) {
            match Instruction::decode(&packet).unwrap() {
                Instruction::SyncWrite { address, length, blocks } => {
                    assert_eq!(packet.id, BROADCAST);
                    for (id, data) in sync_blocks(blocks, length) {
                        *goals += 1;
                        self.check_goal(id, address, data, is_on);
                    }
                }
                Instruction::SyncRead { address, ids, .. } if !IS_SCS => {
                    question.ask(address.into(), ids);
                }
                Instruction::Read { address, .. } => question.ask(address.into(), &[packet.id]),
                other => panic!("{other:?} to {}", packet.id),
            }
        }
        assert!(parser.flush().is_none() && parser.damaged() == 0, "{sent:02X?}");
        assert!(question.servos.is_empty() || question.address == PRESENT_POSITION.into());
        question.is_motion = true;
        question
    }

    fn answers(&self, question: &Question, readings: &[Reading; SERVOS]) -> Vec<Vec<u8>> {
        question.servos.iter().map(|servo| Self::reply(*servo, readings[*servo])).collect()
    }

    fn stray(&self, servo: usize, reading: Reading) -> Vec<u8> {
        Self::reply(servo, reading)
    }

    fn received(&self, _: &Question, stream: &[u8]) -> Vec<(usize, Reading)> {
        let found = reference::feetech(stream, MASTER_WINDOW).into_iter();
        // No servo sets the highest bit of its status.
        let replies = found.filter(|found| found.code < 0x80).filter_map(|found| {
            let servo = usize::from(found.id).checked_sub(1)?;
            let &[p0, p1, v0, v1, l0, l1, _, _, ref rest @ ..] = &found.params[..] else {
                return None;
            };
            let other = match *rest {
                [] if IS_SCS => Self::signed([l0, l1], 10),
                [_, _, _, _, _, c0, c1] if !IS_SCS => Self::signed([c0, c1], 15),
                _ => return None,
            };
            let (position, tag) = (Self::signed([p0, p1], 15), Self::signed([v0, v1], 15));
            Some((servo, Reading { position, tag, rest: other }))
        });
        replies.collect()
    }

    #[expect(clippy::cast_possible_truncation, reason = "what was believed came as these integers")]
    fn believed(&self, feedback: &Feedback) -> Reading {
        let rest = match feedback.effort {
            Effort::Current(a) => f64::from(a) / 0.0065,
            Effort::Load(part) => f64::from(part) * 1000.0,
        };
        let counts = |rad: f32| (f64::from(rad) / f64::from(Self::RAD_PER_COUNT)).round() as i32;
        Reading {
            position: counts(feedback.position_rad),
            tag: counts(feedback.velocity_rad_s),
            rest: rest.round() as i32,
        }
    }
}
