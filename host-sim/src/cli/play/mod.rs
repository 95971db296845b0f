//! `sinew play`: plays a show on a rig, with the controller of the boards.

mod board;
mod live;
mod notes;
pub(super) mod nucleo;
mod real_time;
pub(super) mod show;
mod sim;

use std::io::{self, IsTerminal as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context as _, ensure};
use sinew_host_util::command::note;
use sinew_performance::play::{RigParts, ServoChoice, put_servos};
use sinew_performance::rig_hash;
use sinew_servo_sim::variation::{Change, Variation};
use sinew_show::Show;
use sinew_show::sound::Sound;

use super::board::SilenceArg;
use super::clips::seconds;
use super::driven::DrivenArgs;
use super::performance::{ON_STAND, PerformanceArgs};
use super::sound::{self, Player, PlayerCommand};
use super::stack::with_stack;
use super::target::Target;
use super::unit_args::UnitArgs;
use crate::cli::output::OutputPath;

/// Rounds of a loop that does not play in real time.
const ROUNDS: u32 = 2;

/// Play a show on a rig: on simulated servos, or on a board.
///
/// The controller is the one that boards run. The simulated rig hangs on a stand. After power-on the rig is armed where
/// it is, moves to the show's first pose at 20 deg/s at most, and plays. Then it moves to its rest pose and is lowered,
/// and torque is switched off. At the end a table shows how well each joint followed. In the simulator, every run of
/// the same command sends the same bytes to the servos.
///
/// On a terminal it plays in real time and shows the joints with the largest errors. Ctrl-C stops the rig safely: it
/// moves to its rest pose and is lowered, then torque is off. A second Ctrl-C ends the program at once.
///
/// The exit code is 1 if a fault ended the show, 2 if the board does not answer any more.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// A show of `sinew bake`, or a clip: the name of a built-in clip, or a file. The command first bakes a clip into a
    /// show, as `sinew bake --fit` does.
    #[arg(value_name = "SHOW|CLIP")]
    show: String,

    /// The rig: rig.toml, URDF or MJCF.
    #[arg(long, value_name = "RIG")]
    rig: PathBuf,

    /// Add a servo of this kind to each joint that has none: xl330, xl430, xm430, mx-28, mx-64, sts3215, ... With a
    /// name, only to joints of that name: `l_knee=xm430`, `l_*=xm430`. May be repeated.
    #[arg(long, value_name = "[JOINT=]KIND")]
    servo: Vec<ServoChoice>,

    #[command(flatten)]
    driven: DrivenArgs,

    /// Where the show plays: `sim`, simulated servos under the controller in this program; `nucleo`, the
    /// NUCLEO-F446RE's image on an emulated chip with simulated servos, several times slower than real time; or the
    /// serial port of a controller board, such as /dev/ttyACM0, or the USB port where a board answers (`auto`).
    ///
    /// A board must have this rig; the command uploads the show if the board lacks it. Ctrl-C stops the rig: it goes to
    /// its rest pose and is lowered, and torque is switched off. `cargo xtask emulate` builds the emulator and the
    /// image of `nucleo`. The environment variables `SINEW_EMULATOR` and `SINEW_NUCLEO_IMAGE` select other files.
    #[arg(long, value_name = "sim|nucleo|PORT", default_value_t = Target::Sim)]
    target: Target,

    /// Let the simulated plant differ from the rig's file, on which the controller relies: a factor on one of
    /// `stiffness`, `play` and `damping` of gears, `friction`, `rotor` and `torque` of servos, and `masses` of
    /// bodies; or a value for `output-friction`, the part of friction at output shafts, 0 to 1, or `delay`, the added
    /// age of readings in ticks. May be repeated.
    #[arg(long, value_name = "NAME=FACTOR")]
    plant: Vec<Change>,

    #[command(flatten)]
    silence: SilenceArg,

    #[command(flatten)]
    pace: Pace,

    /// Mapping of a clip's joints to the rig's, in TOML, as `sinew clip map` proposes it. Default: by names and
    /// geometry.
    #[arg(long, value_name = "FILE")]
    mapping: Option<PathBuf>,

    #[command(flatten)]
    on_rig: PerformanceArgs,

    #[command(flatten)]
    units: UnitArgs,

    /// Record every tick into this Parquet file, which `sinew report` and pandas can read. It contains time, state,
    /// whether the show ran, and faults; for each joint its command, measurement, error, effort and limiter; for each
    /// servo its current, temperature and voltage.
    #[arg(long, value_name = "FILE.parquet")]
    record: Option<OutputPath>,

    /// Command that plays the show's sound: it is started with the show, and ended with the show. `{}` is replaced by
    /// the file, `{s}` by the time of the sound at which the show starts, in s. Example: `aplay -q {}`. Requires real
    /// time, and the sound's file in the folder of the show or in the working directory. The console needs no player.
    #[arg(long, value_name = "COMMAND")]
    sound_with: Option<PlayerCommand>,

    /// Number of rounds of a looping show. Default: in real time, the show loops until Ctrl-C; otherwise 2 rounds.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    rounds: Option<u32>,

    /// Time from arming to the start of the show, in s. The rig waits, then moves to the first pose. Refused if that
    /// motion takes longer. Default: the show starts as soon as the rig is at its first pose.
    #[arg(long, value_name = "S", value_parser = preroll, allow_negative_numbers = true)]
    preroll: Option<f64>,

    /// Play only the first S seconds of a clip.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    seconds: Option<f64>,
}

/// Options for the pace.
#[derive(Debug, clap::Args)]
struct Pace {
    /// Play as fast as the machine computes. Default if standard output is not a terminal.
    #[arg(long, conflicts_with = "real_time")]
    fast: bool,

    /// Play in real time. Default if standard output is a terminal.
    #[arg(long)]
    real_time: bool,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    with_stack(|| play(args))
}

fn play(args: &Args) -> anyhow::Result<ExitCode> {
    args.check()?;
    let variation = Variation::of(&args.plant)?;
    // Missing files are reported before the motion is fitted.
    args.find_files()?;
    let nucleo = (args.target == Target::Nucleo).then(nucleo::Files::find).transpose()?;
    let mut rig = args.on_rig.rig(&args.rig, ON_STAND)?;
    let (bare, _) = rig_hash(&rig.description, &rig.mechanism);
    let count = put_servos(&mut rig.description, &args.servo)
        .with_context(|| args.rig.display().to_string())?;
    if count > 0 {
        rig.mechanism = rig.description.mechanism()?;
        note(format_args!("{count} joint(s) of {} get servos by --servo", rig.description.name));
    }
    let mut parts = RigParts::new(&rig.description, &rig.mechanism, args.options())
        .with_context(|| args.rig.display().to_string())?;
    parts.vary(variation);
    notes::tell(&parts, !matches!(args.target, Target::Port(_)));
    if let Some(plant) = args.varied() {
        note(format_args!("the simulated plant differs from {}: {plant}", args.rig.display()));
    }
    let show = args.read_or_bake(&rig, &mut parts, bare)?;
    let player = args.player(show.sound.as_ref())?;
    let bytes = show.bytes;
    let rounds = |is_watched| args.rounds(&Show::open(&bytes)?, is_watched);
    match (&args.target, nucleo) {
        (Target::Port(port), _) => {
            let timing = board::Timing { rounds: rounds(true)?, preroll_s: args.preroll };
            board::perform(port, args.silence.time(), (&rig, &parts), &bytes, timing, player)
        }
        (Target::Nucleo, Some(files)) => {
            // Emulation is slower than real time, so loops end by themselves.
            let timing = board::Timing { rounds: rounds(false)?, preroll_s: args.preroll };
            nucleo::perform(&files, &rig, &parts, &bytes, timing)
        }
        (Target::Sim | Target::Nucleo, _) => args.simulate(&rig, &parts, &bytes, player),
    }
}

impl Args {
    /// Refuses options that have no effect on the target.
    pub(super) fn check(&self) -> anyhow::Result<()> {
        let of_sim = [
            (self.record.is_some(), "--record"),
            (self.pace.fast, "--fast"),
            (self.pace.real_time, "--real-time"),
        ];
        if self.target != Target::Sim {
            self.target.refuse(&of_sim, "`--target sim`")?;
        }
        if matches!(self.target, Target::Port(_)) {
            self.target.refuse(&self.driven.given(), "simulated servos: the board has its own")?;
            let of_plant = [(!self.plant.is_empty(), "--plant")];
            self.target.refuse(&of_plant, "simulated servos: the board has its own")?;
        } else {
            self.target.refuse(&[(self.silence.is_given(), "--silence-s")], "a board at a port")?;
        }
        Ok(())
    }

    /// Returns the player of the show's sound; `None` without `--sound-with`.
    fn player(&self, sound: Option<&Sound>) -> anyhow::Result<Option<Player>> {
        let Some(command) = &self.sound_with else {
            if let Some(sound) = sound.filter(|_| self.is_real_time()) {
                note(format_args!(
                    "note: the show has a sound, {}: `--sound-with 'aplay -q {{}}'` plays it",
                    sound.name
                ));
            }
            return Ok(None);
        };
        let path = Path::new(&self.show);
        let sound = sound.with_context(|| {
            format!("--sound-with: {} has no sound: `sinew bake --sound` adds it", path.display())
        })?;
        let is_in_time = self.is_real_time() || matches!(self.target, Target::Port(_));
        ensure!(is_in_time, "--sound-with: sounds need real time: expected --real-time");
        let found = sound::find(path, sound)?;
        command.player(&found.path, sound).map(Some)
    }

    /// Returns whether a simulation runs in real time.
    fn is_real_time(&self) -> bool {
        self.pace.real_time || !self.pace.fast && io::stdout().is_terminal()
    }

    /// Refuses files that do not exist. A clip without an extension may be built in.
    fn find_files(&self) -> anyhow::Result<()> {
        let show = Some(Path::new(&self.show)).filter(|show| show.extension().is_some());
        for path in show.into_iter().chain(self.mapping.as_deref()) {
            path.metadata().with_context(|| path.display().to_string())?;
        }
        Ok(())
    }

    /// Returns the changes of the simulated plant as text; `None` if there are none.
    fn varied(&self) -> Option<String> {
        let changes: Vec<String> = self.plant.iter().map(ToString::to_string).collect();
        (!changes.is_empty()).then(|| changes.join(", "))
    }

    /// Returns the number of rounds after which a loop is stopped; `None` for a show that ends by itself, or for a
    /// loop that plays until Ctrl-C.
    fn rounds(&self, show: &Show<'_>, is_watched: bool) -> anyhow::Result<Option<u32>> {
        ensure!(
            show.is_loop() || self.rounds.is_none(),
            "--rounds: {} is not a loop: `sinew bake --loop` makes one",
            self.show
        );
        Ok(self.rounds.or((show.is_loop() && !is_watched).then_some(ROUNDS)))
    }
}

fn preroll(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(seconds) if (0.0..=300.0).contains(&seconds) => Ok(seconds),
        _ => Err("expected a number of seconds from 0 to 300".into()),
    }
}
