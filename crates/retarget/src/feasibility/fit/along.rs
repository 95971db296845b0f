//! How slow a course must be along its way, without inverse dynamics in every round.
//!
//! Efforts at a place of the way are a quadratic of the pace there, and linear in how it changes (Bobrow, Dubowsky &
//! Gibson 1985): with q of the way s, pace p = ds/dt and its change c = dp/dt, the speed is q' p, the acceleration
//! q'' p² + q' c, and the effort a p² + b c + what holds the pose + friction. Three inverse dynamics give a, b and the
//! holding part of a place, once. This is a model, of the course between its rows: what it comes to is looked at anew.

use std::ops::Range;

use super::course::LimitTrace;
use super::scan::pace;
use crate::feasibility::curve::{Curve, Instant};
use crate::feasibility::efforts::{Block, Efforts};
use crate::feasibility::error::CheckError;
use crate::feasibility::limits::Limits;

/// How long before and after what was seen the way is looked at too, s: twice the time of braking, as far as a course
/// is slower beside a row.
const BESIDE_S: f64 = 0.5;
/// The longest part of a way that is looked at at once, s: of a long clip there is no more in memory.
const LONGEST_S: f64 = 20.0;
/// Rounds of slowing: what is left then is left to the next look.
const ROUNDS: usize = 60;

/// A dof's speed, acceleration and efforts at a place of the way.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// q' and q''.
    slope: f64,
    bend: f64,
    /// Of the effort: of p², of c, and what holds.
    squared: f64,
    changing: f64,
    held: f64,
}

/// The way of a motion, and what is looked at along it.
pub(super) struct Along<'a> {
    /// The motion as it was given.
    pub(super) curve: &'a Curve,
    pub(super) rate_hz: f64,
    pub(super) limits: &'a Limits,
    pub(super) efforts: &'a mut Efforts,
    /// Dofs that are looked at, and what may hold them: where more does, pace is no help.
    pub(super) dofs: &'a [(usize, f64)],
}

impl Along<'_> {
    /// Slows a course down until nothing is exceeded beside the rows where something was: those with a share below 1.
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

    /// Places of rows, so many in each.
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

    /// What share of its pace a course may have at a place, where that and its change are these.
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
