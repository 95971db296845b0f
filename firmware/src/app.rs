//! The control tick as the boards run it: a show's frame and measured joints in, limited torques out.

use sinew_core::control::Limited;
use sinew_core::state_error::StateError;
use sinew_core::supply::TorqueSupply;
use sinew_core::{
    Controller, ForwardDifferences, JointStates, JointTargets, StateInputError, Transform,
    Workspace, Wrench,
};

use crate::recommended::Recommended;
use crate::show::Show;

/// How many frames beyond a tick's own forward differences take.
const FRAMES_AHEAD: usize = 2;

/// All that a tick needs, in one place of fixed size: put it in a static.
///
/// ```
/// use sinew_core::{Controller, Transform, control::Gains, state_error::Method};
/// use sinew_firmware::{app::App, show::Show};
/// # let flash = {
/// #     use sinew_core::{Body, Inertia, JointKind};
/// #     let (parent, joint, placement) = (None, JointKind::Spherical, Transform::IDENTITY);
/// #     let head = Body { parent, joint, placement, inertia: Inertia::default() };
/// #     let (mut flash, frames) = (Vec::new(), [[Transform::IDENTITY]; 3]);
/// #     let sink = |piece: &[u8]| Ok::<(), std::fmt::Error>(flash.extend_from_slice(piece));
/// #     sinew_firmware::show::write(&[head], 0.01, frames.iter().map(|f| &f[..]), sink)?;
/// #     flash
/// # };
/// let show = Show::parse(&flash)?;
/// let gains = Gains::critically_damped(200.0)?;
/// let controller = Controller::new(show.tree::<1>()?, gains, Method::World)?;
/// let mut app = App::new(show, controller);
/// for tick in 0..show.frame_count() {
///     // What the sensors of the joints say goes in, and torques for their drives come out.
///     app.observe(tick, &[Transform::IDENTITY])?;
///     let torques = app.control();
///     assert_eq!(torques.len(), 1);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct App<'a, const N: usize, const R: usize = 0> {
    show: Show<'a>,
    controller: Controller<N>,
    targets: JointTargets<N>,
    measured: JointStates<N>,
    workspace: Workspace<N, R>,
    recommended: Option<Recommended<N>>,
    supply: Option<TorqueSupply<N>>,
    differences: ForwardDifferences<N>,
    /// The frame that the differences took last, and its number; none before the first.
    frame: [Transform; N],
    newest: Option<usize>,
    /// Ticks since the last poses were measured; zero before any were.
    age_ticks: u16,
}

impl<'a, const N: usize> App<'a, N> {
    /// An application at the first frame of `show`. The controller must be made of the show's own [`Show::tree`].
    pub fn new(show: Show<'a>, controller: Controller<N>) -> Self {
        Self::with_workspace(show, controller, Workspace::new())
    }
}

impl<'a, const N: usize, const R: usize> App<'a, N, R> {
    /// The same with a workspace of its own: resolved acceleration needs [`Workspace::resolving`].
    pub fn with_workspace(
        show: Show<'a>,
        controller: Controller<N>,
        workspace: Workspace<N, R>,
    ) -> Self {
        Self {
            show,
            targets: JointTargets::rest(controller.tree()),
            measured: JointStates::rest(controller.tree()),
            controller,
            workspace,
            recommended: None,
            supply: None,
            differences: ForwardDifferences::new(),
            frame: [Transform::IDENTITY; N],
            newest: None,
            age_ticks: 0,
        }
    }

    /// The same in the setting for real rigs, see [`crate::recommended`]; its controller should have the World
    /// method, inverse dynamics and implicit gains. The setting must be made of the controller's own tree.
    #[must_use]
    pub fn with(self, setting: Recommended<N>) -> Self {
        Self { recommended: Some(setting), ..self }
    }

    /// The same with drives that share a supply: what a tick asks of them is cut to it. It must be made of the
    /// controller's own tree.
    #[must_use]
    pub fn with_supply(self, supply: TorqueSupply<N>) -> Self {
        Self { supply: Some(supply), ..self }
    }

    /// Takes the targets of frame `index` by forward differences of the bodies, and the measured joints by backward ones
    /// from the last call that was not refused. `measured` has a pose per joint, each in its parent's frame.
    ///
    /// The first poses count as at rest: where the rig stood before is not known, and it need not be where the show
    /// begins.
    ///
    /// # Errors
    /// [`StateInputError`] if a joint has no measured pose, or one that is not finite or not unit: the board must
    /// then hold its servos safe, and not call [`Self::control`].
    pub fn observe(&mut self, index: usize, measured: &[Transform]) -> Result<(), StateInputError> {
        let bodies = self.show.body_count().min(N);
        let measured = measured.get(..bodies).ok_or(StateInputError::NoSuchJoint)?;
        let (tree, dt_s) = (self.controller.tree(), self.show.dt_s());
        if let Some(recommended) = &mut self.recommended {
            recommended.targets(&self.show, tree, index, &mut self.targets)?;
        } else {
            let newest = index.saturating_add(FRAMES_AHEAD);
            let follows = self.newest.and_then(|newest| newest.checked_add(1)) == Some(newest);
            if !follows {
                self.show.frame(index, &mut self.frame);
                let frame = self.frame.get(..bodies).unwrap_or_default();
                self.differences.restart(tree, dt_s, frame)?;
            }
            // From one tick to the next one frame is taken; after a jump, all that the differences look ahead to.
            let first = if follows { newest } else { index.saturating_add(1) };
            for index in first..=newest {
                self.show.frame(index, &mut self.frame);
                let frame = self.frame.get(..bodies).unwrap_or_default();
                self.differences.advance(tree, frame, &mut self.targets)?;
            }
            self.newest = Some(newest);
        }
        let age_ticks = self.age_ticks;
        // Ages before the poses are looked at: one that is refused has taken its tick all the same.
        self.age_ticks = age_ticks.saturating_add(u16::from(age_ticks > 0));
        let continues = self.recommended.is_some() && age_ticks == 1;
        match age_ticks {
            0 => self.measured.set_at_rest(measured)?,
            // The observer goes on by itself.
            1 if continues => {}
            _ => self.measured.update_poses(measured, dt_s * f32::from(age_ticks))?,
        }
        if let Some(recommended) = &mut self.recommended {
            let anew = (!continues).then_some(&self.measured);
            recommended.observe(tree, measured, anew, &mut self.targets)?;
            if continues {
                // In case that the next poses are refused.
                self.measured.set_at_rest(measured)?;
            }
        }
        self.age_ticks = 1;
        Ok(())
    }

    /// The torques for what was observed last, see [`Controller::tick`]; within the supply, if there is one.
    pub fn control(&mut self) -> &[Limited<Wrench>] {
        let states = self.recommended.as_ref().map_or(&self.measured, Recommended::states);
        let w = &mut self.workspace;
        self.controller.tick(&mut self.targets, states, &[], w);
        let count = self.controller.tree().len();
        if let Some(supply) = &self.supply {
            supply.share(w.torques_mut().get_mut(..count).unwrap_or_default());
        }
        let torques = w.torques().get(..count).unwrap_or_default();
        if let Some(recommended) = &mut self.recommended {
            recommended.sent(w.commands(), torques);
        }
        torques
    }

    /// The rig's controller.
    pub fn controller(&self) -> &Controller<N> {
        &self.controller
    }

    /// What was observed last: the targets of the show's frame.
    pub fn targets(&self) -> &JointTargets<N> {
        &self.targets
    }

    /// What was observed last: the state that [`Self::control`] goes by.
    pub fn states(&self) -> &JointStates<N> {
        self.recommended.as_ref().map_or(&self.measured, Recommended::states)
    }

    /// What the last tick left: commands, torques.
    pub fn workspace(&self) -> &Workspace<N, R> {
        &self.workspace
    }

    /// State errors of the last tick, see [`Controller::errors`].
    pub fn errors(&mut self, out: &mut [StateError]) {
        let states = self.recommended.as_ref().map_or(&self.measured, Recommended::states);
        self.controller.errors(&mut self.targets, states, &mut self.workspace, out);
    }

    /// The show.
    pub fn show(&self) -> &Show<'a> {
        &self.show
    }
}
