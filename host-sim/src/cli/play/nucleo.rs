//! `--target nucleo` of `sinew play` and `sinew console`: the image of the NUCLEO-F446RE, on an emulated chip with
//! simulated servos.

use std::cell::Cell;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::rc::Rc;
use std::time::Duration;

use anyhow::{Context as _, bail, ensure};
use sinew_board_client::{Board, Line as BoardLine, item, nonce};
use sinew_firmware::node::RIG_SCHEMA;
use sinew_host_util::command::{note, print};
use sinew_link::message::Kind;
use sinew_nucleo::{BoardOnServos, EmulatedBoard, Machine};
use sinew_performance::play::{Line, Memory, RigParts};
use sinew_performance::rig::LoadedRig;
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::line::LineDevice;

use super::board::{Timing, perform_on};
use crate::cli::board::put;

/// The emulator: the environment variable that names it, and the path in cargo's target folder where `cargo xtask
/// emulate` puts it.
const TOOL: (&str, &str) = ("SINEW_EMULATOR", "emulator/release/sinew-emulator");
/// The board's image: its environment variable, and its path in cargo's target folder.
const IMAGE: (&str, &str) = ("SINEW_NUCLEO_IMAGE", "arm/nucleo_f446re.elf");
/// Pin of the emergency stop. It is high while the stop's loop is closed.
const E_STOP: &str = "PC8";
/// Longest start of the image, in emulated time.
const STARTS: Duration = Duration::from_secs(5);

/// The files that an emulated NUCLEO needs.
pub(in crate::cli) struct Files {
    tool: PathBuf,
    image: PathBuf,
}

impl Files {
    /// Finds the emulator and the image.
    ///
    /// # Errors
    /// If one is missing. The error names the command that builds it.
    pub(in crate::cli) fn find() -> anyhow::Result<Self> {
        let program = std::env::current_exe().unwrap_or_default();
        let target = program.ancestors().nth(2).unwrap_or(Path::new("target"));
        let find = |(variable, built): (&str, &str)| {
            let path = std::env::var_os(variable).map_or_else(|| target.join(built), PathBuf::from);
            ensure!(
                path.is_file(),
                "{}: not there. `cargo xtask emulate` builds it; {variable} names another one",
                path.display()
            );
            Ok(path)
        };
        Ok(Self { tool: find(TOOL)?, image: find(IMAGE)? })
    }
}

/// Number of bursts that the board has sent to servos, and number of bursts that servos have sent.
type Bursts = Rc<Cell<[usize; 2]>>;

/// An emulated board. Bursts on its bus are counted, but not stored.
struct Counted<W> {
    board: EmulatedBoard<W>,
    bursts: Bursts,
}

impl<W: LineDevice> BoardLine for Counted<W> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.board.send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let count = self.board.receive(into, wait)?;
        let [mut own, mut theirs] = self.bursts.get();
        for burst in self.board.bus.drain(..) {
            *if burst.is_own { &mut own } else { &mut theirs } += 1;
        }
        self.board.other.clear();
        self.bursts.set([own, theirs]);
        Ok(count)
    }

    fn now(&self) -> Duration {
        self.board.now()
    }
}

/// Switches a blank board on, uploads the rig over its host link, and calls `host` with the board and the numbers of
/// bursts. The board's time is that of the emulated chip.
pub(in crate::cli) fn with_board<T>(
    Files { tool, image }: &Files,
    rig: &LoadedRig,
    parts: &RigParts,
    host: impl FnOnce(&mut Board<Box<dyn BoardLine + '_>>, &Bursts) -> anyhow::Result<T>,
) -> anyhow::Result<T> {
    let [line] = parts.lines.as_slice() else {
        bail!(
            "--target nucleo: the rig has {} buses, the board one serial line",
            parts.lines.len()
        );
    };
    ensure!(
        !line.is_of_pulses(),
        "--target nucleo: servos driven by pulses are not emulated there"
    );
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
    let plant = parts.plant(&rig.description, &rig.mechanism)?;
    let servos = parts.simulated(&mut memories, plant)?.pop().context("it has one line")?;
    let Line { baud, .. } = *line;
    let mut machine = Machine::start(tool, image, None)?;
    machine.pin(E_STOP, true)?;
    let board = EmulatedBoard::new(BoardOnServos::new(machine, servos, baud, 0));
    let bursts = Bursts::default();
    let line: Box<dyn BoardLine + '_> = Box::new(Counted { board, bursts: Rc::clone(&bursts) });
    let mut board = Board::connect(line, nonce(), STARTS)?;
    let stored = parts.board_rig().map_err(anyhow::Error::msg)?;
    put(&mut board, &item(Kind::Rig, RIG_SCHEMA, &stored, 0, "sinew play")?, &stored)?;
    host(&mut board, &bursts)
}

/// Plays a show as on any board, and prints the bursts and the durations of ticks.
pub(super) fn perform(
    files: &Files,
    rig: &LoadedRig,
    parts: &RigParts,
    bytes: &[u8],
    timing: Timing,
) -> anyhow::Result<ExitCode> {
    with_board(files, rig, parts, |board, bursts| {
        let name = format!("nucleo-{}", std::process::id());
        let ended = perform_on((board, &name), (rig, parts), bytes, timing, None)?;
        let (time_s, [own, theirs]) = (board.now().as_secs_f64(), bursts.get());
        print(&format!(
            "the emulated NUCLEO-F446RE ran {time_s:.2} s of its time: {own} bursts to servos, {theirs} of theirs\n"
        ))?;
        if let Some(summary) = board.log.summary {
            note(format_args!(
                "ticks: {} us on average, {} at most, {} too late",
                summary.tick_us, summary.tick_max_us, summary.overruns
            ));
        }
        Ok(ended)
    })
}
