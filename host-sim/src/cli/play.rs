//! `sinew play`: a show on simulated servos, under the controller of the boards.

mod board;
mod emulated;
mod live;
pub(super) mod stop;

use std::io::{self, IsTerminal as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::{Context as _, bail, ensure};
use sinew_firmware::supervisor::{Fault, Refused};
use sinew_host_util::command::{note, print};
use sinew_host_util::output;
use sinew_mocap::Kind;
use sinew_performance::play::{
    Director, Drive, Ended, Memory, Parts, Recorder, ServoChoice, Stand, Tally, put_servos,
};
use sinew_performance::rig::Loaded;
use sinew_performance::{Baker, Marks, rig_hash};
use sinew_rig::toml_file;
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_show::Show;
use sinew_show::write::Settings as ShowSettings;

use super::clips::seconds;
use super::driven::DrivenArgs;
use super::performance::{ON_STAND, OnRig};
use super::target::Target;
use super::told::ToldArgs;
use live::Live;
use stop::Stop;

/// What hobby servos bear by the common rule, us.
const SAFE_PULSES_US: [f32; 2] = [1000.0, 2000.0];
/// Rounds of a loop that nobody watches.
const ROUNDS: u32 = 2;
/// A controller with all its capacities is built on the stack.
const STACK_BYTES: usize = 256 << 20;

/// Play a show on a rig: on simulated servos, or on a board.
///
/// The controller is the one that boards run. The simulated rig hangs on a stand. Power comes on; the rig is armed
/// where it is, and goes to the show's first pose at 20 deg/s at most; it plays, goes to its rest pose, and is limp
/// again. At the end a table shows how well each joint followed. Every run of a command puts the same bytes on the
/// wire.
///
/// On a terminal it plays in real time and shows the joints that follow worst. Ctrl-C stops the rig safely: it goes to
/// rest, then torque is off. A second Ctrl-C ends at once.
///
/// The exit code is 1 if a fault ended the show.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// A show of `sinew bake`; or a clip, built in or a file, which is baked as by `sinew bake --fit`.
    #[arg(value_name = "SHOW|CLIP")]
    show: String,

    /// The rig: rig.toml, URDF or MJCF.
    #[arg(long, value_name = "RIG")]
    rig: PathBuf,

    /// Put a servo of this kind on each joint that has none: xl330, xl430, xm430, mx-28, mx-64, sts3215, ... With a
    /// name, on the joints of that name: `l_knee=xm430`, `l_*=xm430`. May be repeated.
    #[arg(long, value_name = "[JOINT=]KIND")]
    servo: Vec<ServoChoice>,

    #[command(flatten)]
    driven: DrivenArgs,

    /// Where the show plays: `sim`, simulated servos under the controller in this program; `nucleo`, the
    /// NUCLEO-F446RE's image on an emulated chip with simulated servos, several times slower than real time; or the
    /// serial port of a controller board, such as /dev/ttyACM0, or the USB port where a board answers (`auto`).
    ///
    /// A board must have this rig; the command uploads the show if the board lacks it. Ctrl-C stops the rig: it goes to
    /// its rest pose, is lowered, and torque is off. `cargo xtask emulate` builds the emulator and the image of
    /// `nucleo`; `SINEW_EMULATOR` and `SINEW_NUCLEO_IMAGE` name others.
    #[arg(long, value_name = "sim|nucleo|PORT", default_value_t = Target::Sim)]
    target: Target,

    #[command(flatten)]
    pace: Pace,

    /// Mapping of a clip's joints to the rig's, in TOML, as `sinew clip map` proposes it. Default: by names and
    /// geometry.
    #[arg(long, value_name = "FILE")]
    mapping: Option<PathBuf>,

    #[command(flatten)]
    on_rig: OnRig,

    #[command(flatten)]
    told: ToldArgs,

    /// Record every tick into this Parquet file, which `sinew report` and pandas read: time, state, whether the show
    /// ran, faults; of each joint its command, measurement, error, effort and limiter; of each servo current,
    /// temperature and voltage.
    #[arg(long, value_name = "FILE.parquet")]
    record: Option<PathBuf>,

    /// Number of rounds of a show that is a loop. Default: in real time until Ctrl-C, else 2.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    rounds: Option<u32>,

    /// Play only the first S seconds of a clip.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    seconds: Option<f64>,
}

/// Options of the pace.
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

/// Runs what builds a controller, with stack enough for it.
pub(super) fn with_stack<T: Send>(
    run: impl FnOnce() -> anyhow::Result<T> + Send,
) -> anyhow::Result<T> {
    std::thread::scope(|scope| {
        let builder = std::thread::Builder::new().stack_size(STACK_BYTES);
        let done = builder.spawn_scoped(scope, run)?.join();
        done.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

fn play(args: &Args) -> anyhow::Result<ExitCode> {
    args.check()?;
    let written: Vec<&Path> = args.record.iter().map(PathBuf::as_path).collect();
    let read = [
        ("rig", Some(args.rig.as_path())),
        ("show", Some(Path::new(&args.show))),
        ("mapping", args.mapping.as_deref()),
    ];
    output::distinct(&written, &read)?;
    // What is missing is said before anything is fitted.
    let emulated = (args.target == Target::Nucleo).then(emulated::found).transpose()?;
    let mut rig = args.on_rig.rig(&args.rig, ON_STAND)?;
    let (bare, _) = rig_hash(&rig.description, &rig.mechanism);
    let count = put_servos(&mut rig.description, &args.servo)
        .with_context(|| args.rig.display().to_string())?;
    if count > 0 {
        rig.mechanism = rig.description.mechanism()?;
        note(format_args!("{count} joint(s) of {} get servos by --servo", rig.description.name));
    }
    let of_rig = || args.rig.display().to_string();
    let of_record =
        || args.record.iter().map(|path| path.display().to_string()).collect::<String>();
    let options =
        if args.target == Target::Nucleo { args.driven.on_board() } else { args.driven.here() };
    let mut parts = Parts::new(&rig.description, &rig.mechanism, options).with_context(of_rig)?;
    tell(&parts);
    let bytes = args.bytes(&rig, &mut parts, bare)?;
    if let Some(ended) = args.on_board(emulated.as_ref(), &rig, &parts, &bytes)? {
        return Ok(ended);
    }
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
    let plant = parts.plant(&rig.description, &rig.mechanism).with_context(of_rig)?;
    let mut stand = Stand::new(&parts, Some(&bytes), &mut memories, plant).with_context(of_rig)?;
    let mut recorder = args.recorder(&rig, &parts)?;
    let is_real_time = args.pace.real_time || !args.pace.fast && io::stdout().is_terminal();
    let stop = Stop::new()?;
    let show = Show::open(&bytes)?;
    let rounds = args.rounds(&show, is_real_time)?;
    let round_ticks = f64::from(show.duration_s()) * f64::from(parts.rate_hz);
    let is_over = |tally: &Tally| {
        rounds.is_some_and(|rounds| tally.ticks() as f64 >= f64::from(rounds) * round_ticks)
    };
    let mut live = Live::new(&show);
    let (mut director, mut tally) = (Director::default(), Tally::new(&parts));
    let start = Instant::now();
    let ended = loop {
        let ended = director.tick(&mut stand, stop.times() > 0 || is_over(&tally));
        tally.note(&stand);
        if let Some(recorder) = &mut recorder {
            recorder.note(&stand).with_context(of_record)?;
        }
        live.show(&stand, director.waits_for());
        if ended.is_some() || stop.times() > 1 {
            break ended;
        }
        if is_real_time {
            let due = Duration::from_secs_f64(stand.time_s());
            std::thread::sleep(due.saturating_sub(start.elapsed()));
        }
    };
    live.end();
    if let Some(recorder) = recorder {
        recorder.end().with_context(of_record)?;
        note(format_args!("wrote {}", of_record()));
    }
    print(&tally.table(&stand, director.raised()))?;
    Ok(match ended {
        Some(Ended::Done | Ended::Stopped) => ExitCode::SUCCESS,
        Some(Ended::Faults(faults)) => {
            for fault in Fault::ALL.into_iter().filter(|fault| faults.contains(*fault)) {
                note(format_args!("{fault}: {} {}", fault.when(), fault.remedy()));
            }
            ExitCode::from(1)
        }
        Some(Ended::Refused(why @ Refused::RegisterDiffers(differs))) => {
            let name = &parts.servos[usize::from(differs.servo)].own.name;
            bail!("the controller refused (servo {} is `{name}`): {why}", differs.servo)
        }
        Some(Ended::Refused(why)) => bail!("the controller refused: {why}"),
        None => {
            note(format_args!("ended at once: torque was left on at {} servos", stand.servos_on()));
            ExitCode::from(1)
        }
    })
}

/// What the loop is.
fn tell(parts: &Parts) {
    for (index, line) in parts.lines.iter().enumerate() {
        let count = line.servos.len();
        let by = |drive| line.servos.iter().filter(|s| parts.servos[**s].drive == drive).count();
        if line.is_of_pulses() {
            note(format_args!(
                "bus {:?}: {count} servos on pulses of a PCA9685, I2C at {} bit/s; {} Hz, nothing is read",
                line.name, line.baud, parts.rate_hz
            ));
            continue;
        }
        let (currents, positions) = (by(Drive::Current), by(Drive::Position));
        let each = match parts.groups(index) {
            1 => "all read in each tick".to_owned(),
            groups => format!("each read once in {groups} ticks"),
        };
        note(format_args!(
            "bus {:?}: {count} servos at {} bit/s, {currents} by current, {positions} by position; {} Hz, {each}",
            line.name, line.baud, parts.rate_hz
        ));
    }
    tell_pulses(parts);
    let (compute_us, holds) = parts.on_board;
    if holds != Some(parts.rate_hz) {
        let holds =
            holds.map_or_else(|| "no rate of this loop".to_owned(), |hz| format!("{hz} Hz"));
        note(format_args!(
            "{} Hz are of this simulation: by the estimate a board of 180 MHz computes {:.1} ms a tick for {} servos, and \
             holds {holds} (docs/speed.md)",
            parts.rate_hz,
            f64::from(compute_us) / 1000.0,
            parts.servos.len()
        ));
    }
    let idle: Vec<&str> = (parts.names.iter().zip(&parts.drives))
        .filter(|(_, drive)| drive.is_none())
        .map(|(name, _)| name.as_str())
        .collect();
    if !idle.is_empty() {
        note(format_args!("no servo moves {}", idle.join(", ")));
    }
}

/// What hobby servos get at the ends of their joints' ranges.
fn tell_pulses(parts: &Parts) {
    let all = parts.pulses_us();
    let told = |of: &[&(&str, [f32; 2])]| {
        let each = of.iter().map(|(name, [least, most])| {
            format!("{name} {:.2} to {:.2} ms", 1e-3 * least, 1e-3 * most)
        });
        each.collect::<Vec<_>>().join(", ")
    };
    let [safe_least, safe_most] = SAFE_PULSES_US;
    let (safe, wide): (Vec<_>, Vec<_>) =
        (all.iter()).partition(|(_, [least, most])| *least >= safe_least && *most <= safe_most);
    if !safe.is_empty() {
        note(format_args!("pulses within the joints' ranges: {}", told(&safe)));
    }
    if !wide.is_empty() {
        note(format_args!(
            "warning: pulses outside of 1.0 to 2.0 ms, where many servos stall at an end: try them by hand first: {}",
            told(&wide)
        ));
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
        }
        Ok(())
    }

    /// On a controller of its own, at a port or emulated; none if it is to be in this program.
    fn on_board(
        &self,
        emulated: Option<&[PathBuf; 2]>,
        rig: &Loaded,
        parts: &Parts,
        bytes: &[u8],
    ) -> anyhow::Result<Option<ExitCode>> {
        // Nobody watches an emulated one in real time.
        let rounds = |is_real_time| self.rounds(&Show::open(bytes)?, is_real_time);
        match (&self.target, emulated) {
            (Target::Port(port), _) => board::perform(port, parts, bytes, rounds(true)?).map(Some),
            (Target::Nucleo, Some(found)) => {
                emulated::perform(found, rig, parts, bytes, rounds(false)?).map(Some)
            }
            (Target::Nucleo | Target::Sim, _) => Ok(None),
        }
    }

    /// The bytes of the show: read, or baked of a clip.
    fn bytes(&self, rig: &Loaded, parts: &mut Parts, bare: u32) -> anyhow::Result<Vec<u8>> {
        let path = Path::new(&self.show);
        let read = sinew_mocap::read::bytes(path);
        if let Err(error) = &read
            && path.extension().is_some_and(|extension| extension == "show")
        {
            bail!("{}: {error}", path.display());
        }
        let bytes = match read {
            Ok(bytes) if Kind::of(path, &bytes) == Some(Kind::Show) => {
                Show::open(&bytes).with_context(|| path.display().to_string())?;
                Some(bytes)
            }
            Ok(bytes) if path.extension().is_some_and(|extension| extension == "show") => {
                let found = Kind::found(Kind::of(path, &bytes));
                bail!("{}: expected a show of `sinew bake --rig`, found {found}", path.display());
            }
            _ => None,
        };
        let Some(bytes) = bytes else {
            return self.baked(rig, parts.rig_crc());
        };
        let clip_only = self.mapping.as_ref().map(|_| "--mapping");
        let clip_only = clip_only.or(self.seconds.map(|_| "--seconds"));
        if let Some(option) = clip_only.or(self.on_rig.of_clips()).or(self.told.given()) {
            bail!("{option}: is of clips, and {} is a show", path.display());
        }
        let show = Show::open(&bytes)?;
        if show.check_rig(parts.rig_crc()).is_err() && show.check_rig(bare).is_ok() {
            note(format_args!(
                "note: {} was baked before servos were put on the rig: it may ask more of them than they can",
                path.display()
            ));
            parts.take_shows_of(bare);
        }
        Ok(bytes)
    }

    /// After how many rounds a loop is stopped; none of a show that ends by itself, or of one that goes on.
    fn rounds(&self, show: &Show<'_>, is_real_time: bool) -> anyhow::Result<Option<u32>> {
        ensure!(
            show.is_loop() || self.rounds.is_none(),
            "--rounds: {} is no loop: `sinew bake --loop` makes one",
            self.show
        );
        Ok(self.rounds.or((show.is_loop() && !is_real_time).then_some(ROUNDS)))
    }

    fn recorder(&self, rig: &Loaded, parts: &Parts) -> anyhow::Result<Option<Recorder>> {
        let begin = |path: &PathBuf| {
            let rig = toml_file::write(&rig.description);
            let recorder = Recorder::new(path, parts, &rig, &[("show", &self.show)]);
            recorder.with_context(|| path.display().to_string())
        };
        self.record.as_ref().map(begin).transpose()
    }

    fn baked(&self, rig: &Loaded, crc: u32) -> anyhow::Result<Vec<u8>> {
        let mut on_rig = self.on_rig.clone();
        on_rig.fit = true;
        let (clip, mapping) = (Path::new(&self.show), self.mapping.as_deref());
        let mut performed =
            on_rig.perform(rig, clip, mapping, self.seconds, (ON_STAND, self.told))?;
        let fit = performed.fit.take().context("a clip is fitted")?;
        let (given, limits) = (&performed.taken.motion, &performed.limits);
        let baker =
            Baker { mechanism: &rig.mechanism, rig: crc, settings: ShowSettings::default() };
        let (_, baked, _) = baker.bake_within(limits, given, fit, Marks::of_none)?;
        note(format_args!("{}: {:.2} s, fitted to the rig", performed.name, baked.duration_s));
        Ok(baked.written.bytes)
    }
}
