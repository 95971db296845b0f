//! Options that select how servos are driven: in the simulator, and on a board that gets its rig.

use clap::ValueEnum;
use sinew_performance::play::{Drive, Options};

/// Quantity that servos receive each tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum DriveArg {
    /// The current that gives the tracker's torque.
    Current,
    /// The duty cycle (PWM) that makes the current for the tracker's torque flow. The motor's winding adds damping.
    /// Only for Dynamixels.
    Voltage,
    /// The target position. The angle by which the expected torque, such as that of gravity, makes the servo sag is
    /// added in advance.
    Position,
}

impl DriveArg {
    /// Returns the options for a loop in this program, with this drive if one is given.
    pub(super) fn options(drive: Option<Self>) -> Options {
        let drive = drive.map(|drive| match drive {
            Self::Current => Drive::Current,
            Self::Voltage => Drive::Voltage,
            Self::Position => Drive::Position,
        });
        Options { drive, ..Options::default() }
    }
}

/// Options that select how servos are driven.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub(super) struct DrivenArgs {
    /// Quantity that servos receive each tick. Default: `current` for servos that have a current mode, else
    /// `position`.
    #[arg(long, value_enum)]
    drive: Option<DriveArg>,

    /// Control rate in Hz. Default: 100 if all servos are in position mode, otherwise 500; less if bus or board need
    /// more time for a tick.
    #[arg(long, value_name = "HZ", value_parser = rate_hz)]
    rate_hz: Option<u32>,

    /// Rate of all bus lines, in bit/s. Default: 4000000; for a board and for `nucleo` 3000000; for Feetech servos
    /// 1000000.
    #[arg(long, value_name = "RATE")]
    baud: Option<u32>,
}

fn rate_hz(text: &str) -> Result<u32, String> {
    let rate_hz = text.trim().parse().ok().filter(|hz| (1..=10_000).contains(hz));
    rate_hz.ok_or_else(|| "expected a whole number from 1 to 10000".to_owned())
}

impl DrivenArgs {
    /// Returns, for each option, whether it is given, and its name.
    pub(super) const fn given(&self) -> [(bool, &'static str); 3] {
        [
            (self.drive.is_some(), "--drive"),
            (self.rate_hz.is_some(), "--rate-hz"),
            (self.baud.is_some(), "--baud"),
        ]
    }

    /// Returns the options for a loop in this program.
    pub(super) fn here(self) -> Options {
        let Self { drive, rate_hz, baud } = self;
        Options { rate_hz, baud, ..DriveArg::options(drive) }
    }

    /// Returns the options for a loop on a board.
    pub(super) fn on_board(self) -> Options {
        Options { is_of_board: true, ..self.here() }
    }
}
