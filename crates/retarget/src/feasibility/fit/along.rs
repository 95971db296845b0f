//! Computes how slow a motion must be along its path, without inverse dynamics in every round.
//!
//! Efforts at a place of the path are quadratic in the pace there, and linear in its change (Bobrow, Dubowsky &
//! Gibson 1985). With positions q(s) along the path s, pace p = ds/dt and its change c = dp/dt, the speed is q' p,
//! the acceleration is q'' p² + q' c, and the effort is a p² + b c + holding effort + friction. Three inverse
//! dynamics give a, b and the holding effort of a place, once. This is a model of the motion between its rows: its
//! result is checked again.

use std::ops::Range;

use super::course::LimitTrace;
use super::scan::pace;
use crate::feasibility::curve::{Curve, Instant};
use crate::feasibility::efforts::{Block, Efforts};
use crate::feasibility::error::CheckError;
use crate::feasibility::limits::Limits;

/// Time before and after an excess that is also sampled, s: twice the time of braking, for which a motion is also
/// slowed before and after a row.
const BESIDE_S: f64 = 0.5;
/// Longest part of a path that is processed at once, s, which limits the memory for a long clip.
const LONGEST_S: f64 = 20.0;
/// Maximum number of rounds of slowing; the next check finds the excesses that remain.
const ROUNDS: usize = 60;

/// Speed, acceleration and efforts of a dof at a place of the path.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// First and second derivatives q' and q''.
    slope: f64,
    bend: f64,
    /// Coefficients of p² and of c, and the holding effort.
    squared: f64,
    changing: f64,
    held: f64,
}

/// Path of a motion, with the limits and dofs to process along it.
pub(super) struct Along<'a> {
    /// The motion as given.
    pub(super) curve: &'a Curve,
    pub(super) rate_hz: f64,
    pub(super) limits: &'a Limits,
    pub(super) efforts: &'a mut Efforts,
    /// Dofs to process, and the maximum holding effort of each: above it, a slower pace does not help.
    pub(super) dofs: &'a [(usize, f64)],
}

impl Along<'_> {
    /// Slows a motion until no limit is exceeded near the rows that need it: those whose entry in `seen` is below
    /// 1.
    pub(super) fn slow_down(
        &mut self,
        course: &mut LimitTrace,
        seen: &[f64],
    ) -> Result<(), CheckError> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
        let rows_in = |seconds: f64| (seconds / self.curve.dt_s()).ceil() as usize;
        let (beside, longest) = (rows_in(BESIDE_S), rows_in(LONGEST_S));
        let (count, is_seen) = (seen.len(), |row: &usize| seen[*row] < 1.0);
        let mut from = 0;
        while let Some(first) = (from..count).find(is_seen) {
            let begin = first.saturating_sub(beside).max(from);
            let mut last = first;
            while let Some(next) = (last + 1..count.min(last + 1 + 2 * beside)).find(is_seen) {
                if next - begin > longest {
                    break;
                }
                last = next;
            }
            self.slow_down_rows(course, begin..(last + 1 + beside).min(count))?;
            from = last + 1;
        }
        Ok(())
    }

    fn slow_down_rows(
        &mut self,
        course: &mut LimitTrace,
        rows: Range<usize>,
    ) -> Result<(), CheckError> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
        let parts = (self.rate_hz * self.curve.dt_s()).round().max(1.0) as usize;
        let places = self.places(&rows, parts)?;
        let mut shares = vec![1.0; rows.len()];
        for _ in 0..ROUNDS {
            shares.fill(1.0);
            for (index, places) in places.chunks_exact(self.dofs.len()).enumerate() {
                let (row, part) = (index / parts, index % parts);
                let at = course.pace_at(rows.start + row, part as f64 / parts as f64);
                let share = self.share(places, at);
                for row in [row, row + usize::from(part > 0)] {
                    shares[row] = f64::min(shares[row], share);
                }
            }
            if shares.iter().all(|share| *share >= 1.0) {
                break;
            }
            course.slow_down(rows.start, &shares);
        }
        Ok(())
    }

    /// Computes the places of rows, `parts` for each row.
    fn places(&mut self, rows: &Range<usize>, parts: usize) -> Result<Vec<Place>, CheckError> {
        let count = (rows.len() - 1) * parts + 1;
        let mut places = Vec::with_capacity(count * self.dofs.len());
        let mut block = Block::default();
        let [mut changing, mut holding] = [Default::default(), Default::default()];
        let mut times_s = (0..count).map(|index| {
            let row = rows.start as f64 + index as f64 / parts as f64;
            row * self.curve.dt_s()
        });
        while block.next(self.curve, &mut times_s) {
            block.find_without_friction(self.efforts)?;
            block.holding(self.efforts, &mut holding)?;
            block.changing(self.efforts, &mut changing)?;
            for ((_, Instant { qd, qdd, .. }, moving), (changing, holding)) in
                block.each().zip(changing.iter().zip(&holding))
            {
                places.extend(self.dofs.iter().map(|(dof, _)| Place {
                    slope: qd[*dof],
                    bend: qdd[*dof],
                    squared: moving[*dof] - holding[*dof],
                    changing: changing[*dof] - holding[*dof],
                    held: holding[*dof],
                }));
            }
        }
        Ok(places)
    }

    /// Returns the share of its pace that the motion may have at a place, for a given pace and change of pace.
    fn share(&self, places: &[Place], [pace_now, change]: [f64; 2]) -> f64 {
        let squared = pace_now * pace_now;
        let of_dof = |((dof, most_held), place): (&(usize, f64), &Place)| {
            let speed = place.slope * pace_now;
            let held = place.held + self.efforts.dry_friction(*dof, speed);
            let effort = held
                + place.squared * squared
                + place.changing * change
                + self.efforts.viscous_friction(*dof, speed);
            let acceleration = place.bend * squared + place.slope * change;
            let efforts = (held.abs() <= *most_held).then_some([effort, held]);
            pace(&self.limits.dofs[*dof], [speed, acceleration], efforts)
        };
        self.dofs.iter().zip(places).map(of_dof).fold(1.0, f64::min)
    }
}
