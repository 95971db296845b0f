//! A stand-in for servos: a rig that performs the show with a small delay.
//!
//! It needs no physics, so a host and a board can make the same run, and all torques can be compared bit by bit. Rig
//! and show are in the format of boards: the rig's compact form ([`sinew_rig::board`]), and a show of its coordinates
//! ([`sinew_show`]).

use sinew_core::control::Limited;
use sinew_core::tracker::{
    Frame, FrameSource as _, Measured, MethodName, Settings, StepError, Tick, Timing, Tracker,
    TrackerError,
};
use sinew_core::{Tree, Wrench};
use sinew_rig::board::{BoardRig, BoardRigError};
use sinew_show::{Show, ShowError, ShowFrames};

/// Delay of the stand-in in frames: enough for errors of a few degrees.
pub const LAG_FRAMES: i32 = 3;

/// The three methods of the paper, and the setting for real rigs.
pub const METHODS: [MethodName; 4] =
    [MethodName::Local, MethodName::World, MethodName::LinearCompensation, MethodName::Recommended];

/// Number of servos: the stand-in alone moves the rig.
const SERVOS: usize = 0;

/// Returns the settings of a run with a method: the paper's gains.
pub fn settings(method: MethodName) -> Settings {
    Settings { method, ..Settings::default() }
}

/// Reads a rig of at most `BODIES` bodies and `DOFS` dofs, without servos, from its compact form.
///
/// # Errors
/// [`BoardRigError`] if the bytes are not such a rig.
pub fn tree<const BODIES: usize, const DOFS: usize>(
    rig: &[u8],
) -> Result<Tree<BODIES>, BoardRigError> {
    BoardRig::<BODIES, DOFS, SERVOS>::decode(rig).map(|rig| rig.tree().clone())
}

/// A rig that performs a show, with one tick for each of its samples. The tracker assumes no latency of torques.
///
/// ```
/// use sinew_bit_parity::replay::{Replay, TorqueHash, ticks};
/// use sinew_core::tracker::MethodName;
/// use sinew_core::{Body, Inertia, JointKind, Transform, Tree};
/// use sinew_show::write::{Motion, Settings, write};
/// use sinew_show::{Joint, Rate, Show};
///
/// let (parent, joint, placement) = (None, JointKind::Spherical, Transform::IDENTITY);
/// let head = Body { parent, joint, placement, inertia: Inertia::default(), rotor_inertia: 0.0 };
/// let motion = Motion {
///     joints: &[Joint::Spherical],
///     q: &[0.0, 0.0, 0.0, 1.0].repeat(30),
///     rate: Rate { samples: 100, seconds: 1 },
///     is_loop: false,
///     rig: 0,
///     cues: &[],
///     time_code: None,
///     course: &[],
/// };
/// let written = write(&motion, &Settings::default())?;
/// let (tree, show) = (Tree::<1>::from_bodies(&[head])?, Show::open(&written.bytes)?);
/// assert_eq!(ticks(&show), 30);
/// let mut run = Replay::<1, 4>::new(&tree, show, MethodName::World)?;
/// let mut hash = TorqueHash::default();
/// for tick in 0..ticks(&show) {
///     run.sense(tick);
///     hash.update(run.step(tick)?.torques());
/// }
/// // Every machine must come to the same number.
/// println!("{:016x}", hash.value());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Replay<'a, const BODIES: usize, const COORDS: usize> {
    tracker: Tracker<BODIES>,
    frames: ShowFrames<'a, COORDS>,
    /// A second player of the show, for the sensors: a player is fast from tick to tick, but slow to jump back and
    /// forth.
    late: ShowFrames<'a, COORDS>,
    measured: [f32; COORDS],
    coordinates: usize,
}

impl<'a, const BODIES: usize, const COORDS: usize> Replay<'a, BODIES, COORDS> {
    /// Creates a run from the show's first frame, where the stand-in is at rest. The show has at most `COORDS`
    /// coordinates.
    ///
    /// # Errors
    /// [`ReplayError`] if the show is damaged or belongs to another rig, or the method does not fit the rig.
    pub fn new(
        tree: &Tree<BODIES>,
        show: Show<'a>,
        method: MethodName,
    ) -> Result<Self, ReplayError> {
        let kinds = tree.bodies().iter().map(|body| body.joint);
        show.check_joints(kinds).map_err(ReplayError::Show)?;
        let dt_s = show.rate().hz().recip();
        let timing = Timing { dt_s, latency_ticks: 0 };
        let tracker =
            Tracker::new(tree.clone(), &settings(method), timing).map_err(ReplayError::Tracker)?;
        let frames = ShowFrames::new(show, dt_s).map_err(ReplayError::Show)?;
        let (late, measured, coordinates) = (frames.clone(), [0.0; COORDS], show.channel_count());
        let mut run = Self { tracker, frames, late, measured, coordinates };
        run.sense(0);
        let measured =
            Measured::Positions { q: run.measured.get(..coordinates).unwrap_or_default() };
        run.tracker.begin(&mut run.frames, 0, measured).map_err(ReplayError::Step)?;
        Ok(run)
    }

    /// Sets the sensors of the stand-in at a tick: the positions of the show [`LAG_FRAMES`] ago.
    pub fn sense(&mut self, tick: u32) {
        let tick = i32::try_from(tick).unwrap_or(i32::MAX);
        if let Frame::Coordinates { q, .. } =
            self.late.frame(tick.saturating_sub(LAG_FRAMES).max(0))
        {
            for (measured, q) in self.measured.iter_mut().zip(q) {
                *measured = *q;
            }
        }
    }

    /// Runs a tick with the last [sensed](Self::sense) positions; the frame has the same number as the tick. After
    /// the end of the show, its last frame is held.
    ///
    /// # Errors
    /// [`StepError`] if the show exceeds the bounds of a tracker, as in [`Tracker::step`].
    pub fn step(&mut self, tick: u32) -> Result<Tick<'_, BODIES>, StepError> {
        let q = self.measured.get(..self.coordinates).unwrap_or_default();
        let tick = i32::try_from(tick).unwrap_or(i32::MAX);
        self.tracker.step(&mut self.frames, tick, Measured::Positions { q })
    }
}

/// Returns the number of ticks of a show: one for each sample.
pub fn ticks(show: &Show<'_>) -> u32 {
    show.length().saturating_add(1)
}

/// Returns the hash of the torques of a method over the first ticks of a show.
///
/// # Errors
/// [`ReplayError`] if the run is not possible.
pub fn hash<const BODIES: usize, const COORDS: usize>(
    tree: &Tree<BODIES>,
    show: Show<'_>,
    method: MethodName,
    ticks: u32,
) -> Result<u64, ReplayError> {
    let mut replay = Replay::<BODIES, COORDS>::new(tree, show, method)?;
    let mut hash = TorqueHash::default();
    for tick in 0..ticks {
        replay.sense(tick);
        hash.update(replay.step(tick).map_err(ReplayError::Step)?.torques());
    }
    Ok(hash.value())
}

/// FNV-1a, 64 bit, over the bits of all torques in order: moment then force, x y z, body by body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TorqueHash(u64);

impl Default for TorqueHash {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl TorqueHash {
    /// Adds the torques of one tick.
    pub fn update(&mut self, torques: &[Limited<Wrench>]) {
        for component in torques.iter().flat_map(|torque| components(&torque.value)) {
            for byte in component.to_bits().to_le_bytes() {
                self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
            }
        }
    }

    /// Returns the hash of the torques so far.
    pub fn value(self) -> u64 {
        self.0
    }
}

/// Returns the six numbers of a wrench: moment in N m, then force in N.
pub fn components(wrench: &Wrench) -> [f32; 6] {
    let (m, f) = (wrench.moment_nm, wrench.force_n);
    [m.x, m.y, m.z, f.x, f.y, f.z]
}

/// Error of a run that is not possible.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ReplayError {
    /// The show is damaged, or belongs to another rig.
    Show(ShowError),
    /// The tracker cannot be created.
    Tracker(TrackerError),
    /// A tick was refused.
    Step(StepError),
}

impl core::fmt::Display for ReplayError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Show(error) => error.fmt(f),
            Self::Tracker(error) => error.fmt(f),
            Self::Step(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for ReplayError {}
