//! Requests that the loop serves after a tick: packets to servos while torque is off, and measurements.

use heapless::Vec;
use sinew_link::message::{Applied, Cycles, Health, Pass, Passed, Refusal};
use sinew_servo_bus::ServoBus;

use super::board::Safety;
use super::control::ControlLoop;
use super::mail::{CommandId, LoopReply, Mail, PassthroughReply, Shared};
use super::pending::ServiceRequest;
use super::timing::{Spread, Timings};
use crate::controller::Wire;
use crate::supervisor::State;

/// The result of a request that was served after a tick.
#[expect(clippy::large_enum_variant, reason = "no heap to put it on; there is one at a time")]
enum ServiceReply {
    Passed(PassthroughReply),
    NotPassed(State),
    NoLine,
    TooLong,
    Measured(Health),
}

impl<const BODIES: usize, const DOFS: usize, const SERVOS: usize, const COORDS: usize>
    ControlLoop<'_, BODIES, DOFS, SERVOS, COORDS>
{
    /// Serves a request of the host, if torque is off and nobody moves the rig by hand. It takes as long as sending
    /// the bytes to servos and waiting for their reply, each at most
    /// [`PASS_WAIT_US`](sinew_link::message::PASS_WAIT_US).
    // Not inlined into the tick: the servos' reply would take stack during the whole tick.
    #[inline(never)]
    pub(super) fn serve<'m>(
        &mut self,
        board: &impl Safety,
        mail: &impl Shared<Mail<'m, DOFS, SERVOS, COORDS>>,
        bus: &mut impl ServoBus,
        wire: &mut impl Wire,
    ) {
        let Some((id, asked)) = self.service.take() else { return };
        let served = match asked {
            ServiceRequest::Health => ServiceReply::Measured(self.health(board)),
            ServiceRequest::Pass(pass) => self.pass(&pass, bus, wire),
        };
        mail.with(|mail| mail.put_served(id, served));
    }

    fn pass(&mut self, pass: &Pass, bus: &mut impl ServoBus, wire: &mut impl Wire) -> ServiceReply {
        let state = self.controller.report().state;
        let is_still = matches!(state, State::Off | State::Limp | State::Faulted);
        if self.controller.permission().torque || !is_still {
            return ServiceReply::NotPassed(state);
        }
        let Some(own) = wire.rate(pass.line) else { return ServiceReply::NoLine };
        let baud = if pass.baud == 0 { own } else { pass.baud };
        let Some(sending_us) = pass.sending_us(baud) else { return ServiceReply::TooLong };
        let wait_us = sending_us.saturating_add(pass.wait_us);
        let mut came = Vec::new();
        let took = wire.pass(pass.line, pass.baud, &pass.bytes, wait_us, |bytes| {
            for byte in bytes {
                // Excess bytes are lost, as if nobody read the line.
                let _ = came.push(*byte);
            }
        });
        // The packet may have written a register.
        self.controller.forget_registers(bus);
        took.map_or(ServiceReply::NoLine, |took_us| {
            ServiceReply::Passed(PassthroughReply { bytes: came, took_us })
        })
    }

    fn health(&mut self, board: &impl Safety) -> Health {
        let Timings { tick, bus, period } = self.timing().take();
        Health {
            cycles_hz: board.cycles_hz(),
            tick: cycles(tick),
            bus: cycles(bus),
            // The background task measures the link's cycles.
            link: Cycles::default(),
            period: cycles(period),
            supply_least_v: self.supply.0.unwrap_or(0.0),
        }
    }
}

pub(super) fn cycles(Spread { least, mean, most, count }: Spread) -> Cycles {
    Cycles { least, mean, most, count }
}

impl<const DOFS: usize, const SERVOS: usize, const COORDS: usize> Mail<'_, DOFS, SERVOS, COORDS> {
    /// Stores the result of a request that the loop has served.
    fn put_served(&mut self, id: CommandId, served: ServiceReply) {
        let said = match served {
            ServiceReply::Passed(of_servos) => {
                self.of_servos = of_servos;
                LoopReply::Passed
            }
            ServiceReply::NotPassed(state) => LoopReply::NotPassed(state),
            ServiceReply::NoLine => LoopReply::NoLine,
            ServiceReply::TooLong => LoopReply::TooLong,
            ServiceReply::Measured(health) => {
                self.health = health;
                LoopReply::Measured
            }
        };
        // There is room: at most one command is in progress, and a stop.
        let _ = self.answers.push_back((id, said));
    }

    /// Returns the servos' reply, from a byte offset on.
    pub(super) fn of_servos(&self, offset: u16) -> Result<Applied, Refusal> {
        let PassthroughReply { bytes, took_us } = &self.of_servos;
        let count = u16::try_from(bytes.len()).unwrap_or(u16::MAX);
        let rest = bytes.get(usize::from(offset)..);
        let rest = rest.ok_or(Refusal::Offset { next: count.into() })?;
        // The answer contains as many bytes as it has room for.
        let mut bytes = Vec::new();
        for byte in rest {
            if bytes.push(*byte).is_err() {
                break;
            }
        }
        Ok(Applied::Passed(Passed { count, took_us: *took_us, bytes }))
    }
}
