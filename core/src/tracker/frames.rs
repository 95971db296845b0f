//! Where frames come from.

use crate::transform::Transform;

/// One frame of a performance: where the rig should be at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Frame<'a> {
    /// Poses of all joints, each in its parent's frame, in metres. The dimensions may be those of another figure: a
    /// projection finds the rig's own pose. Velocities and accelerations are differences of frames.
    Poses(&'a [Transform]),
    /// The rig's own coordinates with their exact derivatives, as [`coordinates`](crate::coordinates) has them. They
    /// need neither projection nor differences, and nothing keeps them within the joints' ranges.
    Coordinates {
        /// Positions of the joints, nq numbers.
        q: &'a [f32],
        /// Speeds along the degrees of freedom, nv numbers.
        qd: &'a [f32],
        /// Accelerations along the degrees of freedom, nv numbers.
        qdd: &'a [f32],
    },
}

/// What the sensors of the joints measured in a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Measured<'a> {
    /// Poses of all joints, each in its parent's frame. Velocities are backward differences.
    Poses(&'a [Transform]),
    /// Positions alone, as [`coordinates`](crate::coordinates) has them: of encoders that measure no speeds. Speeds are
    /// backward differences.
    Positions {
        /// Positions of the joints, nq numbers.
        q: &'a [f32],
    },
    /// Positions and speeds, as [`coordinates`](crate::coordinates) has them. An observer estimates the speeds itself;
    /// it uses these only to start.
    Coordinates {
        /// Positions of the joints, nq numbers.
        q: &'a [f32],
        /// Speeds along the degrees of freedom, nv numbers.
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

/// Where frames come from: a baked show, a clip, a live stream, a pose that is held.
///
/// A [`Tracker`](super::Tracker) asks for frames by number and never knows how they are stored. All frames of a source
/// are of one kind; before a source of the other kind, [`begin`](super::Tracker::begin) anew.
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
    /// The frame of that number. Negative ones lie before the performance: see [`extrapolate_before_start`]. Beyond the
    /// end, the last one is held.
    fn frame(&mut self, index: i32) -> Frame<'_>;

    /// Whether all frames are [`Frame::Coordinates`]. A source that says so at compile time leaves all that poses need,
    /// projection and differences, out of a board's image.
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
    // Few: as many as differences look back, and latencies are long.
    #[expect(clippy::cast_precision_loss, reason = "a small number")]
    let frames = frames as f32;
    crate::trajectory::interpolate(first, second, -frames)
}
