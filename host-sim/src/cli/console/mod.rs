//! `sinew console`: a page that shows a rig, moves it and stops it.

mod browser;
mod recorded;
mod simulated;

use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context as _, anyhow, bail};
use sinew_board_client::{Board, ClientError, Line};
use sinew_console::{
    Console, Ended, Options, OwnShow, OwnShows, OwnSound, Scene, Source, idle_life,
};
use sinew_host_util::command::{note, print};
use sinew_performance::play::{RigParts, ServoChoice, ServoPart, put_servos};
use sinew_performance::rig::LoadedRig;
use sinew_rig::new;
use sinew_rig::servo::Address;
use sinew_servo_sim::fault::{Fault, FaultOrder};
use sinew_show::Show;
use sinew_show::sound::Sound;

use super::board::{check_rig, open};
use super::driven::DrivenArgs;
use super::output::OutputPath;
use super::performance::PerformanceArgs;
use super::play::{nucleo, show};
use super::rig::read;
use super::sound;
use super::stack::with_stack;
use super::stop::Stop;
use super::target::Target;
use super::unit_args::UnitArgs;

use browser::Redirect;

/// Number of joints of the arm that is used if no rig is given.
const JOINTS: usize = 6;

/// Show a rig live on a page in a browser, from which you move its joints by sliders, play shows, and stop the rig.
///
/// It prints the address of the page, which contains a secret token, opens the page in the browser of a desktop, and
/// serves the page until Ctrl-C. The page needs no network. The page can also show a recording, and then moves nothing.
/// Without --target, this program simulates a board with its servos; without --rig, the rig is a desk arm of six
/// joints.
///
/// One page drives; all pages may hold and stop the rig. Ctrl-C stops the rig: it goes to its rest pose and is lowered,
/// and torque is switched off. A second Ctrl-C ends at once.
#[derive(Debug, clap::Args)]
pub(super) struct ConsoleArgs {
    /// Shows of `sinew bake` for the page's list, or clips, which are first baked as by `sinew bake --fit`. Or a single
    /// recording of `sinew console --record` or `sinew play --record`.
    #[arg(value_name = "SHOW|CLIP|RECORDING")]
    shows: Vec<String>,

    /// A loop of idle life, such as that of `sinew clip idle` and `sinew bake --loop`. The page starts it. A show
    /// interrupts it, and after the show it continues where it was. The console sends the poses itself, so the loop
    /// needs no slot of the board.
    #[arg(long, value_name = "LOOP.show")]
    idle: Option<PathBuf>,

    /// The rig: rig.toml, URDF or MJCF. Default: the arm of `sinew rig new --arm 6`.
    #[arg(long, value_name = "RIG")]
    rig: Option<PathBuf>,

    /// Add a servo of this kind to each joint that has none, as `sinew play` does. May be repeated.
    #[arg(long, value_name = "[JOINT=]KIND")]
    servo: Vec<ServoChoice>,

    #[command(flatten)]
    driven: DrivenArgs,

    /// Place where the rig moves: `sim`, a simulated board in this program; `nucleo`, the emulated NUCLEO-F446RE, which
    /// is slower than real time; or the serial port of a board with this rig, such as /dev/ttyACM0, or the
    /// USB port where a board answers (`auto`).
    #[arg(long, value_name = "sim|nucleo|PORT", default_value_t = Target::Sim)]
    target: Target,

    /// A fault of a simulated servo, as in `sinew servo simulate`: `SERVO:WHAT[=HOW MUCH][@WHEN][+HOW LONG]`, such as
    /// 2:silent@20s+3s. SERVO is its id, or the name of the servo or of its joint. WHEN counts from the start of the
    /// console. May be repeated.
    #[arg(long, value_name = "FAULT")]
    fault: Vec<FaultOrder>,

    /// Serve the page also to other machines, at this address of this machine, such as 192.168.1.5 or 192.168.1.5:8080.
    /// Everybody who has the token can then watch and stop the rig. The connection is not encrypted.
    #[arg(long, value_name = "ADDRESS[:PORT]", value_parser = address)]
    listen: Option<SocketAddr>,

    /// Let pages on other machines drive the rig, too. Default: they can only watch, hold and stop.
    #[arg(long, requires = "listen")]
    allow_drive: bool,

    /// Let a show continue while no page drives. Default: the rig holds after 2 s without a driver, and is lowered 3 s
    /// later.
    #[arg(long)]
    unattended: bool,

    /// Record the session into this Parquet file, with 30 rows per second. `sinew report` and `sinew console` read it.
    /// Default: a button of the page begins and ends recordings, in files session-1.parquet, session-2.parquet, .. of
    /// the working folder.
    #[arg(long, value_name = "FILE.parquet")]
    record: Option<OutputPath>,

    /// Do not open the page in a browser. It is never opened without a desktop, over ssh, or if the output is not a
    /// terminal.
    #[arg(long)]
    no_open: bool,
}

fn address(text: &str) -> Result<SocketAddr, String> {
    let bare = text.parse::<IpAddr>().map(|ip| SocketAddr::new(ip, 0));
    bare.or_else(|_| text.parse()).map_err(|_| {
        "expected an address of this machine, such as 192.168.1.5 or [::1]:8080".to_owned()
    })
}

impl ConsoleArgs {
    /// Refuses a port without --rig, options that have no effect at a port, and faults on the target `nucleo`.
    pub(super) fn check(&self) -> anyhow::Result<()> {
        if self.target == Target::Nucleo {
            self.target.refuse(&[(!self.fault.is_empty(), "--fault")], "`--target sim`")?;
        }
        if let Target::Port(_) = self.target {
            self.target.refuse(&self.driven.given(), "the simulated board")?;
            self.target.refuse(&[(!self.fault.is_empty(), "--fault")], "the simulated board")?;
            if self.rig.is_none() {
                bail!("--target {}: --rig RIG names the rig that the board has", self.target);
            }
        }
        Ok(())
    }

    /// Opens the port from which pages are served.
    fn open(&self) -> anyhow::Result<Console> {
        let options = Options {
            listen: self.listen,
            allow_drive: self.allow_drive,
            unattended: self.unattended,
        };
        Console::open(options).context("the page's port")
    }

    /// Prints the addresses, and opens the first address in a browser.
    fn tell(&self, addresses: &[String]) -> anyhow::Result<Option<Redirect>> {
        for address in addresses {
            print(&format!("{address}\n"))?;
        }
        if let Some(listen) = self.listen.filter(|listen| !listen.ip().is_loopback()) {
            let may = if self.allow_drive { "watch, stop and drive" } else { "watch and stop" };
            let whole = listen.ip().is_unspecified();
            let at = if whole { ", at any address of this machine" } else { "" };
            note(format_args!(
                "other machines may {may} the rig{at}, with this token; the connection is not encrypted"
            ));
        }
        let opened = addresses.first().filter(|_| !self.no_open);
        Ok(opened.and_then(|address| browser::open(address)))
    }

    /// Returns the rig in the file, or the desk arm.
    fn rig(&self) -> anyhow::Result<LoadedRig> {
        let mut rig = if let Some(path) = &self.rig {
            read(path)?
        } else {
            let description = new::arm(JOINTS)?;
            let mechanism = description.mechanism()?;
            LoadedRig { description, mechanism, world: None, notes: Vec::new(), doubts: Vec::new() }
        };
        if put_servos(&mut rig.description, &self.servo).with_context(|| self.name())? > 0 {
            rig.mechanism = rig.description.mechanism()?;
        }
        Ok(rig)
    }

    fn name(&self) -> String {
        self.rig.as_deref().unwrap_or(Path::new("the desk arm")).display().to_string()
    }

    /// Returns the faults of the simulated servos.
    fn faults(&self, parts: &RigParts) -> anyhow::Result<Vec<Fault>> {
        let resolve = |order: &FaultOrder| {
            let is_it = |(index, part): (usize, &ServoPart)| {
                let (Address::Id(id) | Address::Channel(id)) = part.own.address;
                let of_joint = parts.first_servo.iter().position(|first| *first == Some(index));
                order.servo == part.own.name
                    || order.servo == id.to_string()
                    || of_joint.is_some_and(|joint| order.servo == parts.names[joint])
            };
            let servo = parts.servos.iter().enumerate().position(is_it);
            let servo =
                servo.with_context(|| format!("--fault: there is no servo `{}`", order.servo))?;
            Ok(order.of(servo))
        };
        self.fault.iter().map(resolve).collect()
    }

    /// Reads the shows and idle life, and bakes the clips.
    fn shows(&self, rig: &LoadedRig, parts: &RigParts) -> anyhow::Result<OwnShows> {
        let own = |path: &Path| {
            let crc = parts.rig_crc();
            let (bytes, sound) = if let Some(file) = show::read(path)? {
                (file.bytes, file.sound.and_then(|sound| own_sound(path, &sound)))
            } else {
                let mut on_rig = PerformanceArgs::default();
                on_rig.driven = self.driven.on_board();
                (show::bake((rig, crc), path, &on_rig, None, None, UnitArgs::default())?, None)
            };
            Show::open(&bytes)?.check_rig(crc).with_context(|| path.display().to_string())?;
            let stem = path.file_stem().unwrap_or(path.as_os_str());
            Ok(OwnShow { name: stem.to_string_lossy().into_owned(), bytes: bytes.into(), sound })
        };
        let shows = self.shows.iter().map(|name| own(Path::new(name)));
        let shows = shows.collect::<anyhow::Result<_>>()?;
        let idle = self.idle.as_deref().map(own).transpose()?;
        if let Some(idle) = &idle {
            let scene = Scene::new(&rig.description.name, &rig.mechanism, parts, Source::Simulated);
            idle_life(&idle.bytes, &scene).map_err(|why| anyhow!("--idle {}: {why}", idle.name))?;
        }
        Ok(OwnShows { shows, idle })
    }
}

/// Returns the sound of a show. If the file of the sound is missing, prints a warning and returns `None`.
fn own_sound(show: &Path, sound: &Sound) -> Option<OwnSound> {
    match sound::find(show, sound) {
        Ok(found) => Some(OwnSound {
            hash: sound::hex(&sound.sha256),
            name: sound.name.clone(),
            offset_s: sound.offset_us as f64 * 1e-6,
            bytes: found.bytes.into(),
        }),
        Err(error) => {
            note(format_args!("warning: {error:#}: the show plays without its sound"));
            None
        }
    }
}

/// Serves the page until a signal ends it.
pub(super) fn run(args: &ConsoleArgs) -> anyhow::Result<ExitCode> {
    with_stack(|| serve(args))
}

fn serve(args: &ConsoleArgs) -> anyhow::Result<ExitCode> {
    args.check()?;
    if let Some(recording) = args.recording()? {
        return args.replay(recording);
    }
    let rig = args.rig()?;
    let parts = RigParts::new(&rig.description, &rig.mechanism, args.driven.on_board());
    let parts = parts.with_context(|| args.name())?;
    let shows = args.shows(&rig, &parts)?;
    let faults = args.faults(&parts)?;
    let stop = Stop::new()?;
    let serve = |source| Served { args, rig: &rig, parts: &parts, source, stop: &stop };
    match &args.target {
        Target::Port(port) => {
            let (mut board, name) = open(Some(port), "--target")?;
            check_rig(&board, &parts)?;
            serve(Source::Board).on(&mut board, &name, shows)
        }
        Target::Nucleo => {
            let files = nucleo::Files::find()?;
            nucleo::with_board(&files, &rig, &parts, |board, _| {
                let name = format!("nucleo-{}", std::process::id());
                serve(Source::Simulated).on(board, &name, shows)
            })
        }
        Target::Sim => simulated::with_board(&rig, &parts, faults, |board| {
            let name = format!("simulated-{}", std::process::id());
            serve(Source::Simulated).on(board, &name, shows)
        }),
    }
}

/// Everything that a console needs, except its board and its shows.
struct Served<'a> {
    args: &'a ConsoleArgs,
    rig: &'a LoadedRig,
    parts: &'a RigParts,
    source: Source,
    stop: &'a Stop,
}

impl Served<'_> {
    fn on<L: Line>(
        self,
        board: &mut Board<L>,
        name: &str,
        own: OwnShows,
    ) -> anyhow::Result<ExitCode> {
        let Self { args, rig, parts, source, stop } = self;
        let console = args.open()?;
        let scene = Scene::new(&rig.description.name, &rig.mechanism, parts, source);
        let records = args.records(rig, parts)?;
        let _redirect = args.tell(&console.addresses())?;
        note(format_args!("open this address in a browser; Ctrl-C stops the rig and ends"));
        match console.run(board, &scene, (name, own, records), &|| stop.times()) {
            Ok(Ended::Stopped) => {
                note(format_args!("torque is off"));
                Ok(ExitCode::SUCCESS)
            }
            Ok(Ended::AtOnce) => {
                note(format_args!(
                    "ended at once: the board holds the pose, and lowers the rig after 2 s"
                ));
                Ok(ExitCode::FAILURE)
            }
            Err(ClientError::Refused(why)) => bail!("the controller refused: {why}"),
            Err(error) => Err(error.into()),
        }
    }
}
