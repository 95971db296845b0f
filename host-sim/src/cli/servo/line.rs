//! Options for the port of servos, and opening servos on it.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context as _;
use sinew_board_client::BoardServos;
use sinew_host_util::command::note;
use sinew_servo_tools::rig_servo::RigServo;
use sinew_servo_tools::{
    Client, Exchange, Protocol, SerialLine, ServiceError, Servo, Settings, find, left,
};

use crate::cli::board::open;
use crate::cli::stop;

/// Options for the port of servos.
#[derive(Debug, clap::Args)]
pub(super) struct LineArgs {
    /// Serial port of the servos, such as /dev/ttyUSB0, or the link of `sinew servo simulate`.
    #[arg(long, value_name = "PORT", global = true)]
    port: Option<PathBuf>,

    /// Serial port of a controller board that passes packets on to its servos, instead of --port. Without a value, or
    /// with `auto`: the USB port where a board answers. Its rig must be limp, off or faulted. Torque stays off, so
    /// `identify` and `tap` cannot move a servo.
    #[arg(
        long,
        value_name = "PORT",
        global = true,
        num_args = 0..=1,
        default_missing_value = "auto",
        conflicts_with = "port"
    )]
    board: Option<PathBuf>,

    /// Number of the board's bus line, from 0.
    #[arg(long, value_name = "N", global = true, default_value_t = 0, requires = "board")]
    line: u8,

    /// Protocol of the servos. Default: the protocol of the rig's servos; without a rig, both protocols are tried.
    #[arg(long, value_enum, global = true)]
    protocol: Option<ProtocolArg>,

    /// Rate of the servos, in bit/s. Default: all rates of the protocol are tried, the factory setting first.
    #[arg(long, value_name = "BAUD", global = true, value_parser = rate)]
    baud: Option<u32>,

    /// Longest time to wait for an answer, in ms. Adapters with an FTDI chip hold received bytes back for up to 16 ms.
    /// Default: 34; through a board 5.
    #[arg(long, value_name = "MS", global = true, value_parser = wait_ms)]
    timeout_ms: Option<u64>,

    /// Number of unanswered questions after which a servo counts as silent.
    #[arg(long, value_name = "N", global = true, default_value_t = 3, value_parser = tries)]
    tries: u32,

    /// Use the registers of this model, for a servo whose model number is unknown.
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
    /// Opens the port, at the first possible rate.
    pub(super) fn client(&self) -> anyhow::Result<PortClient> {
        let (line, wait_ms): (Box<dyn Exchange>, u64) = if let Some(path) = &self.board {
            (Box::new(BoardServos::new(open(Some(path), "--board")?.0, self.line)?), 5)
        } else {
            let path = self.port.as_deref().context(
                "which port? `--port PORT` names it, such as /dev/ttyUSB0, or the link of `sinew servo simulate`; \
                 `--board PORT` goes through a controller",
            )?;
            (Box::new(SerialLine::open(path)?), 34)
        };
        let protocol = self.protocols().first().copied().unwrap_or(Protocol::Dynamixel);
        let baud = self.baud.unwrap_or(protocol.bauds()[0]);
        let patience = Duration::from_millis(self.timeout_ms.unwrap_or(wait_ms));
        let settings = Settings { patience, tries: self.tries };
        let mut client = Client::new(line, protocol, baud, settings)?;
        client.stop_at(stop::flag()?);
        Ok(client)
    }

    /// Returns the port of --port if a controller answers there: then commands for servos cannot work on it.
    pub(super) fn of_controller(&self) -> Option<&Path> {
        self.port.as_deref().filter(|path| sinew_board_client::port::has_controller(path))
    }

    /// Returns the possible protocols.
    pub(super) fn protocols(&self) -> Vec<Protocol> {
        match self.protocol {
            Some(ProtocolArg::Dynamixel) => vec![Protocol::Dynamixel],
            Some(ProtocolArg::Feetech) => vec![Protocol::Feetech],
            None => Protocol::ALL.to_vec(),
        }
    }

    /// Returns the given rate; empty if all rates are possible.
    pub(super) fn bauds(&self) -> Vec<u32> {
        self.baud.into_iter().collect()
    }

    /// Finds the servo with an id. Its protocol and rate are printed to standard error, unless the rate was given.
    pub(super) fn servo(&self, id: u8) -> anyhow::Result<(PortClient, Servo)> {
        let mut client = self.client()?;
        let servo = self.find(&mut client, id, &self.protocols())?;
        tell_left(&mut client, &servo);
        Ok((client, servo))
    }

    /// Opens a servo for a command that moves or changes it. Also checks whether a program left another servo of the
    /// bus line in the middle of its work.
    pub(super) fn servo_to_change(&self, id: u8) -> anyhow::Result<(PortClient, Servo)> {
        let (mut client, servo) = self.servo(id)?;
        tell_left_on_line(&mut client, servo.id)?;
        Ok((client, servo))
    }

    /// Finds the servo with an id on an open port.
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

/// Opens a servo of a rig, and prints a note if a program left it in the middle of its work.
pub(super) fn open_rig_servo(
    client: &mut PortClient,
    servo: &RigServo,
) -> Result<Servo, ServiceError> {
    let found = servo.open(client)?;
    tell_left(client, &found);
    Ok(found)
}

/// Prints a note for every other servo of the bus line that a program left in the middle of its work.
pub(super) fn tell_left_on_line(client: &mut PortClient, known: u8) -> anyhow::Result<()> {
    for (id, left) in left::on_line(client, known)? {
        note(format_args!("servo {id}: {}", left.what));
    }
    Ok(())
}

/// Prints a note if a program left the servo in the middle of its work.
fn tell_left(client: &mut PortClient, servo: &Servo) {
    // An error is ignored: the next question to the servo reports it.
    if let Ok(Some(left)) = left::look(client, servo) {
        note(format_args!("servo {}: {}", servo.id, left.what));
    }
}
