//! Finds the branch of poses in which a whole clip is solved best.
//!
//! A choice from the first frame alone may bring a limb to a place where it is later stuck at the end of a range.
//! If the limbs are far from the performer, the clip is also followed from later frames, forwards and backwards.

use super::performance::Performance;
use super::solver::Solver;

/// Time between tried frames, s.
const EVERY_S: f64 = 1.0 / 15.0;
/// Mean error of limbs from which other branches are tried, rad.
const FAR_RAD: f64 = 0.1;
/// Positions in the clip at which other branches begin, as shares of its length.
const BEGINNINGS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// Maximum error of another branch relative to the best so far, for it to be used.
const BETTER: f64 = 0.8;

impl Solver {
    /// Finds the pose of the first frame by posture alone, considering the whole clip, which has at least one
    /// frame.
    pub(super) fn find_branch(&mut self, performance: &Performance<'_>) -> Vec<f64> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small number of frames"
        )]
        let every = ((EVERY_S / performance.clip.frame_time_s).round() as usize).max(1);
        let count = performance.clip.frames.len();
        let tried: Vec<usize> = (0..count).step_by(every).collect();
        self.begin_at(performance, tried[0]);
        let mut first = self.state.q.clone();
        let mut least = self.follow_along(performance, tried[1..].iter(), f64::INFINITY);
        if least < FAR_RAD * tried.len() as f64 {
            return first;
        }
        for part in BEGINNINGS {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a place in the list"
            )]
            let middle = (part * (tried.len() - 1) as f64) as usize;
            self.begin_at(performance, tried[middle]);
            let begun = self.state.q.clone();
            let most = BETTER * least;
            let mut sum = self.follow_along(performance, tried[..middle].iter().rev(), most);
            let at_first = self.state.q.clone();
            self.state.q.copy_from_slice(&begun);
            self.model.place(&mut self.state);
            sum += self.follow_along(performance, tried[middle + 1..].iter(), most - sum);
            if sum < most {
                (least, first) = (sum, at_first);
            }
        }
        first
    }

    fn begin_at(&mut self, performance: &Performance<'_>, index: usize) {
        for frame in performance.frames_of([index].into_iter()) {
            self.aim(&frame);
        }
        self.find_first();
    }

    /// Follows the frames with one step each. Returns the sum of the limbs' mean errors, rad; stops as soon as the
    /// sum is at least `most`.
    fn follow_along<'f>(
        &mut self,
        performance: &Performance<'_>,
        indices: impl Iterator<Item = &'f usize>,
        most: f64,
    ) -> f64 {
        let mut sum = 0.0;
        for frame in performance.frames_of(indices.copied()) {
            if sum >= most {
                break;
            }
            self.aim(&frame);
            self.begin();
            self.sweep(None);
            let errors = self.errors();
            sum += errors.iter().sum::<f64>() / errors.len().max(1) as f64;
        }
        sum
    }

    /// Finds the pose of a first frame, whose targets are set, starting at a nearby pose. Speed is unlimited.
    pub(super) fn settle(&mut self, q: &[f64], sweeps: usize) {
        self.state.q.copy_from_slice(q);
        self.model.place(&mut self.state);
        for _ in 0..sweeps {
            self.begin();
            self.sweep(None);
        }
    }
}
