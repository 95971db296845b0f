//! Tap test of a simulated servo, in simulated time.

use std::io;
use std::time::Duration;

use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::{MEMORY_LEN, Servo};
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::rig::RigServo as Loaded;
use sinew_servo_sim::supply::Supply;
use sinew_servo_sim::variation::{Change, Variation};
use sinew_servo_tools::rig_servo::RigServo;
use sinew_servo_tools::tap::{Settings, TapTest, Tapped};
use sinew_servo_tools::{Client, Exchange, Protocol, Settings as Patience};

/// The servo to tap instead of a servo at a port.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum TargetArg {
    /// A simulated servo with factory settings, alone with its load at the rig's home pose.
    Sim,
}

const BAUD: u32 = 1_000_000;
/// Steps of the gear for each step of the servo. With this number, the integration adds only a few per cent of damping.
const GEAR_STEPS: u32 = 20;
/// A controller's tick, s: the unit of the delay of readings.
const TICK_S: f64 = 1e-3;

/// Taps a simulated servo that moves only its own load.
pub(super) fn tap(
    servo: &RigServo,
    load: Loaded,
    changes: &[Change],
    settings: &Settings,
) -> anyhow::Result<Tapped> {
    let mut kind = load.kind;
    Variation::of(changes)?.change_servo(&mut kind, TICK_S);
    let mut memory = [0; MEMORY_LEN];
    let mut simulated = Servo::new(&kind, servo.id, &mut memory)?;
    simulated.set_baud(BAUD)?;
    simulated.place(load.home_rad);
    simulated.refine_gear(GEAR_STEPS);
    let bench = Bench::new(vec![simulated], vec![load.load], Supply::stiff(kind.voltage_v));
    let protocol = servo.protocol().unwrap_or(Protocol::Dynamixel);
    let mut client = Client::new(Line(bench), protocol, BAUD, Patience::default())?;
    let found = servo.open(&mut client)?;
    let test = TapTest::new(&mut client, &found, &servo.model, settings)?;
    Ok(test.run(&mut client)?)
}

/// A simulated bus line, in its own time.
struct Line<'m>(Bench<'m, Vec<Arm>>);

fn micros(time: Duration) -> u32 {
    u32::try_from(time.as_micros()).unwrap_or(u32::MAX)
}

impl Exchange for Line<'_> {
    fn exchange(
        &mut self,
        bytes: &[u8],
        wait: Duration,
        take: &mut dyn FnMut(&[u8]) -> bool,
    ) -> io::Result<()> {
        self.0.exchange(bytes, micros(wait), take);
        Ok(())
    }

    fn set_baud(&mut self, baud: u32) -> io::Result<()> {
        self.0.baud = baud;
        Ok(())
    }

    fn pause(&mut self, time: Duration) {
        self.0.run_us(micros(time));
    }

    fn now(&mut self) -> Duration {
        Duration::from_secs_f64(self.0.time_s())
    }
}
