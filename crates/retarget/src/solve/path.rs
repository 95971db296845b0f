//! Where hips and feet go over a whole clip, so that feet that stand do not slide: least squares over all frames.
//!
//! Posture alone says where the toes are from the hips. First the hips' path is found that is near the performer's and
//! keeps standing toes where they are; then each toe's path that is near what the two make of it, and stands still.
//! Weights change smoothly from frame to frame, and so do the paths: there is no edge where a foot would jump.

use glam::DVec3;

use super::banded::Banded;

/// Times in which the hips come back to the performer's path: horizontally and in height, s.
const HIPS_S: [f64; 2] = [1.6, 0.3];
/// Keeping a standing toe counts as much more than following the performer's velocity.
const STANDS: f64 = 50.0;
/// Height of a standing toe: time in which it comes to the floor, s.
const FLOOR_S: f64 = 0.1;
/// Of a toe's path: time in which it comes back to what posture says, s, and in which it comes to rest when it stands.
const TOE_S: f64 = 0.08;
const REST_S: f64 = 0.004;
/// Time in which a standing toe comes to the floor's height, s.
const DOWN_S: f64 = 0.02;

/// What is known of the frames of a clip.
pub(super) struct Frames<'a> {
    pub(super) frame_s: f64,
    /// The performer's hips at the rig's scale above the floor, m.
    pub(super) wanted_m: &'a [DVec3],
    /// By foot: the toe from the hips by posture alone, m.
    pub(super) toes_m: &'a [Vec<DVec3>],
    /// By foot: whether it stands, from 0 to 1.
    pub(super) contacts: &'a [Vec<f64>],
}

impl Frames<'_> {
    fn count(&self) -> usize {
        self.wanted_m.len()
    }

    /// Whether a foot stands from a frame to the next.
    fn stands(&self, foot: usize, frame: usize) -> f64 {
        self.contacts[foot][frame].min(self.contacts[foot][frame + 1])
    }

    /// The hips' path, m.
    pub(super) fn hips_m(&self) -> Vec<DVec3> {
        let raised_m = self.raised_m();
        let axis = |axis: usize| {
            let back_s = HIPS_S[usize::from(axis == 1)];
            let mut sums = Banded::new(self.count());
            for frame in 0..self.count() {
                let raise_m = if axis == 1 { raised_m } else { 0.0 };
                let wanted = self.wanted_m[frame][axis] + raise_m;
                sums.add(frame, [1.0], wanted, square(self.frame_s / back_s));
                for foot in 0..self.toes_m.len() {
                    if axis == 1 {
                        let weight = STANDS * square(self.frame_s / FLOOR_S);
                        let height = -self.toes_m[foot][frame].y;
                        sums.add(frame, [1.0], height, weight * self.contacts[foot][frame]);
                    }
                }
                if frame + 1 == self.count() {
                    break;
                }
                let step = self.wanted_m[frame + 1][axis] - self.wanted_m[frame][axis];
                sums.add(frame, [-1.0, 1.0], step, 1.0);
                for foot in 0..self.toes_m.len() {
                    let toe = &self.toes_m[foot];
                    let step = toe[frame][axis] - toe[frame + 1][axis];
                    sums.add(frame, [-1.0, 1.0], step, STANDS * self.stands(foot, frame));
                }
            }
            sums.solve()
        };
        let [x, y, z] = [0, 1, 2].map(axis);
        x.into_iter().zip(y).zip(z).map(|((x, y), z)| DVec3::new(x, y, z)).collect()
    }

    /// How much higher the rig's hips are than the performer's at its scale when its feet stand: feet are not as thick.
    fn raised_m(&self) -> f64 {
        let (mut sum, mut weights, mut highest) = (0.0, 0.0, f64::NEG_INFINITY);
        for (toe, contacts) in self.toes_m.iter().zip(self.contacts) {
            for (frame, contact) in contacts.iter().enumerate() {
                let raised_m = -toe[frame].y - self.wanted_m[frame].y;
                sum += contact * raised_m;
                weights += contact;
                highest = highest.max(raised_m);
            }
        }
        // A performer who never stands is put on the floor by the lowest toe.
        if weights > 0.0 { sum / weights } else { highest.max(-1e3) }
    }

    /// The path of a foot's toe, m.
    pub(super) fn toe_m(&self, foot: usize, hips_m: &[DVec3]) -> Vec<DVec3> {
        let contacts = &self.contacts[foot];
        let by_posture =
            |frame: usize, axis: usize| hips_m[frame][axis] + self.toes_m[foot][frame][axis];
        let axis = |axis: usize| {
            let mut sums = Banded::new(self.count());
            for (frame, contact) in contacts.iter().enumerate() {
                let wanted = by_posture(frame, axis);
                sums.add(frame, [1.0], wanted, square(square(self.frame_s / TOE_S)));
                if axis == 1 {
                    let weight = square(square(self.frame_s / DOWN_S));
                    sums.add(frame, [1.0], 0.0, weight * contact);
                }
                if frame + 1 < self.count() {
                    let weight = square(self.frame_s / REST_S);
                    sums.add(frame, [-1.0, 1.0], 0.0, weight * self.stands(foot, frame));
                }
                if frame + 2 < self.count() {
                    let [a, b, c] = [0, 1, 2].map(|k| by_posture(frame + k, axis));
                    sums.add(frame, [1.0, -2.0, 1.0], a - 2.0 * b + c, 1.0);
                }
            }
            sums.solve()
        };
        let [x, y, z] = [0, 1, 2].map(axis);
        x.into_iter().zip(y).zip(z).map(|((x, y), z)| DVec3::new(x, y, z)).collect()
    }
}

fn square(x: f64) -> f64 {
    x * x
}
