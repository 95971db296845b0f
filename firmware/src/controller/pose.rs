//! Where a rig is, how fast, and how fast that changes.

use sinew_core::tracker::{Frame, FrameSource};

/// The largest number that is taken, as in `sinew-core`'s coordinates.
const LARGEST: f32 = 1e6;

/// A state in a rig's coordinates: `C` at most, of `V` freedoms at most.
#[derive(Debug, Clone)]
pub(super) struct Pose<const V: usize, const C: usize> {
    coordinates: usize,
    freedoms: usize,
    q: [f32; C],
    qd: [f32; V],
    qdd: [f32; V],
}

impl<const V: usize, const C: usize> Pose<V, C> {
    /// At zero. Counts beyond the capacities are held to them.
    pub(super) fn new(coordinates: usize, freedoms: usize) -> Self {
        let (coordinates, freedoms) = (coordinates.min(C), freedoms.min(V));
        Self { coordinates, freedoms, q: [0.0; C], qd: [0.0; V], qdd: [0.0; V] }
    }

    pub(super) fn q(&self) -> &[f32] {
        self.q.get(..self.coordinates).unwrap_or_default()
    }

    pub(super) fn qd(&self) -> &[f32] {
        self.qd.get(..self.freedoms).unwrap_or_default()
    }

    pub(super) fn qdd(&self) -> &[f32] {
        self.qdd.get(..self.freedoms).unwrap_or_default()
    }

    pub(super) fn q_mut(&mut self) -> &mut [f32] {
        self.q.get_mut(..self.coordinates).unwrap_or_default()
    }

    /// Positions, speeds, accelerations.
    pub(super) fn all_mut(&mut self) -> [&mut [f32]; 3] {
        [
            self.q.get_mut(..self.coordinates).unwrap_or_default(),
            self.qd.get_mut(..self.freedoms).unwrap_or_default(),
            self.qdd.get_mut(..self.freedoms).unwrap_or_default(),
        ]
    }

    /// At rest in the positions that are there.
    pub(super) fn rest(&mut self) {
        (self.qd, self.qdd) = ([0.0; V], [0.0; V]);
    }

    /// Takes a frame of coordinates; says whether it was one of this rig.
    pub(super) fn take(&mut self, frame: Frame<'_>) -> bool {
        let Frame::Coordinates { q, qd, qdd } = frame else { return false };
        let mut fits = true;
        for (own, other) in self.all_mut().into_iter().zip([q, qd, qdd]) {
            fits &= own.len() == other.len();
            own.iter_mut().zip(other).for_each(|(own, other)| *own = *other);
        }
        fits
    }

    /// Whether all are numbers of a usual size.
    pub(super) fn is_finite(&self) -> bool {
        let mut all = self.q().iter().chain(self.qd()).chain(self.qdd());
        all.all(|x| (-LARGEST..=LARGEST).contains(x))
    }
}

/// One pose, whatever the frame's number: the path has counted already.
impl<const V: usize, const C: usize> FrameSource for &Pose<V, C> {
    fn frame(&mut self, _: i32) -> Frame<'_> {
        Frame::Coordinates { q: self.q(), qd: self.qd(), qdd: self.qdd() }
    }
}
