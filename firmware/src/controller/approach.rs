//! Computes the way to the beginning of a show, so that programs on a host can report its duration in advance.

use sinew_core::tracker::FrameSource as _;
use sinew_rig::board::BoardRig;
use sinew_show::ShowFrames;

use super::path::Path;
use super::pose::Pose;
use crate::supervisor::{Settings, smooth};

/// Maximum duration of a way, s.
const MOST_S: f32 = 300.0;

/// Way of a rig from a pose at rest to the beginning of a show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Approach {
    /// Time from the command to play until the rig reaches the show's first pose and the show's clock starts, s.
    pub way_s: f32,
    /// Constant delay of the show, s. It is above zero if the show begins at speed, because the rig must accelerate.
    pub late_s: f32,
}

/// Computes the way to the beginning of a show as the controller will move it. O(ticks · dofs). Returns `None` if the
/// rig has more coordinates than `COORDS`, or the way takes longer than 5 minutes.
pub fn approach<
    const BODIES: usize,
    const DOFS: usize,
    const SERVOS: usize,
    const COORDS: usize,
>(
    rig: &BoardRig<BODIES, DOFS, SERVOS>,
    settings: &Settings,
    frames: &mut ShowFrames<'_, COORDS>,
    dt_s: f32,
    from: &[f32],
) -> Option<Approach> {
    let mut path: Path<DOFS, COORDS> = Path::new(rig, dt_s)?;
    path.place(from);
    let mut goal = path.now().clone();
    goal.take(frames.frame(0));
    let is_at_speed = path.moving(goal.qd(), settings.soft_rad_s).is_some();
    let late_s = if is_at_speed { 0.5 * settings.blend_s } else { 0.0 };
    let mut first: Pose<DOFS, COORDS> = goal;
    first.take(frames.frame(-1));
    let mut way_s = 0.0;
    while way_s < MOST_S {
        let weight = smooth(way_s / settings.blend_s);
        way_s += dt_s;
        if path.step(&first, weight, Some(settings.soft_rad_s)) {
            return Some(Approach { way_s, late_s });
        }
    }
    None
}
