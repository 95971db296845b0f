//! Frames of a performance, readings of sensors, and the source of frames.

use crate::transform::Transform;

/// A frame of a performance: the desired pose of the rig at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Frame<'a> {
    /// Poses of all joints, each in its parent's frame, in metres. The dimensions may be those of another figure; a
    /// projection then finds the rig's own pose. Velocities and accelerations are differences of frames.
    Poses(&'a [Transform]),
    /// The rig's own coordinates with their exact derivatives, as defined in [`coordinates`](crate::coordinates).
    /// They need neither projection nor differences, and are not limited to the joints' ranges.
    Coordinates {
        /// Positions of the joints, nq numbers.
        q: &'a [f32],
        /// Speeds by dof, nv numbers.
        qd: &'a [f32],
        /// Accelerations by dof, nv numbers.
        qdd: &'a [f32],
    },
}

/// The measurement of the joints' sensors in a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Measured<'a> {
    /// Poses of all joints, each in its parent's frame. Velocities are backward differences.
    Poses(&'a [Transform]),
    /// Positions alone, as defined in [`coordinates`](crate::coordinates): for encoders that measure no speeds.
    /// Speeds are backward differences.
    Positions {
        /// Positions of the joints, nq numbers.
        q: &'a [f32],
    },
    /// Positions and speeds, as defined in [`coordinates`](crate::coordinates). An observer estimates the speeds
    /// itself; it uses the measured speeds only to start.
    Coordinates {
        /// Positions of the joints, nq numbers.
        q: &'a [f32],
        /// Speeds by dof, nv numbers.
        qd: &'a [f32],
    },
}

impl<'a> From<&'a [Transform]> for Measured<'a> {
    fn from(poses: &'a [Transform]) -> Self {
        Self::Poses(poses)
    }
}

impl<'a, const K: usize> From<&'a [Transform; K]> for Measured<'a> {
    fn from(poses: &'a [Transform; K]) -> Self {
        Self::Poses(poses)
    }
}

/// A source of frames, such as a baked show, a clip, a live stream, or a held pose.
///
/// A [`Tracker`](super::Tracker) asks for frames by number and is independent of their storage. All frames of a
/// source are of one kind; before a source of the other kind, call [`begin`](super::Tracker::begin) again.
///
/// ```
/// use sinew_core::Transform;
/// use sinew_core::tracker::{Frame, FrameSource};
/// /// Holds one pose for ever.
/// struct Hold([Transform; 1]);
///
/// impl FrameSource for Hold {
///     fn frame(&mut self, _index: i32) -> Frame<'_> {
///         Frame::Poses(&self.0)
///     }
/// }
/// # assert_eq!(Hold([Transform::IDENTITY]).frame(3), Frame::Poses(&[Transform::IDENTITY]));
/// ```
pub trait FrameSource {
    /// Returns the frame with this number. Negative numbers are before the performance: see
    /// [`extrapolate_before_start`]. Beyond the end, the last frame is held.
    fn frame(&mut self, index: i32) -> Frame<'_>;

    /// Returns `true` if all frames are [`Frame::Coordinates`]. If the compiler can evaluate this method to `true`,
    /// a board's image contains no code for poses: neither projection nor differences.
    #[inline]
    fn has_coordinates_alone(&self) -> bool {
        false
    }
}

impl<S: FrameSource + ?Sized> FrameSource for &mut S {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        (**self).frame(index)
    }

    #[inline]
    fn has_coordinates_alone(&self) -> bool {
        (**self).has_coordinates_alone()
    }
}

/// Extrapolates a pose `frames` before the start, at the velocity of the first step.
///
/// ```
/// use sinew_core::{Transform, glam::Vec3, tracker::extrapolate_before_start};
/// let [first, second] = [1.0, 3.0].map(|x| Transform::from_translation(Vec3::X * x));
/// assert_eq!(extrapolate_before_start(&first, &second, 2).translation_m.x, -3.0);
/// ```
pub fn extrapolate_before_start(first: &Transform, second: &Transform, frames: u32) -> Transform {
    // A small number: differences look back a few frames, and latencies are short.
    #[expect(clippy::cast_precision_loss, reason = "a small number")]
    let frames = frames as f32;
    crate::trajectory::interpolate(first, second, -frames)
}
