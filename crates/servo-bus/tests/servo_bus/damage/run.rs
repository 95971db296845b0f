//! Ticks of a master on a line with damage: what it sends is decoded as a servo does, and what it believes is compared
//! with what the servos said, and with what a receiver apart from it finds in the same bytes.

use sinew_servo_bus::{Command, CommandError, Feedback, ServoBus};

use super::random::Random;

pub(crate) const SERVOS: usize = 6;
/// The fastest that servos are said to be.
pub(crate) const SPEED_RAD_S: f32 = 11.0;
pub(crate) const RATE_HZ: u32 = 200;
/// A number of its own in each reading of each servo; any two differ in four bits or more. The last three are of servos
/// that nobody asked.
pub(crate) const TAGS: [u8; SERVOS + 3] = [0x0F, 0x33, 0x3C, 0x55, 0x5A, 0x66, 0x69, 0x96, 0x99];

/// What a servo measures, in the numbers of the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Reading {
    pub(crate) position: i32,
    /// One of [`TAGS`].
    pub(crate) tag: i32,
    /// What is the same in all readings.
    pub(crate) rest: i32,
}

/// What the master asks, and whom.
#[derive(Debug, Default)]
pub(crate) struct Question {
    pub(crate) servos: Vec<usize>,
    /// First address of what is asked.
    pub(crate) address: u16,
    pub(crate) is_motion: bool,
    /// All answer in one packet.
    pub(crate) is_fast: bool,
}

impl Question {
    pub(crate) fn ask(&mut self, address: u16, ids: &[u8]) {
        assert!(self.servos.is_empty(), "a second question");
        self.address = address;
        self.servos = ids.iter().map(|id| usize::from(*id) - 1).collect();
    }
}

/// How a protocol looks on the wire.
pub(crate) trait Wire {
    /// What one reading of a servo has besides the position and the tag.
    const REST: i32;
    /// Least and most position that the protocol can say of a servo.
    const BOUNDS: [i32; 2];
    /// Where servos go about in the run.
    const RANGE: [i32; 2];
    const RAD_PER_COUNT: f32;

    /// Decodes what the master sent as a servo does. Each goal in it must be within the limits of its servo; `goals`
    /// counts them. `is_on` says whose torque was commanded to be on.
    fn hear(&self, sent: &[u8], is_on: [bool; SERVOS], goals: &mut usize) -> Question;

    /// What the servos answer, one after the other.
    fn answers(&self, question: &Question, readings: &[Reading; SERVOS]) -> Vec<Vec<u8>>;

    /// A reply that nobody asked for, right in itself.
    fn stray(&self, servo: usize, reading: Reading) -> Vec<u8>;

    /// The first reply to the question of each servo that is whole in the stream.
    fn received(&self, question: &Question, stream: &[u8]) -> Vec<(usize, Reading)>;

    /// What the master believes, in the numbers of the wire.
    fn believed(&self, feedback: &Feedback) -> Reading;

    fn reading(&self, servo: usize, position: i32) -> Reading {
        Reading { position, tag: TAGS[servo].into(), rest: Self::REST }
    }
}

#[derive(Debug, Default)]
pub(crate) struct Count {
    pub(crate) damaged: usize,
    pub(crate) whole: usize,
    /// Parts of a fast answer behind a damaged one, whose check covers the damage too.
    pub(crate) behind_tear: usize,
    /// Whole replies that the master did not read, for those bytes were the end of a packet that was none.
    pub(crate) hidden: usize,
    /// Whole replies that the master read and did not believe: its last reading was wrong.
    pub(crate) doubted: usize,
    /// Replies with a wrong content and a right check: what passes where nothing else is looked at.
    pub(crate) passed: usize,
    /// Those of them that have a wrong position.
    pub(crate) passed_positions: usize,
    /// Replies that have another servo's content and a right check.
    pub(crate) passed_foreign: usize,
    /// The same three, of what was believed.
    pub(crate) wrong: usize,
    pub(crate) wrong_positions: usize,
    pub(crate) foreign: usize,
    /// The largest error of a position that was believed, counts.
    pub(crate) worst: i32,
    /// Goals that the servos heard.
    pub(crate) goals: usize,
}

/// By how many counts a reading may move in a tick: twice of what the servo turns in the time, and four.
#[expect(clippy::cast_possible_truncation, reason = "some tens")]
pub(crate) fn step<W: Wire>() -> i32 {
    (2.0 * SPEED_RAD_S / RATE_HZ as f32 / W::RAD_PER_COUNT + 4.0).round() as i32
}

/// By how many counts the servos of the run move in a tick, at most.
#[expect(clippy::cast_possible_truncation, reason = "some tens")]
pub(crate) fn most_move<W: Wire>() -> i32 {
    (0.8 * SPEED_RAD_S / RATE_HZ as f32 / W::RAD_PER_COUNT) as i32
}

/// Which readings of a servo are to be believed, by the rule in docs/buses.md.
#[derive(Debug, Clone, Copy, Default)]
struct Model {
    last: Option<i32>,
    /// Ticks since then.
    age: i32,
    /// What was not believed, and how old the last reading was then.
    doubtful: Option<(i32, i32)>,
}

impl Model {
    fn believes(&mut self, position: i32, [least, most]: [i32; 2], step: i32) -> bool {
        if position < least || position > most {
            return false;
        }
        let near = |other: i32, ticks: i32| (position - other).abs() <= step * ticks.max(1);
        let is_believed = self.last.is_none_or(|last| near(last, self.age))
            || self.doubtful.is_some_and(|(other, age)| near(other, self.age - age));
        if is_believed {
            *self = Self { last: Some(position), age: 0, doubtful: None };
        } else {
            self.doubtful = Some((position, self.age));
        }
        is_believed
    }
}

impl Count {
    fn note(&mut self, said: Reading, came: Reading, is_believed: bool, is_whole: bool) {
        if came == said {
            self.doubted += usize::from(is_whole && !is_believed);
            return;
        }
        let is_moved = came.position != said.position;
        let is_foreign = came.tag != said.tag && TAGS.iter().any(|tag| i32::from(*tag) == came.tag);
        self.passed += 1;
        self.passed_positions += usize::from(is_moved);
        self.passed_foreign += usize::from(is_foreign);
        if is_believed {
            self.wrong += 1;
            self.wrong_positions += usize::from(is_moved);
            self.foreign += usize::from(is_foreign);
            self.worst = self.worst.max((came.position - said.position).abs());
        }
    }
}

/// Runs so many ticks, in which one reply in `odds` is damaged.
pub(crate) fn run<W: Wire>(bus: &mut impl ServoBus, wire: &W, ticks: usize, odds: usize) -> Count {
    let mut random = Random(16);
    let mut count = Count::default();
    let mut out = [0; 1024];
    let (step, most_move) = (step::<W>(), most_move::<W>());
    let [least, most] = W::RANGE;
    let mut readings: [Reading; SERVOS] =
        std::array::from_fn(|servo| wire.reading(servo, i32::midpoint(least, most)));
    let mut models = [Model::default(); SERVOS];
    let mut is_on = [false; SERVOS];
    for _ in 0..ticks {
        for (servo, is_on) in is_on.iter_mut().enumerate() {
            command(bus, servo, is_on, &mut random);
        }
        for (reading, model) in readings.iter_mut().zip(&mut models) {
            reading.position = (reading.position + random.within(most_move)).clamp(least, most);
            model.age += 1;
        }
        let left_us = if random.below(2) == 0 { 100_000 } else { 0 };
        let mut is_awaited = [true; SERVOS];
        let mut request = Some(bus.plan(&mut out).unwrap());
        while let Some(asked) = request {
            let question = wire.hear(&out[..asked.len], is_on, &mut count.goals);
            let mut stream = Vec::new();
            let mut is_whole = [false; SERVOS];
            let mut is_torn = false;
            let stray = |random: &mut Random| {
                let servo = SERVOS + random.below(TAGS.len() - SERVOS);
                wire.stray(servo, wire.reading(servo, readings[0].position))
            };
            if random.below(20) == 0 {
                stream.extend(stray(&mut random));
            }
            let answers = wire.answers(&question, &readings);
            for (servo, mut bytes) in question.servos.iter().zip(answers) {
                if random.below(odds) == 0 {
                    count.damaged += 1;
                    random.damage(&mut bytes);
                    is_torn = question.is_fast;
                } else if is_torn {
                    count.behind_tear += 1;
                } else {
                    count.whole += 1;
                    is_whole[*servo] = true;
                }
                stream.extend(bytes);
                if !question.is_fast && random.below(20) == 0 {
                    stream.extend(stray(&mut random));
                }
            }
            let cut = random.below(stream.len() + 1);
            bus.reply(&stream[..cut]);
            bus.reply(&stream[cut..]);
            // Nothing more will come; what waits for the rest of a damaged packet is taken.
            request = bus.plan_more(left_us, &mut out).unwrap();
            if question.is_motion {
                let received = wire.received(&question, &stream);
                for servo in question.servos {
                    if !std::mem::take(&mut is_awaited[servo]) {
                        continue;
                    }
                    let said = readings[servo];
                    let feedback = bus.feedback(servo).filter(|feedback| feedback.age_ticks == 0);
                    let believed = feedback.map(|feedback| wire.believed(&feedback));
                    let Some((_, came)) = received.iter().find(|(from, _)| *from == servo) else {
                        assert_eq!(believed, None, "servo {servo} of {stream:02X?}");
                        is_awaited[servo] = true;
                        count.hidden += usize::from(is_whole[servo]);
                        continue;
                    };
                    let model = &mut models[servo];
                    let is_believed = model.believes(came.position, W::BOUNDS, step);
                    assert_eq!(believed, is_believed.then_some(*came), "servo {servo}: {model:?}");
                    count.note(said, *came, is_believed, is_whole[servo]);
                }
            }
        }
    }
    count
}

/// Any command with any number; what the servo cannot do, or is no number, is refused.
fn command(bus: &mut impl ServoBus, servo: usize, is_on: &mut bool, random: &mut Random) {
    let command = random.command();
    match bus.command(servo, command) {
        Ok(_) => {
            if let Command::Torque(on) = command {
                *is_on = on;
            }
        }
        Err(CommandError::NotFinite(_) | CommandError::Unsupported(_)) => {}
        Err(other) => panic!("{command:?}: {other}"),
    }
}
