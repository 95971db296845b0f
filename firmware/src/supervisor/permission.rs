//! Permission of a tick for the drives.

use super::{Allows, Feed, Mode, Settings, Source, State};

/// Permission of a tick for the drives. The caller applies it, and the [`Guard`](super::Guard) enforces it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Permission {
    /// Whether torque may be on. If not, it is switched off in this tick.
    pub torque: bool,
    /// Source of the commanded pose.
    pub source: Source,
    /// Weight of the source against the pose that was commanded when the source began: from 0 to 1, with speed and
    /// acceleration zero at both ends. A jog begins in that pose, and has its whole weight at once.
    pub weight: f32,
    /// Whether the source's own time advances: a show waits at its first pose until the rig has reached it.
    pub runs: bool,
    /// Maximum speed of a joint, rad/s; with `None` only the servos' own limits apply.
    pub speed_rad_s: Option<f32>,
    /// Permitted part of a drive's effort, 1 to 0.
    pub effort: f32,
}

impl Permission {
    /// Returns the permission of a mode. `blended` is the elapsed part of the blend's time, `effort` the part of the
    /// effort that lowering leaves.
    pub(super) fn of(mode: &Mode, settings: &Settings, blended: f32, effort: f32) -> Self {
        let (torque, source) = (mode.allows() > Allows::Nothing, mode.source());
        let is_jog = source == Source::Feed(Feed::Jog);
        // A rig that is led by hand is as fast as the hand; a rig that is lowered has its own limit.
        let is_own = matches!(mode.state, State::Floating | State::Lowering);
        let soft = (mode.is_soft && !is_own || is_jog).then_some(settings.soft_rad_s);
        let of_state = match mode.state {
            State::Maintenance => Some(settings.maintenance_rad_s),
            State::Stopping => Some(settings.stop_rad_s),
            State::Arming => Some(settings.soft_rad_s),
            State::Lowering => Some(settings.lower_rad_s),
            State::Floating => Some(settings.float_rad_s),
            _ => None,
        };
        let speed_rad_s = match (soft, of_state) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        let effort = match mode.state {
            State::Lowering => effort,
            _ if torque => 1.0,
            _ => 0.0,
        };
        let is_fed = matches!(source, Source::Feed(_));
        let runs = is_fed && blended >= 1.0 && !mode.is_soft;
        let weight = if is_jog { 1.0 } else { smooth(blended) };
        Self { torque, source, weight, runs, speed_rad_s, effort }
    }
}

/// Returns a quintic from 0 to 1, with slope and curvature zero at both ends. Both halves are symmetric, so that it
/// ends exactly at 1.
pub(crate) fn smooth(share: f32) -> f32 {
    let rise = |t: f32| t * t * t * (10.0 + t * (6.0 * t - 15.0));
    if share < 0.5 { rise(share.max(0.0)) } else { 1.0 - rise((1.0 - share).max(0.0)) }
}
