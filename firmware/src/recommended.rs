//! The setting for real rigs: manifold projection on targets aligned with the rig's motion, and an observer that
//! filters the sensors, learns what the model has wrong, and looks ahead over a known delay.

use sinew_core::control::Limited;
use sinew_core::observer::{Observer, ObserverError, ObserverSettings};
use sinew_core::projection::{
    BodyWeight, JointRange, ManifoldProjection, ProjectionError, ProjectionWorkspace,
};
use sinew_core::trajectory::aligned_targets;
use sinew_core::{JointStates, JointTargets, StateInputError, Transform, Tree, Twist, Wrench};

use crate::show::Show;

/// What a turn counts against a distance in the projection: 1 rad as much as half a metre.
pub const ROTATION_M: f32 = 0.5;

/// Bandwidth of the observer, where a tick is not longer than one over it.
pub const BANDWIDTH_RAD_S: f32 = 100.0;

/// The longest delay that there is room for, in ticks.
pub const DELAY_MOST: usize = 7;

/// The longest time from a measurement to the end of the tick that its torque acts in, in s: beyond, no rig stood in
/// simulation whose masses were off by 15 % and whose sensors had 12 bits.
pub const LATE_MOST_S: f32 = 0.010;

/// What the setting adds to a World controller, and remembers from tick to tick.
///
/// ```
/// use sinew_core::{Controller, Transform, control::Gains, state_error::Method};
/// use sinew_firmware::recommended::{Recommended, RecommendedError};
/// use sinew_firmware::{app::App, show::Show};
/// # let flash = {
/// #     use sinew_core::{Body, Inertia, JointKind};
/// #     let (parent, joint, placement) = (None, JointKind::Spherical, Transform::IDENTITY);
/// #     let head = Body { parent, joint, placement, inertia: Inertia::default() };
/// #     let (mut flash, frames) = (Vec::new(), [[Transform::IDENTITY]; 3]);
/// #     let sink = |piece: &[u8]| Ok::<(), std::fmt::Error>(flash.extend_from_slice(piece));
/// #     sinew_firmware::show::write(&[head], 0.002, frames.iter().map(|f| &f[..]), sink)?;
/// #     flash
/// # };
/// let show = Show::parse(&flash)?;
/// let tree = show.tree::<1>()?;
/// // 500 ticks a second; a torque acts two ticks late.
/// let setting = Recommended::new(&show, &tree, 2)?;
/// let gains = Gains::critically_damped(200.0)?.implicit(show.dt_s())?;
/// let mut app = App::new(show, Controller::new(tree, gains, Method::World)?).with(setting);
/// app.observe(0, &[Transform::IDENTITY])?;
/// assert_eq!(app.control().len(), 1);
/// // Nine ticks late no rig would stand.
/// let too_late = Recommended::new(&show, app.controller().tree(), 9);
/// assert_eq!(too_late.err(), Some(RecommendedError::TooLate));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Recommended<const N: usize> {
    projection: ManifoldProjection<N>,
    workspace: ProjectionWorkspace<N>,
    /// The rig's own poses in the frames before, at and after the last tick's.
    window: [[Transform; N]; 3],
    /// The frame of the show that is the last of the window.
    newest: usize,
    delay_ticks: usize,
    observer: Observer<N, { DELAY_MOST + 1 }>,
}

impl<const N: usize> Recommended<N> {
    /// The setting for the rig of a show, whose torques act `delay_ticks` after the measurement that they are made from,
    /// beyond the tick itself. It finds the first pose here, before the loop: that takes as long as some twenty ticks.
    ///
    /// # Errors
    /// [`RecommendedError`] if the delay is longer than [`DELAY_MOST`], or with the tick longer than [`LATE_MOST_S`]: 100
    /// ticks a second without a delay, 500 with up to 4 ticks.
    pub fn new(
        show: &Show<'_>,
        tree: &Tree<N>,
        delay_ticks: usize,
    ) -> Result<Self, RecommendedError> {
        let weights = [BodyWeight::new(1.0, ROTATION_M); N];
        let weights = weights.get(..tree.len()).unwrap_or_default();
        Self::with_weights(show, tree, weights, delay_ticks)
    }

    /// The same with other weights in the projection, such as
    /// [`BodyWeights::by_importance`](sinew_core::projection::BodyWeights::by_importance).
    ///
    /// # Errors
    /// [`RecommendedError`] as [`Self::new`], or if the weights are not the tree's.
    pub fn with_weights(
        show: &Show<'_>,
        tree: &Tree<N>,
        weights: &[BodyWeight],
        delay_ticks: usize,
    ) -> Result<Self, RecommendedError> {
        let dt_s = show.dt_s();
        let ticks = u16::try_from(delay_ticks).unwrap_or(u16::MAX);
        // A thousandth takes up the rounding of the show's period.
        if (f32::from(ticks) + 1.0) * dt_s > LATE_MOST_S * 1.001 {
            return Err(RecommendedError::TooLate);
        }
        let settings = ObserverSettings::extended_state(BANDWIDTH_RAD_S.min(1.0 / dt_s), dt_s)?;
        let mut setting = Self {
            projection: ManifoldProjection::new(tree, weights)?,
            workspace: ProjectionWorkspace::new(),
            window: [[Transform::IDENTITY; N]; 3],
            newest: delay_ticks,
            delay_ticks,
            observer: Observer::new(settings, &JointStates::rest(tree), delay_ticks)?,
        };
        for back in (0..3).rev() {
            setting.take_in(show, tree, delay_ticks.saturating_sub(back))?;
        }
        Ok(setting)
    }

    /// The same, with a range for each joint: no target is outside of one.
    ///
    /// # Errors
    /// [`RecommendedError`] if there is not a range for each joint, or one does not fit its joint.
    pub fn with_ranges(
        self,
        tree: &Tree<N>,
        ranges: &[JointRange],
    ) -> Result<Self, RecommendedError> {
        Ok(Self { projection: self.projection.with_ranges(tree, ranges)?, ..self })
    }

    /// Takes a frame of the show into the window, as the rig can perform it; before the first frame the show stands on
    /// it, after the last too.
    fn take_in(
        &mut self,
        show: &Show<'_>,
        tree: &Tree<N>,
        index: usize,
    ) -> Result<(), ProjectionError> {
        let mut frame = [Transform::IDENTITY; N];
        show.frame(index, &mut frame);
        self.window.rotate_left(1);
        let [_, _, last] = &mut self.window;
        let frame = frame.get(..tree.len()).unwrap_or_default();
        let nearest = last.get_mut(..tree.len()).unwrap_or_default();
        self.projection.project(tree, frame, &mut self.workspace, nearest)
    }

    /// Targets for the state that a torque of tick `index` meets. From one tick to the next one frame is projected,
    /// after a jump three.
    pub(crate) fn targets(
        &mut self,
        show: &Show<'_>,
        tree: &Tree<N>,
        index: usize,
        out: &mut JointTargets<N>,
    ) -> Result<(), StateInputError> {
        let newest = index.saturating_add(self.delay_ticks).saturating_add(1);
        let follows = self.newest.saturating_add(1) == newest;
        for back in if follows { 0..1 } else { 0..3 }.rev() {
            // The show's poses were checked when it was parsed.
            self.take_in(show, tree, newest.saturating_sub(back))
                .map_err(|_| StateInputError::NonFinite)?;
        }
        self.newest = newest;
        let bodies = tree.len();
        let window = self.window.each_ref().map(|frame| frame.get(..bodies).unwrap_or_default());
        aligned_targets(window, show.dt_s(), out)
    }

    /// Takes in the measured joints, and takes what was learnt of disturbances off the targets.
    ///
    /// Begins anew from `states`, the measured ones by differences, when ticks were left out: the commands in
    /// between are not known.
    pub(crate) fn observe(
        &mut self,
        tree: &Tree<N>,
        measured: &[Transform],
        anew: Option<&JointStates<N>>,
        targets: &mut JointTargets<N>,
    ) -> Result<(), StateInputError> {
        match anew {
            Some(states) => self.observer.restart(states),
            None => self.observer.observe(tree, measured)?,
        }
        self.observer.compensate(targets);
        Ok(())
    }

    /// The state that a torque of this tick meets.
    pub(crate) fn states(&self) -> &JointStates<N> {
        self.observer.states()
    }

    /// Notes what the joints were commanded.
    pub(crate) fn sent(&mut self, commands: &[Twist], torques: &[Limited<Wrench>]) {
        self.observer.record_commands(commands, torques);
    }
}

/// Why the setting cannot be had.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RecommendedError {
    /// The projection.
    Projection(ProjectionError),
    /// The observer.
    Observer(ObserverError),
    /// The delay and the tick together take longer than [`LATE_MOST_S`].
    TooLate,
}

impl From<ProjectionError> for RecommendedError {
    fn from(error: ProjectionError) -> Self {
        Self::Projection(error)
    }
}

impl From<ObserverError> for RecommendedError {
    fn from(error: ObserverError) -> Self {
        Self::Observer(error)
    }
}

impl core::fmt::Display for RecommendedError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Projection(error) => error.fmt(f),
            Self::Observer(error) => error.fmt(f),
            Self::TooLate => f.write_str(
                "the delay and the tick together must not take longer than 10 ms: more ticks a second, or another setting",
            ),
        }
    }
}

impl core::error::Error for RecommendedError {}
