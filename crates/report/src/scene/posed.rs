//! The mannequin in a frame of a motion.

use sinew_figure::plant::Pose;
use sinew_figure::{BODIES, FigureMotion};

use super::mannequin::{Mannequin, Points};

/// Returns the mannequin of a motion, and its points in a frame.
pub fn posed(motion: &FigureMotion, frame: usize) -> (Mannequin, Points) {
    let mut poses: Vec<Pose> = Vec::new();
    for (body, position_m) in motion.world_positions_m(frame).into_iter().enumerate() {
        let local = motion.rotation[frame][body];
        let rotation = BODIES[body].parent.map_or(local, |parent| poses[parent].rotation * local);
        poses.push(Pose { rotation, position_m });
    }
    let mannequin = Mannequin::of_figure(motion);
    let points = mannequin.points(&poses);
    (mannequin, points)
}
