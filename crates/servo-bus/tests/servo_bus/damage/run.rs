//! Runs ticks of a master on a line with damage. Its packets are decoded as by a servo. Its readings are compared with
//! the servos' replies, and with the result of an independent receiver for the same bytes.

use sinew_servo_bus::{Command, CommandError, Feedback, ServoBus};

use super::random::Random;

pub(crate) const SERVOS: usize = 6;
/// Maximum speed of the servos, as given to the bus.
pub(crate) const SPEED_RAD_S: f32 = 11.0;
pub(crate) const RATE_HZ: u32 = 200;
/// A separate number for the readings of each servo; any two differ in four or more bits. The last three belong to
/// servos that are not asked.
pub(crate) const TAGS: [u8; SERVOS + 3] = [0x0F, 0x33, 0x3C, 0x55, 0x5A, 0x66, 0x69, 0x96, 0x99];

/// A measurement of a servo, in counts as on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Reading {
    pub(crate) position: i32,
    /// Number of the servo, from [`TAGS`].
    pub(crate) tag: i32,
    /// Value that is the same in all readings.
    pub(crate) rest: i32,
}

/// The question of the master, and the servos that it asks.
#[derive(Debug, Default)]
pub(crate) struct Question {
    pub(crate) servos: Vec<usize>,
    /// First address of the read.
    pub(crate) address: u16,
    pub(crate) is_motion: bool,
    /// Whether all servos answer in one packet.
    pub(crate) is_fast: bool,
}

impl Question {
    pub(crate) fn ask(&mut self, address: u16, ids: &[u8]) {
        assert!(self.servos.is_empty(), "a second question");
        self.address = address;
        self.servos = ids.iter().map(|id| usize::from(*id) - 1).collect();
    }
}

/// A protocol as it appears on the wire.
pub(crate) trait Wire {
    /// Value of a reading besides position and tag.
    const REST: i32;
    /// Minimum and maximum position that the protocol can express.
    const BOUNDS: [i32; 2];
    /// Range in which the servos move during the run.
    const RANGE: [i32; 2];
    const RAD_PER_COUNT: f32;

    /// Decodes the master's packets like a servo. Each goal must be within the limits of its servo; `goals` counts
    /// them. `is_on` states which servos were commanded to have torque on.
    fn hear(&self, sent: &[u8], is_on: [bool; SERVOS], goals: &mut usize) -> Question;

    /// Returns the answers of the servos, one after the other.
    fn answers(&self, question: &Question, readings: &[Reading; SERVOS]) -> Vec<Vec<u8>>;

    /// Returns a valid reply that was not asked for.
    fn stray(&self, servo: usize, reading: Reading) -> Vec<u8>;

    /// Returns for each servo the first whole reply to the question in the stream.
    fn received(&self, question: &Question, stream: &[u8]) -> Vec<(usize, Reading)>;

    /// Returns the master's reading in counts as on the wire.
    fn believed(&self, feedback: &Feedback) -> Reading;

    fn reading(&self, servo: usize, position: i32) -> Reading {
        Reading { position, tag: TAGS[servo].into(), rest: Self::REST }
    }
}

#[derive(Debug, Default)]
pub(crate) struct Count {
    pub(crate) damaged: usize,
    pub(crate) whole: usize,
    /// Parts of a fast answer after a damaged part, whose checks cover the damage too.
    pub(crate) behind_tear: usize,
    /// Whole replies that the master did not read, because the parser took their bytes for the end of a false packet.
    pub(crate) hidden: usize,
    /// Whole replies that the master read but did not believe, because its last reading was wrong.
    pub(crate) doubted: usize,
    /// Replies with wrong contents and a right check: they pass if only the check counts.
    pub(crate) passed: usize,
    /// Replies of `passed` that have a wrong position.
    pub(crate) passed_positions: usize,
    /// Replies with the contents of another servo and a right check.
    pub(crate) passed_foreign: usize,
    /// Wrong replies that the master believed. The next two fields count those with a wrong position, and those
    /// with the contents of another servo.
    pub(crate) wrong: usize,
    pub(crate) wrong_positions: usize,
    pub(crate) foreign: usize,
    /// Largest error of a believed position, counts.
    pub(crate) worst: i32,
    /// Number of goals that the servos received.
    pub(crate) goals: usize,
}

/// Returns the maximum change of a reading in a tick, counts: twice the servo's motion in that time, plus four.
#[expect(clippy::cast_possible_truncation, reason = "some tens")]
pub(crate) fn step<W: Wire>() -> i32 {
    (2.0 * SPEED_RAD_S / RATE_HZ as f32 / W::RAD_PER_COUNT + 4.0).round() as i32
}

/// Returns the maximum motion of the run's servos in a tick, counts.
#[expect(clippy::cast_possible_truncation, reason = "some tens")]
pub(crate) fn most_move<W: Wire>() -> i32 {
    (0.8 * SPEED_RAD_S / RATE_HZ as f32 / W::RAD_PER_COUNT) as i32
}

/// Decides which readings of a servo to believe, by the rule in docs/buses.md.
#[derive(Debug, Clone, Copy, Default)]
struct Model {
    last: Option<i32>,
    /// Ticks since the last believed reading.
    age: i32,
    /// A reading that was not believed, and the age of the last reading at that time.
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

/// Runs `ticks` ticks, in which one of `odds` replies is damaged.
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
            // No more bytes will arrive, so bytes that wait for the rest of a damaged packet are processed.
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

/// Sends any command with any number. Numbers that are not finite and commands that the servo lacks are refused.
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
