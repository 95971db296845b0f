//! A million damaged replies: what is believed was sent, and a whole reply behind a damaged one is not lost.

use sinew_bus::dynamixel::{self, Mode, ServoSetup, Settings, Status, StatusError, table::MODELS};
use sinew_bus::feetech::{self, Family};
use sinew_bus::{Schedule, ServoBus, Timing};

const SERVOS: usize = 6;
const TICKS: usize = 170_000;
const TIMING: Timing = Timing { baud: 1_000_000, return_delay_us: 0, turnaround_us: 0 };
/// The fastest that servos are said to be.
const SPEED_RAD_S: f32 = 11.0;
const RATE_HZ: u32 = 200;

/// `SplitMix64`: the same damage in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, count: usize) -> usize {
        usize::try_from(self.next() % count as u64).unwrap()
    }

    fn byte(&mut self) -> u8 {
        self.next().to_le_bytes()[0]
    }
}

#[expect(clippy::cast_possible_truncation, reason = "believed positions are far inside of i32")]
fn nearest(counts: f32) -> i32 {
    counts.round() as i32
}

/// One kind of damage to one reply.
fn damage(reply: &mut Vec<u8>, random: &mut Random) {
    let at = random.below(reply.len());
    match random.below(7) {
        0 => {
            reply.remove(at);
        }
        1 => reply.insert(at, reply[at]),
        2 => reply.insert(at, random.byte()),
        3 => reply.truncate(at),
        4 => reply[at] = random.byte(),
        5 => {
            for _ in 0..=random.below(8) {
                let bit = random.below(reply.len() * 8);
                reply[bit / 8] ^= 1 << (bit % 8);
            }
        }
        _ => {
            let again = reply[at..].to_vec();
            reply.extend(again);
        }
    }
}

#[derive(Debug, Default)]
struct Count {
    damaged: usize,
    whole: usize,
    /// Whole replies behind damage that were not believed.
    lost: usize,
    /// Positions that were believed and not sent, with a right checksum by chance.
    wrong: usize,
    /// The largest error of those, counts.
    worst: i32,
}

/// Sends ticks of replies, of which a half is damaged, and compares what is believed with what was sent. `reply`
/// writes the reply of a servo at a position.
fn run(
    bus: &mut impl ServoBus,
    rad_per_count: f32,
    reply: impl Fn(usize, i32) -> Vec<u8>,
) -> Count {
    let mut random = Random(16);
    let mut count = Count::default();
    let mut out = [0; 1024];
    let mut positions = [2000_i32; SERVOS];
    for _ in 0..TICKS {
        bus.plan(&mut out).unwrap();
        let mut stream = Vec::new();
        let mut is_whole = [true; SERVOS];
        for servo in 0..SERVOS {
            let step = i32::try_from(random.below(61)).unwrap() - 30;
            positions[servo] = (positions[servo] + step).clamp(500, 3500);
            let mut bytes = reply(servo, positions[servo]);
            if random.below(2) == 0 {
                is_whole[servo] = false;
                count.damaged += 1;
                damage(&mut bytes, &mut random);
            }
            stream.extend(bytes);
            // A reply that nobody asked for: another servo's, right in itself.
            if random.below(20) == 0 {
                stream.extend(reply(SERVOS + random.below(3), 0));
            }
        }
        let cut = random.below(stream.len() + 1);
        bus.reply(&stream[..cut]);
        bus.reply(&stream[cut..]);
        // The time is over: nothing more will come. No time is left to ask again.
        assert_eq!(bus.plan_more(0, &mut out), Ok(None));
        for servo in 0..SERVOS {
            let believed = bus.feedback(servo).filter(|feedback| feedback.age_ticks == 0);
            let counts = believed.map(|feedback| nearest(feedback.position_rad / rad_per_count));
            count.whole += usize::from(is_whole[servo]);
            count.lost += usize::from(is_whole[servo] && counts.is_none());
            if let Some(counts) = counts.filter(|counts| *counts != positions[servo]) {
                count.wrong += 1;
                count.worst = count.worst.max((counts - positions[servo]).abs());
            }
        }
    }
    count
}

fn schedule() -> Schedule {
    let schedule = Schedule::new(TIMING, &dynamixel::traffic(6, 4, false), RATE_HZ).unwrap();
    assert_eq!(schedule.groups(), 1);
    schedule
}

#[test]
fn dynamixel_replies() {
    let model = MODELS.iter().find(|model| model.number == 1200).unwrap();
    let setups: Vec<_> = (1..=6)
        .map(|id| ServoSetup {
            id,
            model,
            mode: Mode::Position,
            range_rad: [0.0, 6.0],
            current_a: 1.0,
            pwm: 1.0,
            speed_rad_s: SPEED_RAD_S,
        })
        .collect();
    let settings = Settings { fast: false, retries: 0 };
    let mut bus = dynamixel::Bus::<6>::new(&setups, schedule(), settings).unwrap();
    let rad = std::f32::consts::TAU / 4096.0;
    let count = run(&mut bus, rad, |servo, position| {
        let mut data = [0; 10];
        data[..2].copy_from_slice(&(-1_i16).to_le_bytes());
        // FF FF FD in a row: stuffed.
        data[2] = 0xFD;
        data[6..].copy_from_slice(&position.to_le_bytes());
        let mut out = [0; 64];
        let status =
            Status { id: u8::try_from(servo + 1).unwrap(), error: StatusError::NONE, data: &data };
        let len = status.encode(&mut out).unwrap();
        out[..len].to_vec()
    });
    println!("{count:?}");
    assert!(count.damaged + count.whole >= 1_000_000 && count.damaged > 500_000);
    // One damaged reply in 65,536 has a right CRC by chance, and may take the first byte of the next one with it. Its
    // position must also be near: none was believed.
    assert!(count.lost * 65_536 <= 2 * count.damaged, "{count:?}");
    assert_eq!(count.wrong, 0, "{count:?}");
}

#[test]
fn feetech_replies() {
    let setups: Vec<_> = (1..=6)
        .map(|id| feetech::ServoSetup {
            id,
            mode: feetech::Mode::Position,
            range_rad: [0.0, 6.0],
            pwm: 1.0,
            speed_rad_s: SPEED_RAD_S,
        })
        .collect();
    let settings =
        feetech::Settings { family: Family::Sts, echo: false, retries: 0, speed_counts: 1 };
    let mut bus = feetech::Bus::<6>::new(&setups, schedule(), settings).unwrap();
    let count = run(&mut bus, Family::Sts.rad_per_count(), |servo, position| {
        let mut data = [0; 15];
        data[..2].copy_from_slice(&u16::try_from(position).unwrap().to_le_bytes());
        data[6] = 74;
        data[7] = 30;
        let mut out = [0; 64];
        let status = feetech::Status { id: u8::try_from(servo + 1).unwrap(), bits: 0, data: &data };
        let len = status.encode(&mut out).unwrap();
        out[..len].to_vec()
    });
    println!("{count:?}");
    assert!(count.damaged + count.whole >= 1_000_000 && count.damaged > 500_000);
    // One damaged reply in 256 has a right sum. Id, length and a position that is near leave one in 10,000; it is no
    // further off than the servo could have turned since its last reading.
    assert!(count.wrong * 8000 <= count.damaged, "{count:?}");
    assert!(count.lost * 4000 <= count.whole, "{count:?}");
}
