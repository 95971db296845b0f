//! Options of how a rig's servos are driven: by whoever simulates them, and by a board that gets its rig.

use clap::ValueEnum;
use sinew_performance::play::{Drive, Options};

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum DriveArg {
    /// The tracker's effort over the torque constant.
    Current,
    /// The target, and what gravity makes the servo sag taken off in advance.
    Position,
}

/// How servos are driven.
#[derive(Debug, Clone, Copy, clap::Args)]
pub(super) struct DrivenArgs {
    /// How servos are driven. Default: by current where they have a current mode, else by position.
    #[arg(long, value_enum)]
    drive: Option<DriveArg>,

    /// Ticks a second. Default: 500, or what bus and board have time for; where all servos are driven by position 100.
    #[arg(long, value_name = "HZ", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    rate: Option<u32>,

    /// Bits per second of all buses. Default: 4000000, on a board 3000000; of Feetech servos 1000000.
    #[arg(long, value_name = "RATE")]
    baud: Option<u32>,
}

impl DrivenArgs {
    /// Of a loop in this program.
    pub(super) fn here(self) -> Options {
        let drive = self.drive.map(|drive| match drive {
            DriveArg::Current => Drive::Current,
            DriveArg::Position => Drive::Position,
        });
        Options { drive, rate_hz: self.rate, baud: self.baud, ..Options::default() }
    }

    /// Of a board's.
    pub(super) fn on_board(self) -> Options {
        Options { is_of_board: true, ..self.here() }
    }
}
