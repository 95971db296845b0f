//! A stand-in for servos: a rig that performs the show a little late.
//!
//! It needs no physics, so the same run can be made on a host and on a board, and all torques compared bit
//! by bit.

use sinew_core::control::{ControlLaw, Gains, GainsError, Limited};
use sinew_core::projection::BodyWeights;
use sinew_core::state_error::{Aims, Compensation, Method, References};
use sinew_core::{
    Controller, ControllerError, StateInputError, Transform, Tree, Workspace, Wrench,
};
use sinew_firmware::app::App;
use sinew_firmware::recommended::{Recommended, RecommendedError};
use sinew_firmware::show::{Show, ShowError};

/// How many frames the stand-in is late: enough for errors of a few degrees.
pub const LAG_FRAMES: usize = 3;

/// How late the stand-in's torques count as, in the setting for real rigs.
pub const DELAY_TICKS: usize = 0;

/// The paper's gain, kp in 1/s².
pub const KP: f32 = 200.0;

/// The three methods of the paper, and the setting for real rigs, by the names that all reports use.
pub const METHODS: [&str; 4] = ["local", "world", "linear_compensation", "recommended"];

/// The method of that name, for a rig: one of [`METHODS`], `egocentric` or `resolved_acceleration`.
pub fn method<const N: usize>(name: &str, tree: &Tree<N>) -> Option<Method<N>> {
    match name {
        "local" => Some(Method::Local),
        "world" | "recommended" => Some(Method::World),
        "egocentric" => Some(Method::Accumulated(References::egocentric(tree))),
        "linear_compensation" => Some(Method::LinearCompensation {
            aims: Aims::heaviest_child(tree),
            settings: Compensation::default(),
        }),
        "resolved_acceleration" => {
            Some(Method::ResolvedAcceleration { weights: BodyWeights::rotations(tree) })
        }
        _ => None,
    }
}

/// An application at a show's first frame, with the named [`method`] and the paper's gains. `resolved_acceleration`
/// needs [`Workspace::resolving`].
///
/// # Errors
/// [`ReplayError`] if the show's rig is not usable or there is no such method.
pub fn app<'a, const N: usize, const R: usize>(
    show: Show<'a>,
    name: &str,
    workspace: Workspace<N, R>,
) -> Result<App<'a, N, R>, ReplayError> {
    let tree = show.tree::<N>().map_err(ReplayError::Show)?;
    let method = method(name, &tree).ok_or(ReplayError::UnknownMethod)?;
    let mut gains = Gains::critically_damped(KP).map_err(ReplayError::Gains)?;
    if name == "recommended" {
        gains = gains.implicit(show.dt_s()).map_err(ReplayError::Gains)?;
    }
    let controller = Controller::new(tree, gains, method)
        .and_then(|controller| controller.with_law(ControlLaw::InverseDynamics))
        .map_err(ReplayError::Controller)?;
    let app = App::with_workspace(show, controller, workspace);
    if name == "recommended" {
        let setting = Recommended::new(&show, app.controller().tree(), DELAY_TICKS);
        return Ok(app.with(setting.map_err(ReplayError::Recommended)?));
    }
    Ok(app)
}

/// A run of one method over a show.
///
/// ```
/// use sinew_firmware::show::Show;
/// use sinew_parity::replay::{Replay, ReplayError, TorqueHash};
/// # let flash = {
/// #     use sinew_core::{Body, Inertia, JointKind, Transform};
/// #     let (parent, joint, placement) = (None, JointKind::Spherical, Transform::IDENTITY);
/// #     let head = Body { parent, joint, placement, inertia: Inertia::default() };
/// #     let (mut flash, frames) = (Vec::new(), [[Transform::IDENTITY]; 3]);
/// #     let sink = |piece: &[u8]| Ok::<(), std::fmt::Error>(flash.extend_from_slice(piece));
/// #     sinew_firmware::show::write(&[head], 0.01, frames.iter().map(|f| &f[..]), sink)?;
/// #     flash
/// # };
/// let show = Show::parse(&flash)?;
/// let mut run = Replay::<1>::new(show, "world")?;
/// let mut hash = TorqueHash::default();
/// for tick in 0..show.frame_count() {
///     run.observe(tick)?;
///     hash.update(run.control());
/// }
/// // Every machine must come to the same number.
/// println!("{:016x}", hash.value());
/// assert_eq!(Replay::<1>::new(show, "other").err(), Some(ReplayError::UnknownMethod));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Replay<'a, const N: usize> {
    app: App<'a, N>,
    late: [Transform; N],
}

impl<'a, const N: usize> Replay<'a, N> {
    /// A run from the show's first frame, see [`app`].
    ///
    /// # Errors
    /// [`ReplayError`] if the show's rig is not usable or there is no such method.
    pub fn new(show: Show<'a>, name: &str) -> Result<Self, ReplayError> {
        Ok(Self { app: app(show, name, Workspace::new())?, late: [Transform::IDENTITY; N] })
    }

    /// Reads the sensors of the stand-in at a tick: the show's pose of [`LAG_FRAMES`] ago, with the rig's own
    /// link lengths.
    ///
    /// # Errors
    /// Never for a show that was parsed; [`StateInputError`] as [`App::observe`].
    pub fn observe(&mut self, tick: usize) -> Result<(), StateInputError> {
        self.app.show().frame(tick.saturating_sub(LAG_FRAMES), &mut self.late);
        let bodies = self.app.controller().tree().bodies();
        for (pose, body) in self.late.iter_mut().zip(bodies).skip(1) {
            pose.translation_m = body.placement.translation_m;
        }
        let count = bodies.len();
        self.app.observe(tick, self.late.get(..count).unwrap_or_default())
    }

    /// The torques for what was observed last.
    pub fn control(&mut self) -> &[Limited<Wrench>] {
        self.app.control()
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
    /// There is no method of that name, see [`METHODS`].
    UnknownMethod,
    /// The gains cannot be.
    Gains(GainsError),
    /// The controller cannot be made.
    Controller(ControllerError),
    /// The setting for real rigs cannot be had.
    Recommended(RecommendedError),
}

impl core::fmt::Display for ReplayError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Show(error) => error.fmt(f),
            Self::UnknownMethod => {
                write!(
                    f,
                    "unknown method; known are {METHODS:?}, egocentric, resolved_acceleration"
                )
            }
            Self::Gains(error) => error.fmt(f),
            Self::Controller(error) => error.fmt(f),
            Self::Recommended(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for ReplayError {}
