//! A show of 20 servos that any machine can play: the host and a board must decode it to the same bits.

use sinew_show::{Pace, Player, Position, Show, ShowError};

/// Number of joints of the show, all revolute.
pub const JOINTS: usize = 20;

/// Bytes of the show. Its motion is in `build/performer.rs`.
pub static BYTES: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/performer.show"));

/// Length of a tick, s: 500 Hz.
pub const TICK_S: f32 = 0.002;

/// Number of ticks: the whole show except its last pose.
pub const TICKS: u16 = 5_999;

/// Number of jumps.
pub const JUMPS: u16 = 64;

/// Returns the position of a tick in a show of this pace.
pub fn next(pace: Pace, run: usize) -> Position {
    pace.position(u32::try_from(run).unwrap_or(u32::MAX))
}

/// Returns the position of a jump in a show of this pace.
pub fn jump(pace: Pace, run: usize) -> Position {
    // A prime, so that jumps visit all parts of the show.
    next(pace, (run * 2503) % usize::from(TICKS))
}

/// Returns hashes (FNV-1a, word by word) of the show, and of all decoded bits, tick by tick and jump by jump.
///
/// # Errors
/// If the show is damaged.
pub fn hashes() -> Result<[(&'static str, u64); 2], ShowError> {
    let bytes = BYTES.iter().fold(NOTHING, |hash, byte| add(hash, u32::from(*byte)));
    let mut frames = NOTHING;
    let show = Show::open(BYTES)?;
    let mut player = Player::<JOINTS>::new(show)?;
    let pace = show.pace(TICK_S);
    let along = (0..=TICKS).map(|run| next(pace, run.into()));
    let across = (0..=JUMPS).map(|run| jump(pace, run.into()));
    let [mut q, mut qd, mut qdd] = [[0.0; JOINTS]; 3];
    for position in along.chain(across) {
        player.state_at(position, &mut q, &mut qd, &mut qdd)?;
        frames = [q, qd, qdd].iter().flatten().fold(frames, |hash, x| add(hash, x.to_bits()));
    }
    Ok([("show_bytes", bytes), ("show_frames", frames)])
}

/// The hash of no data.
const NOTHING: u64 = 0xcbf2_9ce4_8422_2325;

fn add(hash: u64, word: u32) -> u64 {
    (hash ^ u64::from(word)).wrapping_mul(0x100_0000_01b3)
}
