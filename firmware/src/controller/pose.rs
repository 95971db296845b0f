//! State of a rig: positions, velocities and accelerations.

use sinew_core::tracker::{Frame, FrameSource};

/// Largest accepted absolute value, as in `sinew-core`'s coordinates.
const LARGEST: f32 = 1e6;

/// A state in a rig's coordinates, with at most `COORDS` coordinates and `DOFS` dofs.
#[derive(Debug, Clone)]
pub(super) struct Pose<const DOFS: usize, const COORDS: usize> {
    coordinates: usize,
    dofs: usize,
    q: [f32; COORDS],
    qd: [f32; DOFS],
    qdd: [f32; DOFS],
}

impl<const DOFS: usize, const COORDS: usize> Pose<DOFS, COORDS> {
    /// Creates a pose at zero. Counts above the capacities are limited to them.
    pub(super) fn new(coordinates: usize, dofs: usize) -> Self {
        let (coordinates, dofs) = (coordinates.min(COORDS), dofs.min(DOFS));
        Self { coordinates, dofs, q: [0.0; COORDS], qd: [0.0; DOFS], qdd: [0.0; DOFS] }
    }

    pub(super) fn q(&self) -> &[f32] {
        self.q.get(..self.coordinates).unwrap_or_default()
    }

    pub(super) fn qd(&self) -> &[f32] {
        self.qd.get(..self.dofs).unwrap_or_default()
    }

    pub(super) fn qdd(&self) -> &[f32] {
        self.qdd.get(..self.dofs).unwrap_or_default()
    }

    pub(super) fn q_mut(&mut self) -> &mut [f32] {
        self.q.get_mut(..self.coordinates).unwrap_or_default()
    }

    /// Returns positions, velocities and accelerations.
    pub(super) fn all_mut(&mut self) -> [&mut [f32]; 3] {
        [
            self.q.get_mut(..self.coordinates).unwrap_or_default(),
            self.qd.get_mut(..self.dofs).unwrap_or_default(),
            self.qdd.get_mut(..self.dofs).unwrap_or_default(),
        ]
    }

    /// Sets velocities and accelerations to zero.
    pub(super) fn rest(&mut self) {
        (self.qd, self.qdd) = ([0.0; DOFS], [0.0; DOFS]);
    }

    /// Copies a frame of coordinates. Returns whether the frame's lengths are those of this rig.
    pub(super) fn take(&mut self, frame: Frame<'_>) -> bool {
        let Frame::Coordinates { q, qd, qdd } = frame else { return false };
        let mut fits = true;
        for (own, other) in self.all_mut().into_iter().zip([q, qd, qdd]) {
            fits &= own.len() == other.len();
            own.iter_mut().zip(other).for_each(|(own, other)| *own = *other);
        }
        fits
    }

    /// Returns whether all numbers are finite and at most 1e6 in absolute value.
    pub(super) fn is_finite(&self) -> bool {
        let mut all = self.q().iter().chain(self.qd()).chain(self.qdd());
        all.all(|x| (-LARGEST..=LARGEST).contains(x))
    }
}

/// Returns the same pose for any frame number: the path has already advanced to it.
impl<const DOFS: usize, const COORDS: usize> FrameSource for &Pose<DOFS, COORDS> {
    fn frame(&mut self, _: i32) -> Frame<'_> {
        Frame::Coordinates { q: self.q(), qd: self.qd(), qdd: self.qdd() }
    }

    #[inline]
    fn has_coordinates_alone(&self) -> bool {
        true
    }
}
