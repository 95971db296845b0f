//! The way to the beginning of a show, computed ahead: for programs on a host that tell how long it takes.

use sinew_core::tracker::FrameSource as _;
use sinew_rig::board::BoardRig;
use sinew_show::ShowFrames;

use super::path::Path;
use super::pose::Pose;
use crate::supervisor::{Settings, smooth};

/// Longest way that is computed, s.
const MOST_S: f32 = 300.0;

/// The beginning of a show, from a pose at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Approach {
    /// Time from the command to play until the rig is at the show's first pose and the show's clock starts, s.
    pub way_s: f32,
    /// Time by which the show is late from then on, because it begins at speed and reaches its pace from rest, s.
    pub late_s: f32,
}

/// Computes the beginning of a show from a pose, as the controller will move. O(ticks · dofs). Returns `None` if the
/// rig has more coordinates than there is room for, or the way takes longer than 5 minutes.
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
