//! A show of 20 servos, as any machine plays it: the host and a board must decode it to the same bits.

use sinew_show::{Pace, Player, Position, Show, ShowError};

/// Joints of the show, all revolute.
pub const JOINTS: usize = 20;

/// The show: `build/performer.rs` has its motion.
pub static BYTES: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/performer.show"));

/// 500 ticks a second.
pub const TICK_S: f32 = 0.002;

/// All of the show but its last pose.
pub const TICKS: u16 = 5_999;

/// As many jumps are tried.
pub const JUMPS: u16 = 64;

/// Where a show of this pace is asked for from tick to tick.
pub fn next(pace: Pace, run: usize) -> Position {
    pace.position(u32::try_from(run).unwrap_or(u32::MAX))
}

/// Where a show of this pace is asked for from anywhere to anywhere.
pub fn jump(pace: Pace, run: usize) -> Position {
    // A prime: it comes by all parts of the show.
    next(pace, (run * 2503) % usize::from(TICKS))
}

/// Hashes (FNV-1a, word by word) of the show, and of all bits that it is decoded to, tick after tick and jump after
/// jump.
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

/// The hash of nothing.
const NOTHING: u64 = 0xcbf2_9ce4_8422_2325;

fn add(hash: u64, word: u32) -> u64 {
    (hash ^ u64::from(word)).wrapping_mul(0x100_0000_01b3)
}
