//! Plans the paths of hips and toes over a whole clip, so that standing feet do not slide: least squares over all
//! frames.
//!
//! Posture alone gives the toes' positions relative to the hips. First the hips' path is found that is near the
//! performer's and keeps standing toes in place; then, for each toe, the path that is near the sum of hips and
//! posture, and at rest while it stands. Weights change smoothly from frame to frame, and therefore paths do too: a
//! foot never jumps.

use glam::DVec3;

use super::banded::Banded;

/// Time constants with which the hips return to the performer's path, horizontally and in height, s.
const HIPS_S: [f64; 2] = [1.6, 0.3];
/// Weight of keeping a standing toe in place, relative to following the performer's velocity.
const STANDS: f64 = 50.0;
/// Time constant with which a standing toe moves the hips to its floor height, s.
const FLOOR_S: f64 = 0.1;
/// Time constants of a toe's path, s: `TOE_S` for the return to the posture's position, `REST_S` for the stop of a
/// standing toe.
const TOE_S: f64 = 0.08;
const REST_S: f64 = 0.004;
/// Time constant with which a standing toe moves to the floor's height, s.
const DOWN_S: f64 = 0.02;

/// Data of the frames of a clip.
pub(super) struct Frames<'a> {
    pub(super) frame_s: f64,
    /// Positions of the performer's hips, scaled to the rig, above the floor, m.
    pub(super) wanted_m: &'a [DVec3],
    /// For each foot, the toe relative to the hips by posture alone, m.
    pub(super) toes_m: &'a [Vec<DVec3>],
    /// For each foot, how certainly it stands in each frame, from 0 to 1.
    pub(super) contacts: &'a [Vec<f64>],
}

impl Frames<'_> {
    fn count(&self) -> usize {
        self.wanted_m.len()
    }

    /// Returns how certainly a foot stands from a frame to the next, from 0 to 1.
    fn stands(&self, foot: usize, frame: usize) -> f64 {
        self.contacts[foot][frame].min(self.contacts[foot][frame + 1])
    }

    /// Returns the hips' path, m.
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

    /// Returns how much higher the rig's hips are than the scaled performer's when its feet stand, because feet
    /// differ in thickness, m.
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
        // A performer who never stands is placed with the lowest toe on the floor.
        if weights > 0.0 { sum / weights } else { highest.max(-1e3) }
    }

    /// Returns the path of a foot's toe, m.
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
