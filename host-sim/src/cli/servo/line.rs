//! Options of the line, and the servos on it.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context as _;
use sinew_board_client::BoardServos;
use sinew_host_util::command::note;
use sinew_servo_tools::{Client, Exchange, Protocol, SerialLine, Servo, Settings, find};

use crate::cli::board::open;

/// Options of the line.
#[derive(Debug, clap::Args)]
pub(super) struct LineArgs {
    /// The serial port, such as /dev/ttyUSB0, or the link of `sinew servos --pty`.
    #[arg(long, value_name = "PORT", global = true)]
    bus: Option<PathBuf>,

    /// Through the controller at this port, in place of --bus: it passes packets on while its rig is limp, off or
    /// faulted. Without a value, or `auto`: the one at a USB port that answers. Its torque stays off: `identify` cannot
    /// move a servo.
    #[arg(
        long,
        value_name = "PORT",
        global = true,
        num_args = 0..=1,
        default_missing_value = "auto",
        conflicts_with = "bus"
    )]
    board: Option<PathBuf>,

    /// Which of the board's lines of servos, from 0.
    #[arg(long, value_name = "N", global = true, default_value_t = 0, requires = "board")]
    line: u8,

    /// The servos' protocol. Default: that of the rig's servos; else both are tried.
    #[arg(long, value_enum, global = true)]
    protocol: Option<ProtocolArg>,

    /// Their rate, bits per second. Default: all rates of the protocol are tried, the factory's first.
    #[arg(long, value_name = "BAUD", global = true, value_parser = rate)]
    baud: Option<u32>,

    /// How long to wait for an answer, in ms. Adapters with an FTDI chip keep bytes for up to 16 ms. Default: 34;
    /// through a board 5.
    #[arg(long, value_name = "MS", global = true, value_parser = wait_ms)]
    wait: Option<u64>,

    /// How often to ask before a servo counts as silent.
    #[arg(long, value_name = "N", global = true, default_value_t = 3, value_parser = tries)]
    tries: u32,

    /// Take the registers of this model, for a servo that is not in the list.
    #[arg(long, value_name = "NAME", global = true)]
    model: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum ProtocolArg {
    /// Dynamixel 2.0.
    Dynamixel,
    /// Feetech STS, SMS, SCS.
    Feetech,
}

fn within<T: std::str::FromStr + PartialOrd + std::fmt::Display>(
    text: &str,
    [least, most]: [T; 2],
) -> Result<T, String> {
    match text.trim().parse::<T>() {
        Ok(number) if (&least..=&most).contains(&&number) => Ok(number),
        _ => Err(format!("expected a whole number from {least} to {most}")),
    }
}

fn rate(text: &str) -> Result<u32, String> {
    within(text, [1_200, 12_000_000])
}

fn wait_ms(text: &str) -> Result<u64, String> {
    within(text, [1, 10_000])
}

fn tries(text: &str) -> Result<u32, String> {
    within(text, [1, 100])
}

/// A client on the port.
pub(super) type PortClient = Client<Box<dyn Exchange>>;

impl LineArgs {
    /// Opens the port, at the first rate that may be.
    pub(super) fn client(&self) -> anyhow::Result<PortClient> {
        let (line, wait_ms): (Box<dyn Exchange>, u64) = if let Some(path) = &self.board {
            (Box::new(BoardServos::new(open(Some(path))?, self.line)?), 5)
        } else {
            let path = self.bus.as_deref().context(
                "which port? `--bus PORT` names it, such as /dev/ttyUSB0, or the link of `sinew servos --pty`; `--board \
                 PORT` goes through a controller",
            )?;
            (Box::new(SerialLine::open(path)?), 34)
        };
        let protocol = self.protocols().first().copied().unwrap_or(Protocol::Dynamixel);
        let baud = self.baud.unwrap_or(protocol.bauds()[0]);
        let patience = Duration::from_millis(self.wait.unwrap_or(wait_ms));
        Ok(Client::new(line, protocol, baud, Settings { patience, tries: self.tries })?)
    }

    /// The port of the servos, if a controller answers there: nothing that is done with servos can come of it.
    pub(super) fn of_controller(&self) -> Option<&Path> {
        self.bus.as_deref().filter(|path| sinew_board_client::port::has_controller(path))
    }

    /// Which protocols may be.
    pub(super) fn protocols(&self) -> Vec<Protocol> {
        match self.protocol {
            Some(ProtocolArg::Dynamixel) => vec![Protocol::Dynamixel],
            Some(ProtocolArg::Feetech) => vec![Protocol::Feetech],
            None => Protocol::ALL.to_vec(),
        }
    }

    /// Which rates may be; empty for all.
    pub(super) fn bauds(&self) -> Vec<u32> {
        self.baud.into_iter().collect()
    }

    /// The servo of an id, wherever it answers; where that is is said on standard error, unless it was told.
    pub(super) fn servo(&self, id: u8) -> anyhow::Result<(PortClient, Servo)> {
        let mut client = self.client()?;
        let servo = self.find(&mut client, id, &self.protocols())?;
        Ok((client, servo))
    }

    /// The same on a line that is open.
    pub(super) fn find(
        &self,
        client: &mut PortClient,
        id: u8,
        protocols: &[Protocol],
    ) -> anyhow::Result<Servo> {
        let servo = find(client, id, protocols, self.baud, self.model.as_deref())?;
        if self.baud.is_none() {
            let (model, baud) = (servo.table.model(), client.baud());
            let protocol = client.protocol().name();
            note(format_args!(
                "servo {id}: {model}, firmware {}, {protocol} at {baud} baud",
                servo.firmware
            ));
        }
        Ok(servo)
    }
}
