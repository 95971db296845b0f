//! Detects when a foot of the performer stands.

use glam::DVec3;

/// Toe speeds up to which a toe certainly stands, and from which it certainly does not, m/s.
const STILL_M_S: [f64; 2] = [0.25, 0.5];
/// Heights above the floor up to which a toe certainly stands, and from which it certainly does not, m.
const LOW_M: [f64; 2] = [0.05, 0.09];
/// Half the time over which the speed is measured, s.
pub(super) const HALF_S: f64 = 1.0 / 30.0;

/// Returns how certainly a toe with this speed and height stands, from 0 to 1.
pub(super) fn stands(speed_m_s: f64, height_m: f64) -> f64 {
    fade(speed_m_s, STILL_M_S) * fade(height_m, LOW_M)
}

/// Returns how certainly the toe stands in each frame, from 0 to 1. The speed in a frame is measured over the time
/// before and after it.
pub(super) fn contacts(toe_m: &[DVec3], frame_s: f64, floor_m: f64) -> Vec<f64> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small number of frames"
    )]
    let half = ((HALF_S / frame_s).round() as usize).max(1);
    let last = toe_m.len().saturating_sub(1);
    let at = |frame: usize| {
        let (before, after) = (frame.saturating_sub(half), (frame + half).min(last));
        let way_m = toe_m[before].distance(toe_m[after]);
        let speed_m_s = way_m / ((after - before).max(1) as f64 * frame_s);
        stands(speed_m_s, toe_m[frame].y - floor_m)
    };
    (0..toe_m.len()).map(at).collect()
}

/// Returns a smooth transition from 1 at the first end to 0 at the second.
fn fade(value: f64, [from, to]: [f64; 2]) -> f64 {
    let t = ((value - from) / (to - from)).clamp(0.0, 1.0);
    1.0 - t * t * (3.0 - 2.0 * t)
}
