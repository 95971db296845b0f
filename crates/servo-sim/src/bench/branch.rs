//! One of several bus lines to the servos of a bench.

use std::cell::{Ref, RefCell, RefMut};
use std::ops::Range;
use std::rc::Rc;

use sinew_servo_bus::BusDevice;
use sinew_servo_bus::pca9685::Prescale;

use super::{Bench, Chip, chip};
use crate::device::Servo;
use crate::line::LineDevice;
use crate::load::Plant;
use crate::wire;

/// One bus line of a bench with several lines. All lines share the bench's plant, supplies and time, so servos on
/// different lines affect each other.
pub struct Branch<'m, P> {
    bench: Rc<RefCell<Bench<'m, P>>>,
    /// Indices of this line's servos on the bench.
    servos: Range<usize>,
    baud: u32,
    /// PWM chip between the master and servos that take pulses, if any.
    chip: Option<Box<Chip>>,
}

impl<'m, P: Plant> Branch<'m, P> {
    /// Creates the lines of a bench whose servos are sorted by line. `counts` are the numbers of servos on the lines.
    /// Each line starts at the baud rate of its first servo.
    ///
    /// # Panics
    /// If the bench has fewer servos than the sum of `counts`.
    pub fn of(bench: Bench<'m, P>, counts: &[usize]) -> Vec<Self> {
        let mut begin = 0;
        let ranges = counts.iter().map(|count| {
            let servos = begin..begin + count;
            begin = servos.end;
            let baud = bench.servos[servos.clone()].first().map_or(1_000_000, Servo::baud).max(1);
            (servos, baud)
        });
        let ranges: Vec<_> = ranges.collect();
        let bench = Rc::new(RefCell::new(bench));
        let branch = |(servos, baud)| Self { bench: Rc::clone(&bench), servos, baud, chip: None };
        ranges.into_iter().map(branch).collect()
    }

    /// Connects a PWM chip between the master and this line's servos, which take pulses. The master then sends I2C at
    /// `i2c_hz`.
    pub fn put_chip(&mut self, chip: Chip, i2c_hz: u32) {
        (self.chip, self.baud) = (Some(Box::new(chip)), i2c_hz.max(1));
        self.pulse();
    }

    /// Starts the line's chip, if it has one, like a board does.
    pub fn start_chip(&mut self, prescale: Prescale) {
        if let Some(chip) = &mut self.chip {
            chip.start(prescale);
            self.pulse();
        }
    }

    /// Drives the pin OE of the line's chip, if it has one. With `on` false, no servo of this line receives a pulse.
    pub fn enable_pulses(&mut self, on: bool) {
        if let Some(chip) = &mut self.chip {
            chip.enable(on);
            self.pulse();
        }
    }

    /// Passes the chip's pulses to the servos.
    fn pulse(&mut self) {
        let Some(chip) = &self.chip else { return };
        let servos = &mut self.bench.borrow_mut().servos[self.servos.clone()];
        for (index, servo) in servos.iter_mut().enumerate() {
            servo.set_pulse(chip.pulse_us(index));
        }
    }

    /// Returns the bench of all lines.
    pub fn bench(&self) -> Ref<'_, Bench<'m, P>> {
        self.bench.borrow()
    }

    /// Returns the bench of all lines, so that the caller can change it, for example add faults or set registers.
    pub fn bench_mut(&mut self) -> RefMut<'_, Bench<'m, P>> {
        self.bench.borrow_mut()
    }
}

impl<P: Plant> LineDevice for Branch<'_, P> {
    fn now_ns(&self) -> u64 {
        self.bench.borrow().now_ns
    }

    fn run_until(&mut self, ns: u64) {
        self.bench.borrow_mut().run_until(ns);
    }

    fn wire_ns(&self, bytes: usize) -> u64 {
        if self.chip.is_some() {
            chip::took_ns(bytes, self.baud)
        } else {
            wire::took_ns(bytes, self.baud)
        }
    }

    fn set_rate(&mut self, baud: u32) {
        self.baud = baud.max(1);
    }

    fn hear(&mut self, bytes: &[u8], speaker: Option<usize>) {
        if let Some(chip) = &mut self.chip {
            chip.write(bytes);
            self.pulse();
            return;
        }
        let servos = &mut self.bench.borrow_mut().servos[self.servos.clone()];
        wire::hear(servos, self.baud, bytes, speaker);
    }

    fn next_speaker(&self) -> Option<(usize, u32)> {
        wire::next_speaker(&self.bench.borrow().servos[self.servos.clone()])
    }

    fn speak(&mut self, speaker: usize) -> Option<(Vec<u8>, u32)> {
        let bench = &mut *self.bench.borrow_mut();
        let (place, time_s) = (self.servos.start + speaker, bench.time_s());
        wire::speak(bench.servos.get_mut(place)?, place, &bench.faults, time_s)
    }

    fn silence(&mut self) {
        let servos = &mut self.bench.borrow_mut().servos[self.servos.clone()];
        servos.iter_mut().for_each(BusDevice::silence);
    }
}
