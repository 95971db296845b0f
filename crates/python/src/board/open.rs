//! Thread of a session: opens or simulates a board, and executes orders.

use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread;
use std::time::Duration;

use anyhow::{Context as _, ensure};
use sinew_board_client::console::name_of_port;
use sinew_board_client::{Board, Line, nonce, port};
use sinew_console::{Hosted, Owner, Scene, Source};
use sinew_performance::play::{
    BoardEnd, Chip, Memory, Options, RigParts, ServoChoice, SimulatedBoard, pipe, put_servos,
};
use sinew_performance::rig::LoadedRig;
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::plant::RigPlant;

use super::inbox::Inbox;
use super::order::Order;
use super::remote::Remote;
use super::session::Session;

/// Stack of the simulated board, bytes.
const STACK_BYTES: usize = 256 << 20;
/// Longest wait until a simulated board answers.
const PATIENCE: Duration = Duration::from_secs(10);
/// Longest wait for the board between two checks for orders.
const TURN: Duration = Duration::from_millis(4);

/// Number of simulated boards of this process.
static SIMULATED: AtomicU32 = AtomicU32::new(1);

/// The place of a board.
pub(super) enum Target {
    Simulated,
    Port(PathBuf),
    /// The name of a running console.
    Console(String),
}

/// Opens a board, or simulates one, and executes orders until the session is closed. `opened` is called
/// when the board answers.
pub(super) fn serve(
    mut rig: LoadedRig,
    target: Target,
    servos: &[ServoChoice],
    inbox: Inbox,
    opened: impl FnOnce(),
) -> anyhow::Result<()> {
    let name = rig.description.name.clone();
    if put_servos(&mut rig.description, servos).with_context(|| name.clone())? > 0 {
        rig.mechanism = rig.description.mechanism()?;
    }
    let options = Options { is_of_board: true, ..Options::default() };
    let parts =
        RigParts::new(&rig.description, &rig.mechanism, options).with_context(|| name.clone())?;
    let path = match target {
        Target::Port(path) => path,
        Target::Console(name) => {
            return Remote::open(&name, (&rig.mechanism, parts.rig_crc()), inbox)?.serve(opened);
        }
        Target::Simulated => return serve_simulated(&rig, &parts, inbox, opened),
    };
    let mut board = port::open(&path, &|| ())?;
    check_rig(board.about().rig, parts.rig_crc())?;
    obey((&mut board, &name_of_port(&path)), (&rig, &parts), inbox, opened)
}

/// Fails if a board has another rig.
pub(super) fn check_rig(here: u32, own: u32) -> anyhow::Result<()> {
    ensure!(
        here == own,
        "the board has rig {here:08x}, the given one is {own:08x}: `sinew board upload rig FILE --port PORT` uploads it"
    );
    Ok(())
}

/// Simulates a board, and executes orders.
fn serve_simulated(
    rig: &LoadedRig,
    parts: &RigParts,
    inbox: Inbox,
    opened: impl FnOnce(),
) -> anyhow::Result<()> {
    thread::scope(|scope| {
        let (line, end) = pipe();
        let builder = thread::Builder::new().name("simulated".to_owned());
        let simulate = || simulate(rig, parts, end);
        let simulated = builder.stack_size(STACK_BYTES).spawn_scoped(scope, simulate)?;
        let served = Board::connect(line, nonce(), PATIENCE).map_err(Into::into);
        let served = served.and_then(|mut board| {
            let number = SIMULATED.fetch_add(1, Ordering::Relaxed);
            let name = format!("simulated-{}-{number}", std::process::id());
            obey((&mut board, &name), (rig, parts), inbox, opened)
        });
        // The line is closed, so the simulated board ends. If the board failed to start, its error is returned.
        simulated.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        served
    })
}

fn simulate(rig: &LoadedRig, parts: &RigParts, end: BoardEnd) -> anyhow::Result<()> {
    let chip = Chip::blank();
    SimulatedBoard::<RigPlant>::store_rig(parts, &chip)?;
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
    let plant = parts.plant(&rig.description, &rig.mechanism)?;
    let mut board = SimulatedBoard::new(parts, &mut memories, plant, chip)?;
    match board.serve(end, &AtomicBool::new(false), |_| {}) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        served => Ok(served?),
    }
}

/// Executes orders until the session is closed, or Python has dropped the board: then the rig is stopped. Other
/// terminals know the board by `name`.
fn obey<L: Line>(
    (board, name): (&mut Board<L>, &str),
    (rig, parts): (&LoadedRig, &RigParts),
    inbox: Inbox,
    opened: impl FnOnce(),
) -> anyhow::Result<()> {
    let scene = Scene::new(&rig.description.name, &rig.mechanism, parts, Source::Board);
    let hosted = Hosted::open(board, &scene, Owner::Python, Some(name))
        .context("the socket for other commands")?;
    let mut session = Session::new(hosted, &rig.mechanism, inbox)?;
    opened();
    loop {
        if let Some(asked) = session.inbox.next() {
            let is_close = matches!(asked.order, Order::Close);
            // Nobody waits if Python was interrupted.
            let _ = asked.reply.send(session.execute(asked.order).map_err(text));
            if is_close {
                return Ok(());
            }
        } else if session.inbox.is_dropped() {
            return session.stop();
        } else {
            session.turn(TURN)?;
        }
    }
}

#[expect(clippy::needless_pass_by_value, reason = "converts an error at its end")]
pub(super) fn text(error: anyhow::Error) -> String {
    format!("{error:#}")
}
