//! Servos that reach a commanded position at once, so that hours of a show run in seconds.

use sinew_firmware::controller::Wire;
use sinew_servo_bus::settings::ServoRequirements;
use sinew_servo_bus::{
    Command, CommandError, Compared, Effort, EncodeError, Feedback, Health, Limit, Request,
    ServoBus,
};

use super::test_rig::hash_of;

pub(crate) struct Ideal(pub(crate) Vec<f32>);

impl ServoBus for Ideal {
    fn len(&self) -> usize {
        self.0.len()
    }
    fn command(&mut self, servo: usize, command: Command) -> Result<Option<Limit>, CommandError> {
        match command {
            Command::Position(rad)
            | Command::PositionWithin { position_rad: rad, .. }
            | Command::PositionAt { position_rad: rad, .. } => self.0[servo] = rad,
            _ => {}
        }
        Ok(None)
    }
    /// Writes the positions.
    fn plan(&mut self, out: &mut [u8]) -> Result<Request, EncodeError> {
        for (out, rad) in out.as_chunks_mut::<4>().0.iter_mut().zip(&self.0) {
            *out = rad.to_le_bytes();
        }
        Ok(Request { len: 4 * self.0.len(), ..Request::default() })
    }
    fn plan_more(&mut self, _: u32, _: &mut [u8]) -> Result<Option<Request>, EncodeError> {
        Ok(None)
    }
    fn reply(&mut self, _: &[u8]) -> bool {
        true
    }
    fn compare(&mut self, _: Option<(usize, ServoRequirements)>) {}
    fn compared(&self) -> Compared {
        Compared::Nothing
    }
    fn feedback(&self, servo: usize) -> Option<Feedback> {
        let effort = Effort::Load(0.0);
        let position_rad = *self.0.get(servo)?;
        Some(Feedback { position_rad, velocity_rad_s: 0.0, effort, age_ticks: 0 })
    }
    fn health(&self, servo: usize) -> Option<Health> {
        let health =
            Health { voltage_v: Some(7.4), temperature_c: Some(25.0), ..Health::default() };
        (servo < self.0.len()).then_some(health)
    }
}

/// A line without servos.
pub(crate) struct NoServos<'h> {
    pub(crate) hash: &'h mut u64,
}

impl Wire for NoServos<'_> {
    fn exchange(&mut self, bytes: &[u8], _: u32, _: impl FnMut(&[u8]) -> bool) {
        hash_of(self.hash, bytes);
    }
    fn left_us(&self) -> u32 {
        0
    }
}
