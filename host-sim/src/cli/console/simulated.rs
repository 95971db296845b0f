//! A simulated board in this program, in real time.

use std::io;
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::Duration;

use sinew_board_client::{Board, nonce};
use sinew_performance::play::{BoardEnd, Chip, HostEnd, Memory, RigParts, SimulatedBoard, pipe};
use sinew_performance::rig::LoadedRig;
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::fault::Fault;
use sinew_servo_sim::plant::RigPlant;

/// Stack size. The loop's arrays are sized for the largest board.
const STACK_BYTES: usize = 64 << 20;
/// Maximum time until a board has started.
const PATIENCE: Duration = Duration::from_secs(10);

/// Runs `host` with a simulated board that has this rig. The board ends when `host` ends.
pub(super) fn with_board<T>(
    rig: &LoadedRig,
    parts: &RigParts,
    faults: Vec<Fault>,
    host: impl FnOnce(&mut Board<HostEnd>) -> anyhow::Result<T>,
) -> anyhow::Result<T> {
    thread::scope(|scope| {
        let (line, end) = pipe();
        let builder = thread::Builder::new().name("board".to_owned()).stack_size(STACK_BYTES);
        let simulated = builder.spawn_scoped(scope, move || simulate(rig, parts, faults, end))?;
        let served = Board::connect(line, nonce(), PATIENCE)
            .map_err(anyhow::Error::from)
            .and_then(|mut board| host(&mut board));
        // The line is gone, so the board ends. Its error is the reason if it has never begun.
        simulated.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        served
    })
}

fn simulate(
    rig: &LoadedRig,
    parts: &RigParts,
    faults: Vec<Fault>,
    end: BoardEnd,
) -> anyhow::Result<()> {
    let chip = Chip::blank();
    SimulatedBoard::<RigPlant>::store_rig(parts, &chip)?;
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
    let plant = parts.plant(&rig.description, &rig.mechanism)?;
    let mut board = SimulatedBoard::new(parts, &mut memories, plant, chip)?;
    board.set_faults(faults);
    match board.serve(end, &AtomicBool::new(false), |_| {}) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        served => Ok(served?),
    }
}
