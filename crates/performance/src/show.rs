//! Shows for the boards: a clip and the rig that performs it, as bytes for flash.

use std::convert::Infallible;

use sinew_core::{Transform, TreeError};
use sinew_evaluation::CAPACITY;
use sinew_figure::{BodyModel, FigureMotion, Root};
use sinew_firmware::show;

/// Bakes the first `frames` frames of a clip (all, if it has fewer) for a figure, in the format of
/// [`sinew_firmware::show`].
///
/// # Errors
/// [`TreeError`] if the figure cannot be a rig.
pub fn bake(motion: &FigureMotion, model: &BodyModel, frames: usize) -> Result<Vec<u8>, TreeError> {
    let tree = model.mechanism(Root::Driven).tree::<CAPACITY>()?;
    let poses: Vec<Vec<Transform>> =
        (0..motion.rotation.len().min(frames)).map(|frame| motion.joint_poses(frame)).collect();
    #[expect(clippy::cast_possible_truncation, reason = "the core computes in f32")]
    let dt_s = motion.dt_s as f32;
    let mut bytes = Vec::new();
    let sink = |piece: &[u8]| {
        bytes.extend_from_slice(piece);
        Ok::<(), Infallible>(())
    };
    let Ok(()) = show::write(tree.bodies(), dt_s, poses.iter().map(Vec::as_slice), sink);
    Ok(bytes)
}
