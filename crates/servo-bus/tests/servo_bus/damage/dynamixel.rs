//! Six simulated XL330, each with its own mode and limits.

use sinew_servo_bus::dynamixel::fast::FastTurn;
use sinew_servo_bus::dynamixel::group::sync_blocks;
use sinew_servo_bus::dynamixel::table::{MODELS, address};
use sinew_servo_bus::dynamixel::{
    self, Bus, Instruction, Mode, Parser, ServoSetup, Settings, Span, Status, StatusError,
};
use sinew_servo_bus::{Effort, Feedback, Schedule};

use super::run::{Question, RATE_HZ, Reading, SERVOS, SPEED_RAD_S, Wire};
use super::{MASTER_WINDOW, TIMING};
use crate::reference;

const MODES: [Mode; SERVOS] = [
    Mode::Position,
    Mode::Position,
    Mode::ExtendedPosition,
    Mode::CurrentPosition,
    Mode::Current,
    Mode::Pwm,
];
/// Full PWM in counts, for any model.
const FULL_PWM: f64 = 885.0;
const A_PER_COUNT: f64 = 0.001;
const RAD_PER_COUNT: f64 = std::f64::consts::TAU / 4096.0;
const RAD_S_PER_COUNT: f64 = 0.229 * std::f64::consts::TAU / 60.0;

pub(crate) struct Dynamixel {
    setups: [ServoSetup; SERVOS],
}

impl Dynamixel {
    pub(crate) fn new() -> Self {
        let model = MODELS.iter().find(|model| model.number == 1200).unwrap();
        let setups = std::array::from_fn(|servo| {
            let nth = servo as f32;
            ServoSetup {
                id: id(servo),
                model,
                mode: MODES[servo],
                range_rad: [0.4 + 0.3 * nth, 5.3 - 0.2 * nth],
                current_a: 0.3004 + 0.1 * nth,
                pwm: 0.2004 + 0.1 * nth,
                speed_rad_s: SPEED_RAD_S,
            }
        });
        Self { setups }
    }

    pub(crate) fn bus(&self, fast: bool) -> Bus<SERVOS> {
        let schedule = Schedule::new(TIMING, &dynamixel::traffic(6, 4, fast), RATE_HZ).unwrap();
        assert_eq!(schedule.groups(), 1);
        Bus::new(&self.setups, schedule, Settings { fast, retries: 2 }).unwrap()
    }

    fn check_goal(&self, id: u8, address: u16, data: &[u8]) {
        let setup = self.setups.iter().find(|setup| setup.id == id);
        let setup = setup.unwrap_or_else(|| panic!("a goal to servo {id}"));
        let within = |value: f64, [least, most]: [f32; 2]| {
            let is_within = (f64::from(least)..=f64::from(most)).contains(&value);
            assert!(is_within, "servo {id}, {address}: {value} outside of {least} to {most}");
        };
        let position = |bytes| {
            within(f64::from(i32::from_le_bytes(bytes)) * RAD_PER_COUNT, setup.range_rad);
            assert!(matches!(
                setup.mode,
                Mode::Position | Mode::ExtendedPosition | Mode::CurrentPosition
            ));
        };
        match (address, data) {
            (address::TORQUE_ENABLE, &[on]) => assert!(on <= 1),
            // 0 clears the watchdog, 5 sets it to 100 ms.
            (address::BUS_WATCHDOG, &[raw]) => assert!(raw == 0 || raw == 5),
            (address::POSITION_P, &[a, b]) => assert!(u16::from_le_bytes([a, b]) <= 16_383),
            (address::GOAL_PWM, &[a, b]) => {
                let pwm = f64::from(i16::from_le_bytes([a, b])) / FULL_PWM;
                within(pwm, [-setup.pwm, setup.pwm]);
            }
            (address::GOAL_CURRENT, &[a, b]) => {
                let current = f64::from(i16::from_le_bytes([a, b])) * A_PER_COUNT;
                within(current, [-setup.current_a, setup.current_a]);
            }
            (address::PROFILE_VELOCITY, &[a, b, c, d, e, f, g, h]) => {
                // 0 would mean "no limit".
                assert!((1..=32_767).contains(&i32::from_le_bytes([a, b, c, d])));
                position([e, f, g, h]);
            }
            (address::GOAL_POSITION, &[a, b, c, d]) => position([a, b, c, d]),
            _ => panic!("servo {id}: {data:?} at {address}"),
        }
    }
}

fn id(servo: usize) -> u8 {
    u8::try_from(servo + 1).unwrap()
}

fn servo(id: u8) -> Option<usize> {
    usize::from(id).checked_sub(1)
}

/// Encodes current, velocity and position. A small negative current followed by this velocity gives FF FF FD, which is
/// stuffed.
fn motion(reading: Reading) -> [u8; 10] {
    let mut data = [0; 10];
    data[..2].copy_from_slice(&i16::try_from(reading.tag - 256).unwrap().to_le_bytes());
    data[2..6].copy_from_slice(&reading.rest.to_le_bytes());
    data[6..].copy_from_slice(&reading.position.to_le_bytes());
    data
}

fn reading_of(data: &[u8]) -> Option<Reading> {
    let &[c0, c1, v0, v1, v2, v3, p0, p1, p2, p3] = data else { return None };
    Some(Reading {
        position: i32::from_le_bytes([p0, p1, p2, p3]),
        tag: i32::from(i16::from_le_bytes([c0, c1])) + 256,
        rest: i32::from_le_bytes([v0, v1, v2, v3]),
    })
}

fn status(id: u8, data: &[u8]) -> Vec<u8> {
    let mut out = [0; 64];
    let len = Status { id, error: StatusError::NONE, data }.encode(&mut out).unwrap();
    out[..len].to_vec()
}

impl Wire for Dynamixel {
    const REST: i32 = i32::from_le_bytes([0xFF, 0xFD, 0xFF, 0xFF]);
    const BOUNDS: [i32; 2] = [-1_048_575, 1_048_575];
    const RANGE: [i32; 2] = [500, 3500];
    const RAD_PER_COUNT: f32 = std::f32::consts::TAU / 4096.0;

    fn hear(&self, sent: &[u8], _: [bool; SERVOS], goals: &mut usize) -> Question {
        let mut question = Question::default();
        let mut parser = Parser::<512>::new();
        let mut input = sent;
        while let Some(packet) = parser.next(&mut input) {
            match Instruction::decode(&packet).unwrap() {
                Instruction::SyncWrite { address, length, blocks } => {
                    for (id, data) in sync_blocks(blocks, length) {
                        *goals += 1;
                        self.check_goal(id, address, data);
                    }
                }
                Instruction::SyncRead(Span { address, ids, .. }) => question.ask(address, ids),
                Instruction::FastSyncRead(Span { address, ids, .. }) => {
                    question.ask(address, ids);
                    question.is_fast = true;
                }
                Instruction::Read { address, .. } => question.ask(address, &[packet.id]),
                other => panic!("{other:?} to {}", packet.id),
            }
        }
        assert!(parser.flush().is_none() && parser.damaged() == 0, "{sent:02X?}");
        question.is_motion = question.address == address::PRESENT_CURRENT;
        question
    }

    fn answers(&self, question: &Question, readings: &[Reading; SERVOS]) -> Vec<Vec<u8>> {
        let servos = question.servos.iter();
        if !question.is_fast {
            let answer = |servo: &usize| match question.address {
                address::PRESENT_CURRENT => status(id(*servo), &motion(readings[*servo])),
                address::PRESENT_VOLTAGE => status(id(*servo), &[50, 0, 30]),
                address::BUS_WATCHDOG => status(id(*servo), &[5]),
                other => panic!("a question for {other}"),
            };
            return servos.map(answer).collect();
        }
        let all = std::iter::repeat_n(10, question.servos.len());
        let mut said = Vec::new();
        let parts = servos.enumerate().map(|(place, servo)| {
            let mut turn = FastTurn::new(all.clone().take(place), all.clone());
            for byte in &said {
                turn.hear(*byte);
            }
            let data = motion(readings[*servo]);
            let status = Status { id: id(*servo), error: StatusError::NONE, data: &data };
            let mut out = [0; 64];
            let len = turn.encode(&status, &mut out).unwrap();
            said.extend_from_slice(&out[..len]);
            out[..len].to_vec()
        });
        parts.collect()
    }

    fn stray(&self, servo: usize, reading: Reading) -> Vec<u8> {
        status(id(servo), &motion(reading))
    }

    fn received(&self, question: &Question, stream: &[u8]) -> Vec<(usize, Reading)> {
        if question.is_fast {
            let servos: Vec<_> = question.servos.iter().map(|servo| (id(*servo), 10)).collect();
            let parts = reference::fast(&servos, stream).into_iter();
            let reading = |(id, _, data): (u8, _, Vec<u8>)| Some((servo(id)?, reading_of(&data)?));
            return parts.filter_map(reading).collect();
        }
        let found = reference::dynamixel(stream, MASTER_WINDOW).into_iter();
        let replies = found
            .filter(|found| found.code == 0x55)
            .filter_map(|found| Some((servo(found.id)?, reading_of(found.params.get(1..)?)?)));
        replies.collect()
    }

    #[expect(clippy::cast_possible_truncation, reason = "what was believed came as these integers")]
    fn believed(&self, feedback: &Feedback) -> Reading {
        let Effort::Current(current_a) = feedback.effort else { panic!("{feedback:?}") };
        Reading {
            position: (f64::from(feedback.position_rad) / RAD_PER_COUNT).round() as i32,
            tag: (f64::from(current_a) / A_PER_COUNT).round() as i32 + 256,
            rest: (f64::from(feedback.velocity_rad_s) / RAD_S_PER_COUNT).round() as i32,
        }
    }
}
