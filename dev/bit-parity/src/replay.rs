//! A stand-in for servos: a rig that performs the show a little late.
//!
//! It needs no physics, so the same run can be made on a host and on a board, and all torques compared bit
//! by bit.

use sinew_core::control::Limited;
use sinew_core::tracker::{MethodName, Settings, StepError, Tick, Timing, Tracker, TrackerError};
use sinew_core::{Transform, Wrench};
use sinew_firmware::frames::ShowFrames;
use sinew_firmware::show::{Show, ShowError};

/// How many frames the stand-in is late: enough for errors of a few degrees.
pub const LAG_FRAMES: usize = 3;

/// The three methods of the paper, and the setting for real rigs.
pub const METHODS: [MethodName; 4] =
    [MethodName::Local, MethodName::World, MethodName::LinearCompensation, MethodName::Recommended];

/// The settings of a run with a method: the paper's gains.
pub fn settings(method: MethodName) -> Settings {
    Settings { method, ..Settings::default() }
}

/// A run of one method over a show, whose torques count as not late at all.
///
/// ```
/// use sinew_core::tracker::MethodName;
/// use sinew_firmware::show::Show;
/// use sinew_bit_parity::replay::{Replay, TorqueHash};
/// # let flash = {
/// #     use sinew_core::{Body, Inertia, JointKind, Transform};
/// #     let (parent, joint, placement) = (None, JointKind::Spherical, Transform::IDENTITY);
/// #     let head = Body { parent, joint, placement, inertia: Inertia::default(), rotor_inertia: 0.0 };
/// #     let (mut flash, frames) = (Vec::new(), [[Transform::IDENTITY]; 3]);
/// #     let sink = |piece: &[u8]| Ok::<(), std::fmt::Error>(flash.extend_from_slice(piece));
/// #     sinew_firmware::show::write(&[head], 0.01, frames.iter().map(|f| &f[..]), sink)?;
/// #     flash
/// # };
/// let show = Show::parse(&flash)?;
/// let mut run = Replay::<1>::new(show, MethodName::World)?;
/// let mut hash = TorqueHash::default();
/// for tick in 0..3 {
///     hash.update(run.step(tick)?.torques());
/// }
/// // Every machine must come to the same number.
/// println!("{:016x}", hash.value());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Replay<'a, const N: usize> {
    tracker: Tracker<N>,
    frames: ShowFrames<'a, N>,
    late: [Transform; N],
}

impl<'a, const N: usize> Replay<'a, N> {
    /// A run from the show's first frame, where the stand-in is at rest.
    ///
    /// # Errors
    /// [`ReplayError`] if the show's rig is not usable or the method does not go with it.
    pub fn new(show: Show<'a>, method: MethodName) -> Result<Self, ReplayError> {
        let tree = show.tree::<N>().map_err(ReplayError::Show)?;
        let timing = Timing { dt_s: show.dt_s(), latency_ticks: 0 };
        let tracker =
            Tracker::new(tree, &settings(method), timing).map_err(ReplayError::Tracker)?;
        let frames = ShowFrames::new(show);
        let mut run = Self { tracker, frames, late: [Transform::IDENTITY; N] };
        run.read_sensors(0);
        let count = run.tracker.controller().tree().len();
        let measured = run.late.get(..count).unwrap_or_default();
        run.tracker.begin(&mut run.frames, 0, measured).map_err(ReplayError::Begin)?;
        Ok(run)
    }

    /// One tick; its frame is that of the same number. After the show's end its last frame is held.
    ///
    /// # Errors
    /// Never for a show that was parsed; [`StepError`] as [`Tracker::step`].
    pub fn step(&mut self, tick: u32) -> Result<Tick<'_, N>, StepError> {
        self.read_sensors(usize::try_from(tick).unwrap_or(usize::MAX));
        let count = self.tracker.controller().tree().len();
        let measured = self.late.get(..count).unwrap_or_default();
        self.tracker.step(&mut self.frames, i32::try_from(tick).unwrap_or(i32::MAX), measured)
    }

    /// The sensors of the stand-in at a tick: the show's pose of [`LAG_FRAMES`] ago, with the rig's own link lengths.
    fn read_sensors(&mut self, tick: usize) {
        self.frames.show().frame(tick.saturating_sub(LAG_FRAMES), &mut self.late);
        let bodies = self.tracker.controller().tree().bodies();
        for (pose, body) in self.late.iter_mut().zip(bodies).skip(1) {
            pose.translation_m = body.placement.translation_m;
        }
    }
}

/// FNV-1a, 64 bit, over the bits of all torques in order: moment then force, x y z, body by body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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

    /// The hash so far.
    pub fn value(self) -> u64 {
        self.0
    }
}

/// The six numbers of a wrench: moment in N m, then force in N.
pub fn components(wrench: &Wrench) -> [f32; 6] {
    let (m, f) = (wrench.moment_nm, wrench.force_n);
    [m.x, m.y, m.z, f.x, f.y, f.z]
}

/// Why a run cannot begin.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ReplayError {
    /// The show's rig is not usable.
    Show(ShowError),
    /// There is no such tracker.
    Tracker(TrackerError),
    /// The show's first frames were refused.
    Begin(StepError),
}

impl core::fmt::Display for ReplayError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Show(error) => error.fmt(f),
            Self::Tracker(error) => error.fmt(f),
            Self::Begin(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for ReplayError {}
