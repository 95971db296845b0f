//! A host that sends anything, in every state, over a line that damages frames.

use std::collections::VecDeque;

use sinew_firmware::supervisor::State;
use sinew_link::message::{
    Block, Command, Feed, Hello, Item, Kind as ItemKind, LiveFrame, Location, Numbered, Operator,
    Pass, Stream, TelemetryParts, TelemetrySetting, ToController, Value, Version,
};

use super::line::{Trouble, random};
use super::stored::{item, show};
use super::test_rig::Kind;
use super::world::World;

const KIND: Kind = Kind::Current;

/// Source of the host's choices.
enum Choices {
    Random(u64),
    /// Bytes of an input; after their end all choices are zero.
    Bytes(VecDeque<u8>),
}

pub(crate) struct Hostile {
    choices: Choices,
    command: u16,
    stream: u16,
    /// Whether the host may arm.
    arms: bool,
}

impl Hostile {
    /// Creates a host whose messages follow from bytes. `command` and `stream` are the last sequence numbers that
    /// were used.
    pub(crate) fn of_bytes(bytes: &[u8], command: u16, stream: u16) -> Self {
        let choices = Choices::Bytes(bytes.iter().copied().collect());
        Self { choices, command, stream, arms: true }
    }

    /// Returns whether all choices are used up.
    pub(crate) fn is_over(&self) -> bool {
        matches!(&self.choices, Choices::Bytes(bytes) if bytes.is_empty())
    }

    fn bits(&mut self) -> u64 {
        match &mut self.choices {
            Choices::Random(seed) => random(seed),
            Choices::Bytes(bytes) => {
                (0..8).fold(0, |bits, _| bits << 8 | u64::from(bytes.pop_front().unwrap_or(0)))
            }
        }
    }

    pub(crate) fn below(&mut self, most: u64) -> u64 {
        match &mut self.choices {
            // For a small range, a byte is enough.
            Choices::Bytes(bytes) if most <= 256 => {
                u64::from(bytes.pop_front().unwrap_or(0)) % most
            }
            _ => self.bits() % most,
        }
    }

    /// Returns any finite number, which a frame can carry.
    fn number(&mut self) -> f32 {
        loop {
            let number = match self.below(3) {
                0 => f32::from_bits(self.bits() as u32),
                1 => (self.below(2000) as f32 - 1000.0) / 100.0,
                _ => [0.0, -0.0, f32::MAX, f32::MIN, 1e-40, 1.0][self.below(6) as usize],
            };
            if number.is_finite() {
                return number;
            }
        }
    }

    fn item(&mut self) -> Item {
        let kinds = [ItemKind::Settings, ItemKind::Rig, ItemKind::Show];
        let mut any = item(kinds[self.below(3) as usize], b"any", self.bits() as u32);
        any.length = [0, 1, 300, 4000, u32::MAX][self.below(5) as usize];
        any.schema = self.below(4) as u16;
        any
    }

    fn command(&mut self, state: State) -> Command {
        // Commands that end everything are rare, so that every state is reached. From states in which the rig is
        // moved by hand, only they lead out.
        let rare = if matches!(state, State::Calibrating | State::Teaching) { 5 } else { 100 };
        let operator = Operator(self.below(3) as u8);
        let feed = [Feed::Show, Feed::Live, Feed::Jog][self.below(3) as usize];
        let (slot, key) = (self.below(4) as u8, self.below(20) as u16);
        match self.below(28) {
            0 if self.below(400) == 0 => Command::EStop,
            1 | 2 if self.arms => Command::Arm,
            3 if self.below(rare) == 0 => Command::Disarm,
            4 | 5 => Command::Play(feed),
            6 => Command::Float,
            7 if self.below(rare) == 0 => Command::Stop,
            8 if self.below(20) == 0 => Command::Calibrate,
            9 if self.below(20) == 0 => Command::Teach,
            10 => Command::Maintain(operator),
            11 => Command::Leave(operator),
            12 | 13 => Command::ClearFaults,
            14 => Command::LoadShow { slot },
            15 if self.below(50) == 0 => Command::DeleteShow { slot },
            16 => Command::SetTelemetry(TelemetrySetting {
                rate_hz: self.number(),
                parts: TelemetryParts(self.below(256) as u8),
            }),
            17 => Command::ReadSetting { key },
            18 if self.below(50) == 0 => {
                Command::WriteSetting { key, value: Value::Number(self.number()) }
            }
            19 => Command::ReadFault { index: key },
            20 => Command::AskStored(Location::Show { slot }),
            21 => Command::BeginUpload(self.item()),
            22 => {
                let len = self.below(257) as usize;
                let bytes: heapless::Vec<u8, 256> = (0..len).map(|at| at as u8).collect();
                let offset = [0, 256, 512, u32::MAX][self.below(4) as usize];
                Command::UploadBlock(Block { offset, bytes })
            }
            23 => Command::EndUpload,
            25 => {
                let len = self.below(129) as usize;
                let bytes: heapless::Vec<u8, 128> =
                    (0..len).map(|_| self.below(256) as u8).collect();
                let wait_us = [0, 300, 20_000, u32::MAX][self.below(4) as usize];
                Command::PassOn(Pass { line: self.below(2) as u8, baud: 0, wait_us, bytes })
            }
            26 => Command::ReadPassed { offset: self.below(600) as u16 },
            27 => Command::ReadHealth,
            _ => Command::Hold,
        }
    }

    fn stream(&mut self) -> Stream {
        match self.below(5) {
            4 => Stream::Heard(self.below(1 << 16) as u16),
            0 => Stream::Heartbeat,
            1 => Stream::HoldToRun(Operator(self.below(3) as u8)),
            2 => Stream::Jog { dof: self.below(9) as u8, velocity: self.number() },
            _ => {
                let len = if self.below(8) == 0 { self.below(65) } else { 6 };
                let q = (0..len).map(|_| self.number()).collect();
                Stream::Live(LiveFrame { sent_us: self.bits() as u32, q })
            }
        }
    }

    /// Returns any message, mostly of this session and with the next number.
    pub(crate) fn message(&mut self, session: u16, state: State) -> ToController {
        let session = if self.below(30) == 0 { self.below(1 << 16) as u16 } else { session };
        match self.below(100) {
            0 if self.below(50) == 0 => {
                let protocol = Version { major: self.below(3) as u8, minor: 0 };
                ToController::Hello(Hello { protocol, nonce: self.bits() as u32 })
            }
            0..50 => {
                self.command =
                    self.command.wrapping_add(1 + self.below(20).saturating_sub(18) as u16);
                let (seq, item) = (self.command, self.command(state));
                ToController::Command(Numbered { session, seq, item })
            }
            _ => {
                self.stream = self.stream.wrapping_add(1);
                let (seq, item) = (self.stream, self.stream());
                ToController::Stream(Numbered { session, seq, item })
            }
        }
    }
}

/// Checks what must be true after each tick, whatever the host sends.
pub(crate) fn check_outputs(world: &World) {
    let state = world.state().expect("the rig is not replaced");
    if state.is_on() {
        // Goal current (102) is in mA, with the limit of the drives' settings.
        assert!(world.bench.servos().iter().all(|servo| servo.get(102).abs() <= 1200));
    } else if world.pins.fed > 10 {
        assert_eq!(world.servos_on(), 0, "{state}");
    }
}

/// Sends `each` frames in every tick until `frames` frames have been sent. Returns the number of ticks in each state.
fn talk(frames: u64, each: u64, arms: bool, seed: u64) -> [u32; State::COUNT] {
    let trouble = Trouble { lost: 50, twice: 50, flipped: 50, jitter_us: 5_000 };
    let mut world = World::ready(KIND, trouble, seed, &show(KIND, 4, true));
    (world.host.beats, world.steps) = (false, 4 * each as u32);
    let mut hostile = Hostile { choices: Choices::Random(seed), command: 1000, stream: 1000, arms };
    let (mut ticks, mut heard) = ([0; State::COUNT], None);
    let begin = world.host.there.frames;
    while world.host.there.frames - begin < frames {
        let session = world.host.welcome.map_or(0, |welcome| welcome.session);
        if heard.replace(session) != Some(session) {
            (hostile.command, hostile.stream) = (0, 0);
        }
        let state = world.state().expect("the rig is not replaced");
        for _ in 0..each {
            let message = hostile.message(session, state);
            let now_us = world.now_us();
            world.host.send(&message, now_us);
        }
        world.tick();
        let state = world.state().expect("the rig is not replaced");
        if world.ticks.is_multiple_of(400) && !state.is_on() {
            // After a restart, or after one of its own greetings, the host has another session.
            world.host.greet();
        }
        ticks[usize::from(state.number())] += 1;
        if !arms {
            assert!(!state.is_on() && !world.pins.outputs && world.servos_on() == 0);
        }
        check_outputs(&world);
    }
    ticks
}

#[test]
fn without_arm_there_is_no_torque_whatever_is_said() {
    println!("ticks by state, without arm: {:?}", talk(100_000, 50, false, 21));
}

#[test]
fn with_arm_nothing_leaves_its_limits_whatever_is_said() {
    let ticks = talk(100_000, 4, true, 22);
    println!("ticks by state: {ticks:?}");
    let reached = ticks.iter().filter(|ticks| **ticks > 0).count();
    assert!(reached >= 9, "{ticks:?}");
}

#[test]
fn a_million_frames_of_a_bad_line() {
    println!("ticks by state: {:?}", talk(1_000_000, 100, true, 23));
}
