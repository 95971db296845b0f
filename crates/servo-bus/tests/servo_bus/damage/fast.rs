//! Tests answers to fast reads with a wrong CRC inside. The answer is one packet, whose own CRC is that of the last
//! servo. This CRC may match although earlier bytes are wrong. The bus therefore checks every servo's CRC: it keeps the
//! parts before the first wrong CRC, and drops all parts after it, because their CRCs cover the damage too.

use sinew_servo_bus::dynamixel::fast::FastReader;
use sinew_servo_bus::dynamixel::table::{MODELS, address};
use sinew_servo_bus::dynamixel::{
    self, Bus, Instruction, Mode, Parser, ServoSetup, Settings, Status,
};
use sinew_servo_bus::{Feedback, Schedule, ServoBus};

use super::TIMING;
use crate::reference;

const SERVOS: usize = 4;
/// Length of current, velocity and position.
const LEN: usize = 10;
const PART_LEN: usize = LEN + 4;

fn position(servo: usize) -> u8 {
    u8::try_from(10 + servo).unwrap()
}

/// Returns the answer of all servos. `spoil` changes a servo's part before the later CRCs are computed, so that those
/// CRCs match the damage.
fn answer(spoil: impl Fn(usize, &mut [u8])) -> Vec<u8> {
    let len = u8::try_from(1 + SERVOS * PART_LEN).unwrap();
    let mut said = vec![0xFF, 0xFF, 0xFD, 0, 0xFE, len, 0, 0x55];
    for servo in 0..SERVOS {
        let start = said.len();
        said.extend([0, u8::try_from(servo + 1).unwrap(), 0, 0, 0, 0, 0, 0]);
        said.extend([position(servo), 0, 0, 0]);
        said.extend(reference::crc16(&said).to_le_bytes());
        spoil(servo, &mut said[start..]);
    }
    said
}

/// A kind of damage: its name, and a function that damages one servo's section of the packet.
type Spoil = (&'static str, fn(&mut [u8]));

const SPOILT: [Spoil; 4] = [
    ("CRC, low byte", |part| part[PART_LEN - 2] ^= 1),
    ("CRC, high byte", |part| part[PART_LEN - 1] ^= 0x80),
    ("a byte of the position", |part| part[8] ^= 4),
    ("id", |part| part[1] ^= 8),
];

#[test]
fn the_packet_as_a_whole_is_right() {
    for servo in 0..SERVOS - 1 {
        for (what, spoil) in SPOILT {
            let bytes = answer(|nth, part| {
                if nth == servo {
                    spoil(part);
                }
            });
            let mut parser = Parser::<128>::new();
            let packet = parser.next(&mut &bytes[..]);
            assert!(packet.is_some(), "{what} of {servo}: the last CRC covers what is there");
        }
    }
}

#[test]
fn what_is_in_front_of_a_wrong_crc_is_kept_and_nothing_behind_it() {
    for wrong in 0..SERVOS {
        for (what, spoil) in SPOILT {
            let bytes = answer(|servo, part| {
                if servo == wrong {
                    spoil(part);
                }
            });
            let mut reader = FastReader::<PART_LEN>::new(bytes.len());
            let mut input = &bytes[..];
            for servo in 0..SERVOS {
                let id = u8::try_from(servo + 1).unwrap();
                let read = reader.next(id, 10, &mut input);
                let read = read.map(|status| (status.id, status.data[6]));
                let expected = (servo < wrong).then_some((id, position(servo)));
                assert_eq!(read, expected, "{what} of {wrong}: servo {servo}");
            }
            assert!(reader.is_broken());
        }
    }
}

/// The servos whose parts were refused are asked alone in the same tick.
#[test]
fn a_bus_asks_again_what_it_refused() {
    let model = MODELS.iter().find(|model| model.number == 1200).unwrap();
    let setups: [ServoSetup; SERVOS] = std::array::from_fn(|servo| ServoSetup {
        id: u8::try_from(servo + 1).unwrap(),
        model,
        mode: Mode::Position,
        range_rad: [0.0, 6.0],
        current_a: 1.0,
        pwm: 1.0,
        speed_rad_s: 10.0,
    });
    let schedule = Schedule::new(TIMING, &dynamixel::traffic(4, 4, true), 100).unwrap();
    for wrong in 0..SERVOS {
        for (what, spoil) in SPOILT {
            let settings = Settings { fast: true, retries: 4 };
            let mut bus = Bus::<SERVOS>::new(&setups, schedule, settings).unwrap();
            let mut out = [0; 128];
            bus.plan(&mut out).unwrap();
            let bytes = answer(|servo, part| {
                if servo == wrong {
                    spoil(part);
                }
            });
            assert!(!bus.reply(&bytes), "{what} of {wrong}: not all has come");
            for servo in 0..SERVOS {
                let read = bus.feedback(servo).map(counts);
                assert_eq!(read, (servo < wrong).then_some(position(servo)), "{what} of {wrong}");
            }
            for servo in wrong..SERVOS {
                let asked = bus.plan_more(10_000, &mut out).unwrap().unwrap();
                let mut parser = Parser::<64>::new();
                let packet = parser.next(&mut &out[..asked.len]).unwrap();
                let read = Instruction::Read { address: address::PRESENT_CURRENT, length: 10 };
                assert_eq!(Instruction::decode(&packet), Ok(read));
                assert_eq!(usize::from(packet.id), servo + 1);
                let data = [0, 0, 0, 0, 0, 0, position(servo), 0, 0, 0];
                let status =
                    Status { id: packet.id, error: dynamixel::StatusError::NONE, data: &data };
                let mut said = [0; 64];
                let len = status.encode(&mut said).unwrap();
                assert!(bus.reply(&said[..len]));
                assert_eq!(bus.feedback(servo).map(counts), Some(position(servo)));
            }
        }
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "10 to 13")]
fn counts(feedback: Feedback) -> u8 {
    (feedback.position_rad / (std::f32::consts::TAU / 4096.0)).round() as u8
}
