//! The bus of a line, for any maker of servos.

use sinew_servo_bus::settings::ServoRequirements;
use sinew_servo_bus::{
    Command, CommandError, Compared, EncodeError, Feedback, Health, Limit, Request, ServoBus,
    dynamixel, feetech, pca9685,
};

/// The bus of a line with at most `SERVOS` servos.
#[derive(Debug, Clone)]
pub enum Bus<const SERVOS: usize> {
    /// A bus of Dynamixel servos.
    Dynamixel(dynamixel::Bus<SERVOS>),
    /// A bus of Feetech servos.
    Feetech(feetech::Bus<SERVOS>),
    /// A bus of hobby servos on a PCA9685: it plans I2C writes.
    Pca9685(pca9685::Bus),
}

macro_rules! of {
    ($bus:expr, $it:ident => $do:expr) => {
        match $bus {
            Self::Dynamixel($it) => $do,
            Self::Feetech($it) => $do,
            Self::Pca9685($it) => $do,
        }
    };
}

impl<const SERVOS: usize> ServoBus for Bus<SERVOS> {
    fn len(&self) -> usize {
        of!(self, bus => bus.len())
    }
    fn command(&mut self, servo: usize, command: Command) -> Result<Option<Limit>, CommandError> {
        of!(self, bus => bus.command(servo, command))
    }
    fn plan(&mut self, out: &mut [u8]) -> Result<Request, EncodeError> {
        of!(self, bus => bus.plan(out))
    }
    fn plan_more(&mut self, left_us: u32, out: &mut [u8]) -> Result<Option<Request>, EncodeError> {
        of!(self, bus => bus.plan_more(left_us, out))
    }
    fn reply(&mut self, bytes: &[u8]) -> bool {
        of!(self, bus => bus.reply(bytes))
    }
    fn compare(&mut self, asked: Option<(usize, ServoRequirements)>) {
        of!(self, bus => bus.compare(asked));
    }
    fn compared(&self) -> Compared {
        of!(self, bus => bus.compared())
    }
    fn feedback(&self, servo: usize) -> Option<Feedback> {
        of!(self, bus => bus.feedback(servo))
    }
    fn health(&self, servo: usize) -> Option<Health> {
        of!(self, bus => bus.health(servo))
    }
}
