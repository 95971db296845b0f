//! Options of the line, and the servos on it.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context as _;
use sinew_service::{Client, Protocol, SerialLine, Servo, Settings, find};
use sinew_sim::command::note;

/// Options of the line.
#[derive(Debug, clap::Args)]
pub(super) struct LineArgs {
    /// The serial port, such as /dev/ttyUSB0, or the link of `sinew servos --pty`.
    #[arg(long, value_name = "PORT", global = true)]
    bus: Option<PathBuf>,

    /// The servos' protocol. Default: that of the rig's servos; else both are tried.
    #[arg(long, value_enum, global = true)]
    protocol: Option<ProtocolArg>,

    /// Their rate, bits per second. Default: all rates of the protocol are tried, the factory's first.
    #[arg(long, value_name = "BAUD", global = true, value_parser = rate)]
    baud: Option<u32>,

    /// How long to wait for an answer, in ms. Adapters with an FTDI chip keep bytes for up to 16 ms.
    #[arg(long, value_name = "MS", global = true, default_value_t = 34, value_parser = wait_ms)]
    wait: u64,

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
pub(super) type PortClient = Client<SerialLine>;

impl LineArgs {
    /// Opens the port, at the first rate that may be.
    pub(super) fn client(&self) -> anyhow::Result<PortClient> {
        let path = self.bus.as_deref().context(
            "which port? `--bus PORT` names it, such as /dev/ttyUSB0, or the link of `sinew servos --pty`",
        )?;
        let protocol = self.protocols().first().copied().unwrap_or(Protocol::Dynamixel);
        let baud = self.baud.unwrap_or(protocol.bauds()[0]);
        let settings = Settings { patience: Duration::from_millis(self.wait), tries: self.tries };
        Ok(Client::new(SerialLine::open(path)?, protocol, baud, settings)?)
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
