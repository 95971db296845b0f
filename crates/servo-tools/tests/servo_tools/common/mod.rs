//! Simulated servos on a simulated line.

use std::io;
use std::time::Duration;

use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::{MEMORY_LEN, Servo as SimServo};
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::model::Parameters;
use sinew_servo_sim::supply::Supply;
use sinew_servo_tools::{Client, Exchange, Protocol, Settings};

/// A line of simulated servos, in simulated time, that may lose and damage packets.
pub(crate) struct SimLine {
    pub bench: Bench<'static, Vec<Arm>>,
    /// Percentage of replies that are lost; the next field is the percentage of damaged replies.
    pub lost: u32,
    pub damaged: u32,
    /// Whether the adapter echoes the bytes that it sends.
    pub echoes: bool,
    /// Maximum baud rate of the adapter, bits per second.
    pub most_baud: u32,
    /// Packets that were sent.
    pub sent: Vec<Vec<u8>>,
    seed: u64,
}

impl SimLine {
    /// Creates a line of servos with factory settings, from kinds and ids.
    pub(crate) fn new(servos: &[(&str, u8)]) -> Self {
        let made = servos.iter().map(|(kind, id)| {
            let kind = Parameters::built_in(kind).unwrap();
            let memory = Box::leak(Box::new([0; MEMORY_LEN]));
            SimServo::new(&kind, *id, memory).unwrap()
        });
        let volts =
            if servos.iter().any(|(kind, _)| kind.starts_with("XL330")) { 5.0 } else { 7.4 };
        let volts =
            if servos.iter().any(|(kind, _)| kind.starts_with("XL430")) { 11.1 } else { volts };
        let arms = vec![Arm { inertia_kg_m2: 2e-4, ..Arm::default() }; servos.len()];
        Self {
            bench: Bench::new(made.collect(), arms, Supply::stiff(volts)),
            lost: 0,
            damaged: 0,
            echoes: false,
            most_baud: u32::MAX,
            sent: Vec::new(),
            seed: 16,
        }
    }

    fn percent(&mut self) -> u32 {
        self.seed = self
            .seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        u32::try_from(self.seed >> 33).unwrap() % 100
    }

    /// Returns the number of write packets. The instruction is byte 7 in Dynamixel packets, byte 4 in Feetech packets.
    pub(crate) fn writes(&self) -> usize {
        let instruction = |packet: &[u8]| {
            let at = if packet.starts_with(&[0xFF, 0xFF, 0xFD, 0]) { 7 } else { 4 };
            packet.get(at).copied()
        };
        self.sent.iter().filter(|packet| instruction(packet) == Some(3)).count()
    }
}

impl Exchange for SimLine {
    fn exchange(
        &mut self,
        bytes: &[u8],
        wait: Duration,
        take: &mut dyn FnMut(&[u8]) -> bool,
    ) -> io::Result<()> {
        self.sent.push(bytes.to_vec());
        if self.echoes {
            take(bytes);
        }
        let [lost, damaged, place] = [self.percent(), self.percent(), self.percent()];
        let wait_us = u32::try_from(wait.as_micros()).unwrap();
        let (lost, damaged) = (lost < self.lost, damaged < self.damaged);
        self.bench.exchange(bytes, wait_us, |said| {
            let mut said = said.to_vec();
            if lost {
                said.clear();
            } else if damaged && !said.is_empty() {
                let at = usize::try_from(place).unwrap() % said.len();
                said[at] ^= 0x10;
            }
            // The reply arrives in two parts: a port may split it anywhere.
            let (head, tail) = said.split_at(said.len() / 2);
            let is_complete = take(head);
            take(tail) || is_complete
        });
        Ok(())
    }

    fn set_baud(&mut self, baud: u32) -> io::Result<()> {
        if baud > self.most_baud {
            return Err(io::ErrorKind::InvalidInput.into());
        }
        self.bench.baud = baud;
        Ok(())
    }

    fn pause(&mut self, time: Duration) {
        self.bench.run_us(u32::try_from(time.as_micros()).unwrap());
    }

    fn now(&mut self) -> Duration {
        Duration::from_secs_f64(self.bench.time_s())
    }
}

/// Creates a client at the factory baud rate of the first servo.
pub(crate) fn client(servos: &[(&str, u8)]) -> Client<SimLine> {
    let line = SimLine::new(servos);
    let protocol =
        if servos[0].0.starts_with('S') { Protocol::Feetech } else { Protocol::Dynamixel };
    let baud = line.bench.baud;
    Client::new(line, protocol, baud, Settings::default()).unwrap()
}

/// One servo kind of each family.
pub(crate) const KINDS: [&str; 3] = ["XL330-M288-T", "XL430-W250-T", "STS3215-7.4V"];
