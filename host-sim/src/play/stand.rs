//! Servos, their lines and the controller, in lock-step: a tick a call.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use sinew_bus::dynamixel::table::address;
use sinew_bus::{Effort, ServoBus as _};
use sinew_core::glam::Quat;
use sinew_core::{JointKind, math};
use sinew_firmware::controller::{
    ControllerError, Incomplete, Inputs, Report, Start, Wire, exchange,
};
use sinew_firmware::supervisor::{Command, FaultSet, Permission};
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::{MEMORY_LEN, Servo, ServoError};
use sinew_servo_sim::load::Plant;
use sinew_servo_sim::registers::RegisterTable;
use sinew_servo_sim::supply::Supply;
use sinew_show::ShowError;
use thiserror::Error;

use super::bus::Buses;
use super::parts::{Parts, PartsError};
use super::servo_part::mode;
use super::twin::{Twin, TwinError};
use super::{FREEDOMS, Loop, SERVOS};

/// Registers of one servo.
pub type Memory = [u8; MEMORY_LEN];

/// Room for the packets of a tick of one line.
const OUT_LEN: usize = 2048;
/// Of FNV-1a, 64 bits.
const FNV: (u64, u64) = (0xcbf2_9ce4_8422_2325, 0x0100_0000_01b3);

/// Why there is no stand.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StandError {
    /// A line cannot be.
    #[error(transparent)]
    Parts(#[from] PartsError),
    /// The controller does not take the rig.
    #[error("the controller refuses the rig: {0}")]
    Controller(#[from] ControllerError),
    /// A servo cannot be simulated.
    #[error("servo `{servo}`: {reason}")]
    Servo {
        /// Which.
        servo: String,
        /// Why.
        reason: ServoError,
    },
    /// The show does not play on the rig.
    #[error("the show does not play on this rig: {0}")]
    Show(#[from] ShowError),
}

/// What was on the wires, and how often the time of a tick was not enough.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wires {
    /// Bytes of the controller.
    pub sent: u64,
    /// Bytes of servos.
    pub answered: u64,
    /// FNV-1a of all of them, in their order.
    pub hash: u64,
}

/// A rig on a stand, under its controller.
pub struct Stand<'a, P> {
    /// What it is made of.
    pub parts: &'a Parts,
    controller: Box<Loop<'a>>,
    buses: Buses,
    benches: Vec<Bench<'a, P>>,
    wires: Wires,
    ticks: u64,
    /// Ticks that were not whole: the watchdog was not fed.
    incomplete: u64,
    last: Option<Incomplete>,
    /// Another controller, whose packets the servos get.
    twin: Option<Rc<RefCell<Twin>>>,
}

impl<'a, P: Plant> Stand<'a, P> {
    /// A stand just before power comes on, each servo where the rig's home has it. `memories`: one for each servo;
    /// `plants`: what the servos of each line move.
    ///
    /// # Errors
    /// [`StandError`].
    pub fn new(
        parts: &'a Parts,
        show: &'a [u8],
        memories: &'a mut [Memory],
        plants: Vec<P>,
    ) -> Result<Self, StandError> {
        let start = Start::default();
        let controller =
            Loop::new(&parts.board, &parts.settings, &parts.setups, &parts.schedule, start)?;
        let mut controller = Box::new(controller);
        controller.load_show(Some(show))?;
        let mut servos: Vec<Vec<Servo>> = parts.lines.iter().map(|_| Vec::new()).collect();
        for (part, memory) in parts.servos.iter().zip(memories) {
            let failed = |reason| StandError::Servo { servo: part.own.name.clone(), reason };
            let id = part.own.id.unwrap_or_default();
            let mut servo = Servo::new(&part.own.kind, id, memory).map_err(failed)?;
            let line = part.place.0;
            servo.set_baud(parts.lines[line].baud).map_err(failed)?;
            if let Some(RegisterTable::Dynamixel(_)) = RegisterTable::of(&part.own.kind.name) {
                // Return delay 2 µs; writes are not answered.
                for (register, value) in [
                    (address::RETURN_DELAY, 1),
                    (address::STATUS_LEVEL, 1),
                    (address::OPERATING_MODE, mode(part.drive).number().into()),
                ] {
                    servo.set(register, value);
                }
            }
            servo.place(part.own.home_rad);
            servos[line].push(servo);
        }
        let lines = servos.into_iter().zip(plants).enumerate();
        let benches = lines.map(|(line, (servos, plant))| {
            Bench::new(servos, plant, Supply::stiff(parts.voltage_v(line)))
        });
        let places = parts.servos.iter().map(|part| part.place).collect();
        Ok(Self {
            parts,
            controller,
            buses: Buses::new(parts.buses()?, places),
            benches: benches.collect(),
            wires: Wires { sent: 0, answered: 0, hash: FNV.0 },
            ticks: 0,
            incomplete: 0,
            last: None,
            twin: None,
        })
    }

    /// The same, with the packets of a twin, which must be those of the controller here.
    #[must_use]
    pub fn with_twin(mut self, twin: Twin) -> Self {
        let twin = Rc::new(RefCell::new(twin));
        self.buses = self.buses.with_twin(&twin);
        self.twin = Some(twin);
        self
    }

    /// Ticks and packets of the twin until now, if there is one.
    ///
    /// # Errors
    /// What it said that was different, or why it is gone.
    pub fn check_twin(&self) -> Result<Option<[u64; 2]>, TwinError> {
        let Some(twin) = &self.twin else { return Ok(None) };
        let mut twin = twin.borrow_mut();
        twin.check()?;
        Ok(Some(twin.compared()))
    }

    /// A tick; the host's link is heard in each.
    pub fn tick(&mut self, command: Option<Command>) {
        let tick_us = u64::from(self.parts.tick_us());
        let inputs = Inputs {
            now_us: self.ticks * tick_us,
            heard: true,
            command,
            found: FaultSet::EMPTY,
            jog: None,
        };
        self.ticks += 1;
        if let Some(twin) = &self.twin {
            twin.borrow_mut().begin(command);
        }
        let Self { controller, buses, benches, wires, .. } = self;
        let begun = controller.begin(&inputs, &mut (), buses);
        let start_s: Vec<f64> = benches.iter().map(Bench::time_s).collect();
        let end_s = 1e-6 * (self.ticks * tick_us) as f64;
        let mut out = [0; OUT_LEN];
        let exchanged = {
            let mut line = Lines { benches, turn: buses.turn(), end_s, wires };
            exchange(buses, &mut line, &mut out)
        };
        let took_s = benches.iter().zip(start_s).map(|(bench, start_s)| bench.time_s() - start_s);
        let took_us = whole_us(took_s.fold(0.0, f64::max)) + self.parts.settings.compute_us;
        let ended = controller.end(begun, exchanged, took_us);
        if let Some(twin) = &self.twin {
            twin.borrow_mut().end(took_us, ended.is_ok(), controller);
        }
        match ended {
            Ok(_) => {}
            Err(why) => {
                self.incomplete += 1;
                self.last = Some(why);
            }
        }
        for bench in benches {
            bench.run_us(whole_us(end_s - bench.time_s()));
        }
    }

    /// What became of the last tick.
    pub fn report(&self) -> &Report<FREEDOMS, SERVOS> {
        self.controller.report()
    }

    /// What drives may do.
    pub fn permission(&self) -> &Permission {
        self.controller.permission()
    }

    /// Commanded and measured position of each freedom: of a ball joint the rotation vector.
    pub fn freedoms(&self) -> [Vec<f32>; 2] {
        let q = [self.controller.commanded().0, self.controller.measured()];
        q.map(|mut q| {
            let mut positions = Vec::new();
            for body in self.parts.board.tree().bodies() {
                let kind = body.joint;
                let (own, rest) = q.split_at(kind.coordinate_count().min(q.len()));
                q = rest;
                match (kind, own) {
                    (JointKind::Spherical, &[x, y, z, w]) => {
                        positions.extend(math::log(Quat::from_xyzw(x, y, z, w)).to_array());
                    }
                    // A free joint, which has other numbers, is refused.
                    _ => positions.extend_from_slice(own),
                }
            }
            positions
        })
    }

    /// Current of a servo as it tells it, A; what it tells as load is a part of its stall current.
    pub fn current_a(&self, servo: usize) -> Option<f32> {
        Some(match self.buses.feedback(servo)?.effort {
            Effort::Current(current_a) => current_a,
            Effort::Load(share) => share * self.parts.setups[servo].stall_a,
        })
    }

    /// What limits a joint now: its effort, its first servo's drive, the guard, or heat and supply.
    pub fn limiter(&self, freedom: usize) -> Option<String> {
        let effort = self.report().freedoms[freedom].limit.map(|limit| format!("{limit:?}"));
        let of_servo = || {
            let servo = &self.report().servos[self.parts.first_servo[freedom]?];
            let drive = servo.limit.map(|limit| format!("{limit:?}"));
            let concern = || servo.concern.filter(|_| servo.share < 1.0);
            drive
                .or_else(|| servo.guard.map(|guard| format!("{guard:?}")))
                .or_else(|| concern().map(|concern| format!("{concern:?}")))
        };
        effort.or_else(of_servo).map(|limit| limit.to_lowercase())
    }

    /// Whether every servo has told its temperature: drives give nothing before.
    pub fn is_known(&self) -> bool {
        self.report().servos.iter().all(|servo| servo.temperature_c.is_some())
    }

    /// Ticks since power-on.
    pub fn ticks(&self) -> u64 {
        self.ticks
    }

    /// Simulated time since power-on, s.
    pub fn time_s(&self) -> f64 {
        1e-6 * (self.ticks * u64::from(self.parts.tick_us())) as f64
    }

    /// Ticks that were not whole, and why the last of them was not.
    pub fn incomplete(&self) -> (u64, Option<Incomplete>) {
        (self.incomplete, self.last)
    }

    /// What was on the wires.
    pub fn wires(&self) -> Wires {
        self.wires
    }

    /// How many simulated servos have their torque on, by their registers.
    pub fn servos_on(&self) -> usize {
        let on = |part: &super::ServoPart| {
            let (line, place) = part.place;
            let register = match RegisterTable::of(&part.own.kind.name) {
                Some(RegisterTable::Dynamixel(_)) => address::TORQUE_ENABLE,
                _ => sinew_bus::feetech::table::address::TORQUE_ENABLE.into(),
            };
            self.benches[line].servos()[place].get(register) == 1
        };
        self.parts.servos.iter().filter(|part| on(part)).count()
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it saturates")]
fn whole_us(seconds: f64) -> u32 {
    (1e6 * seconds).round().max(0.0) as u32
}

/// The lines during one tick.
struct Lines<'s, 'a, P> {
    benches: &'s mut Vec<Bench<'a, P>>,
    turn: Rc<Cell<usize>>,
    end_s: f64,
    wires: &'s mut Wires,
}

impl<P: Plant> Wire for Lines<'_, '_, P> {
    fn exchange(&mut self, bytes: &[u8], wait_us: u32, mut reply: impl FnMut(&[u8]) -> bool) {
        let Self { benches, turn, wires, .. } = self;
        wires.sent += bytes.len() as u64;
        wires.note(bytes);
        benches[turn.get()].exchange(bytes, wait_us, |said| {
            wires.answered += said.len() as u64;
            wires.note(said);
            reply(said)
        });
    }

    fn left_us(&self) -> u32 {
        // No line talks any more once all have had their turn.
        self.benches
            .get(self.turn.get())
            .map_or(0, |bench| whole_us((self.end_s - bench.time_s()).max(0.0)))
    }
}

impl Wires {
    fn note(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.hash = (self.hash ^ u64::from(*byte)).wrapping_mul(FNV.1);
        }
    }
}
