//! Servos in simulated time, on one bus line or on several ([`Branch`]).

mod branch;
mod chip;

use std::collections::VecDeque;

use sinew_servo_bus::{BusDevice, EncodeError, ServoBus};

use crate::device::limits::LONGEST;
use crate::device::{STEP_S, Servo};
use crate::fault::{Fault, FaultKind};
use crate::line::LineDevice;
use crate::load::{Plant, Push, Shaft};
use crate::model::Draw;
use crate::supply::Supply;
use crate::wire::{self, SILENCE_US};
pub use branch::Branch;
pub use chip::{Chip, OSCILLATOR_HZ};

const STEP_NS: u64 = 250_000;

/// Traffic on the wire so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Traffic {
    /// Bytes that the master sent.
    pub sent: u64,
    /// Bytes that servos sent.
    pub answered: u64,
    /// Total time of these bytes, ns.
    pub wire_ns: u64,
}

/// Servos, a half-duplex line, supplies and a plant, in simulated time. The simulation reads no clock, and the order of
/// all sums is fixed: equal calls give equal bits.
///
/// Time passes while bytes are on the wire, and while the master waits. A servo reads its registers in its own tick,
/// and answers with the measurements of its last tick.
pub struct Bench<'m, P> {
    servos: Vec<Servo<'m>>,
    /// Mechanics that the servos move.
    pub plant: P,
    /// Supplies of the servos.
    pub supplies: Vec<Supply>,
    /// Faults of the servos, with their times.
    pub faults: Vec<Fault>,
    /// Baud rate of the master, bits per second.
    pub baud: u32,
    /// Index of each servo's supply.
    fed_by: Vec<usize>,
    /// Total load of the servos on each supply in a step.
    draws: Vec<Draw>,
    traffic: Traffic,
    now_ns: u64,
    stepped_ns: u64,
    plant_steps: u32,
    pushes: Vec<Push>,
    shafts: Vec<Shaft>,
    on_way: VecDeque<(u64, Vec<u8>)>,
}

impl<'m, P: Plant> Bench<'m, P> {
    /// Creates a bench at time 0. The master starts at the baud rate of the first servo.
    pub fn new(servos: Vec<Servo<'m>>, plant: P, supply: Supply) -> Self {
        Self::fed_by_several(servos, plant, vec![supply], |_| 0)
    }

    /// Creates a bench with several supplies. `fed_by` returns the index of a servo's supply.
    ///
    /// # Panics
    /// If `fed_by` returns an index without a supply.
    pub fn fed_by_several(
        servos: Vec<Servo<'m>>,
        plant: P,
        supplies: Vec<Supply>,
        fed_by: impl Fn(usize) -> usize,
    ) -> Self {
        let count = servos.len();
        let fed_by: Vec<usize> = (0..count).map(fed_by).collect();
        assert!(fed_by.iter().all(|supply| *supply < supplies.len()), "a servo has no supply");
        Self {
            baud: servos.first().map_or(1_000_000, Servo::baud).max(1),
            servos,
            plant,
            draws: vec![Draw::default(); supplies.len()],
            supplies,
            fed_by,
            faults: Vec::new(),
            traffic: Traffic::default(),
            now_ns: 0,
            stepped_ns: 0,
            plant_steps: 0,
            pushes: vec![Push::default(); count],
            shafts: vec![Shaft::default(); count],
            on_way: VecDeque::new(),
        }
    }

    /// Returns the servos.
    pub fn servos(&self) -> &[Servo<'m>] {
        &self.servos
    }

    /// Returns the servos, so that the caller can change them, for example cause faults.
    pub fn servos_mut(&mut self) -> &mut [Servo<'m>] {
        &mut self.servos
    }

    /// Returns the simulated time, s.
    pub fn time_s(&self) -> f64 {
        self.now_ns as f64 * 1e-9
    }

    /// Returns the traffic on the wire so far.
    pub fn traffic(&self) -> Traffic {
        self.traffic
    }

    /// Runs the simulation for `us` microseconds without traffic.
    pub fn run_us(&mut self, us: u32) {
        self.run_until(self.now_ns + u64::from(us) * 1000);
    }

    /// Sends `bytes` from the master, and waits for replies for at most `wait_us` from the first byte on, or until
    /// `reply` returns true. A reply that arrives while the master does not listen is lost: a master empties its input
    /// before it sends. Returns the elapsed time, us.
    pub fn exchange(
        &mut self,
        bytes: &[u8],
        wait_us: u32,
        mut reply: impl FnMut(&[u8]) -> bool,
    ) -> u32 {
        let start_ns = self.now_ns;
        let end_ns = start_ns + u64::from(wait_us) * 1000;
        self.on_way.retain(|(at_ns, _)| *at_ns > start_ns);
        self.put_on_wire(bytes.len());
        self.traffic.sent += bytes.len() as u64;
        self.hear(bytes, None);
        let mut is_complete = reply(&[]);
        let mut was_silent = false;
        while !is_complete {
            let Some((speaker, delay_us)) = self.next_speaker() else {
                if let Some((at_ns, said)) = self.take_on_way(end_ns) {
                    self.run_until(at_ns.max(self.now_ns));
                    is_complete = reply(&said);
                    continue;
                }
                let silence_ns = self.now_ns + u64::from(SILENCE_US) * 1000;
                if was_silent || silence_ns > end_ns {
                    break;
                }
                self.run_until(silence_ns);
                was_silent = true;
                self.silence();
                continue;
            };
            was_silent = false;
            let Some((said, late_us)) = self.speak(speaker) else { continue };
            if late_us > 0 {
                // The other servos continue meanwhile, and this reply may collide with later bytes.
                let at_ns = self.now_ns + u64::from(delay_us + late_us) * 1000;
                self.on_way.push_back((at_ns + self.wire_ns(said.len()), said));
                continue;
            }
            self.run_until(self.now_ns + u64::from(delay_us) * 1000);
            self.put_on_wire(said.len());
            self.traffic.answered += said.len() as u64;
            self.hear(&said, Some(speaker));
            if self.now_ns <= end_ns {
                is_complete = reply(&said);
            } else {
                self.on_way.push_back((self.now_ns, said));
                break;
            }
        }
        if !is_complete {
            self.run_until(end_ns);
        }
        u32::try_from((self.now_ns - start_ns) / 1000).unwrap_or(u32::MAX)
    }

    /// Runs one tick of a master: its exchange cycle, then the rest of the time. A longer cycle makes the tick longer.
    ///
    /// # Errors
    /// The errors of [`ServoBus::plan`].
    pub fn tick(&mut self, bus: &mut impl ServoBus, tick_us: u32) -> Result<(), EncodeError> {
        let end_ns = self.now_ns + u64::from(tick_us) * 1000;
        let mut out = [0; 2 * LONGEST];
        let mut request = Some(bus.plan(&mut out)?);
        while let Some(asked) = request {
            self.exchange(&out[..asked.len], asked.time_us, |said| bus.reply(said));
            let left_us = end_ns.saturating_sub(self.now_ns) / 1000;
            request = bus.plan_more(u32::try_from(left_us).unwrap_or(u32::MAX), &mut out)?;
        }
        self.run_until(end_ns);
        Ok(())
    }

    fn put_on_wire(&mut self, bytes: usize) {
        let wire_ns = self.wire_ns(bytes);
        self.traffic.wire_ns += wire_ns;
        self.run_until(self.now_ns + wire_ns);
    }

    fn take_on_way(&mut self, end_ns: u64) -> Option<(u64, Vec<u8>)> {
        let (index, _) = self.on_way.iter().enumerate().min_by_key(|(_, (at_ns, _))| *at_ns)?;
        if self.on_way[index].0 > end_ns {
            return None;
        }
        self.on_way.remove(index)
    }

    fn step(&mut self) {
        if !self.faults.is_empty() {
            self.apply_faults();
        }
        let steps = self.plant.servo_steps().max(1);
        self.draws.fill(Draw::default());
        for (index, servo) in self.servos.iter_mut().enumerate() {
            let supply = self.fed_by[index];
            servo.step(self.supplies[supply].voltage_v(), &self.plant.load(index));
            let (all, own) = (&mut self.draws[supply], servo.draw());
            all.current_a += own.current_a;
            all.conductance_a_v += own.conductance_a_v;
            let (mean, push) = (&mut self.pushes[index], servo.push());
            mean.torque_nm += push.torque_nm / f64::from(steps);
            mean.slope_nm_s += push.slope_nm_s / f64::from(steps);
        }
        for (supply, draw) in self.supplies.iter_mut().zip(&self.draws) {
            supply.step(STEP_S, *draw);
        }
        self.plant_steps += 1;
        if self.plant_steps >= steps {
            self.plant_steps = 0;
            for (shaft, servo) in self.shafts.iter_mut().zip(&self.servos) {
                *shaft = servo.shaft();
            }
            let dt_s = STEP_S * f64::from(steps);
            self.plant.step(dt_s, &self.pushes, &mut self.shafts);
            for (servo, shaft) in self.servos.iter_mut().zip(&self.shafts) {
                servo.set_shaft(*shaft);
            }
            self.pushes.fill(Push::default());
        }
    }

    /// Applies the faults that act on the servos themselves. A fault begins and ends in the step that contains its
    /// time.
    fn apply_faults(&mut self) {
        let now_s = self.stepped_ns as f64 * 1e-9;
        let before_s = now_s - STEP_S;
        for fault in &self.faults {
            let Some(servo) = self.servos.get_mut(fault.servo) else { continue };
            let (is_on, was_on) = (fault.is_on(now_s), fault.is_on(before_s));
            let (begins, changes) = (is_on && !was_on, is_on != was_on);
            match fault.kind {
                FaultKind::Stuck if changes => servo.gear_mut().is_jammed = is_on,
                FaultKind::Hot(celsius) if is_on => servo.heat_mut().case_c = celsius,
                FaultKind::BrownOut if changes => servo.is_unplugged = is_on,
                FaultKind::Reboot if begins => servo.reboot(),
                FaultKind::TorqueLost if begins => servo.lose_torque(),
                FaultKind::TorqueStuck if changes => servo.stick_torque(is_on),
                FaultKind::EncoderJump(rad) if changes => {
                    servo.encoder_jump_rad = if is_on { rad } else { 0.0 };
                }
                _ => {}
            }
        }
    }
}

impl<P: Plant> LineDevice for Bench<'_, P> {
    fn now_ns(&self) -> u64 {
        self.now_ns
    }

    fn run_until(&mut self, ns: u64) {
        self.now_ns = self.now_ns.max(ns);
        while self.stepped_ns + STEP_NS <= self.now_ns {
            self.step();
            self.stepped_ns += STEP_NS;
        }
    }

    fn wire_ns(&self, bytes: usize) -> u64 {
        wire::took_ns(bytes, self.baud)
    }

    fn set_rate(&mut self, baud: u32) {
        self.baud = baud.max(1);
    }

    fn hear(&mut self, bytes: &[u8], speaker: Option<usize>) {
        wire::hear(&mut self.servos, self.baud, bytes, speaker);
    }

    fn next_speaker(&self) -> Option<(usize, u32)> {
        wire::next_speaker(&self.servos)
    }

    fn speak(&mut self, speaker: usize) -> Option<(Vec<u8>, u32)> {
        let time_s = self.time_s();
        wire::speak(self.servos.get_mut(speaker)?, speaker, &self.faults, time_s)
    }

    fn silence(&mut self) {
        self.servos.iter_mut().for_each(BusDevice::silence);
    }
}
