//! Classifies walking and running by the nearest pose of other sequences (section 4 of the paper).

mod nearest;
mod report;

use serde::Serialize;
use sinew_host_util::random::{Random, Subject};
use sinew_pose_metrics::spatial::{Measure, RigMeasure, SpatialRig};

pub use nearest::Nearest;
pub(crate) use report::paper;
pub use report::{json, tables};

use super::classes::{ClassesError, Labelled, TwoClasses};

/// Settings of the study.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    /// The two classes.
    pub classes: &'a TwoClasses,
    /// The rig for the poses.
    pub rig: &'a SpatialRig,
    /// The distances to compare; differences are relative to the first.
    pub measures: Vec<Measure>,
    /// Sequences of each class in a draw.
    pub each: usize,
    /// Number of draws.
    pub draws: usize,
    /// Seed of the draws.
    pub seed: u64,
}

/// Poses that do not count as neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LeaveOut {
    /// Poses of the same sequence.
    Sequence,
    /// Poses of the same group, such as the same person.
    Group,
}

impl LeaveOut {
    /// Both choices, in the order of tables.
    pub const ALL: [Self; 2] = [Self::Sequence, Self::Group];
}

/// Shares of a draw that were classified correctly.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rates {
    /// Share of all poses.
    pub poses: f64,
    /// Share of the poses of each class.
    pub of_class: [f64; 2],
    /// Share of sequences, each classified by the majority of its poses.
    pub sequences: f64,
}

/// Number of correctly classified poses of a sequence, over all its draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Tally {
    /// Number of classified poses.
    pub poses: usize,
    /// Number of correctly classified poses.
    pub right: usize,
}

impl Tally {
    /// Returns the share of correct poses; `None` without poses.
    pub fn rate(&self) -> Option<f64> {
        (self.poses > 0).then(|| self.right as f64 / self.poses as f64)
    }
}

impl std::iter::Sum for Tally {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |a, b| Self {
            poses: a.poses + b.poses,
            right: a.right + b.right,
        })
    }
}

/// Results of one measure.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Measure of the distances.
    pub measure: Measure,
    /// Poses that did not count as neighbours.
    pub leave: LeaveOut,
    /// Rates by draw.
    pub draws: Vec<Rates>,
    /// Tallies by sequence.
    pub sequences: Vec<Tally>,
}

/// Results of all measures.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// The sequences of each draw.
    pub draws: Vec<Vec<usize>>,
    /// Outcomes by measure, then by the poses that are left out.
    pub outcomes: Vec<Outcome>,
}

impl Study {
    /// Returns the results of a measure.
    pub fn of(&self, measure: Measure, leave: LeaveOut) -> Option<&Outcome> {
        self.outcomes.iter().find(|o| o.measure == measure && o.leave == leave)
    }
}

impl Plan<'_> {
    /// Returns the number of pairs of poses to compare.
    pub fn steps(&self) -> usize {
        let lengths = || self.classes.sequences.iter().map(|sequence| sequence.frames.len());
        let (all, own): (usize, usize) = (lengths().sum(), lengths().map(|n| n * n).sum());
        self.measures.len() * (all * all - own) / 2
    }
}

/// Draws sequences of both classes repeatedly, and classifies every pose by its nearest neighbour in the other
/// sequences of the draw; `progress` is called with numbers of pairs of poses.
///
/// # Errors
/// [`ClassesError`] if there are too few sequences, or a pose cannot be compared.
pub fn run(plan: &Plan<'_>, progress: &(dyn Fn(usize) + Sync)) -> Result<Study, ClassesError> {
    plan.classes.expect(plan.each)?;
    let draws: Vec<Vec<usize>> = (0..plan.draws as u64).map(|number| draw(plan, number)).collect();
    let mut outcomes = Vec::new();
    for measure in &plan.measures {
        let measuring = RigMeasure::new(plan.rig, *measure);
        let nearest = Nearest::new(&measuring, &plan.classes.measured(&measuring)?, progress);
        for leave in LeaveOut::ALL {
            let mut sequences = vec![Tally::default(); plan.classes.sequences.len()];
            let told = draws.iter().map(|draw| {
                let right = tell(plan.classes, &nearest, draw, leave);
                for (sequence, tally) in draw.iter().zip(&right) {
                    sequences[*sequence] = [sequences[*sequence], *tally].into_iter().sum();
                }
                rates(plan.classes, draw, &right)
            });
            let draws = told.collect();
            outcomes.push(Outcome { measure: *measure, leave, draws, sequences });
        }
    }
    Ok(Study { draws, outcomes })
}

/// Returns the sequences of a draw, in their order.
fn draw(plan: &Plan<'_>, number: u64) -> Vec<usize> {
    let mut random = Random::numbered(plan.seed, number, Subject::Draws);
    let mut drawn = Vec::with_capacity(2 * plan.each);
    for class in [0, 1] {
        let mut members = plan.classes.members(class);
        random.shuffle(&mut members);
        drawn.extend_from_slice(&members[..plan.each]);
    }
    drawn.sort_unstable();
    drawn
}

/// Counts the poses of each sequence of a draw whose nearest neighbour has their class. A pose without a neighbour is
/// not classified correctly.
fn tell(classes: &TwoClasses, nearest: &Nearest, draw: &[usize], leave: LeaveOut) -> Vec<Tally> {
    let of_sequence = |own: &usize| {
        let Labelled { class, group, frames, .. } = &classes.sequences[*own];
        let others: Vec<usize> = draw
            .iter()
            .copied()
            .filter(|other| match leave {
                LeaveOut::Sequence => other != own,
                LeaveOut::Group => classes.sequences[*other].group != *group,
            })
            .collect();
        let is_right = |pose: &usize| {
            let distances = nearest.of(*own, *pose);
            let next = others.iter().min_by(|a, b| distances[**a].total_cmp(&distances[**b]));
            next.is_some_and(|next| classes.sequences[*next].class == *class)
        };
        Tally { poses: frames.len(), right: (0..frames.len()).filter(is_right).count() }
    };
    draw.iter().map(of_sequence).collect()
}

fn rates(classes: &TwoClasses, draw: &[usize], right: &[Tally]) -> Rates {
    let rate = |tally: Tally| tally.rate().unwrap_or(0.0);
    let of_class = |class: usize| {
        let own = draw.iter().zip(right).filter(|(own, _)| classes.sequences[**own].class == class);
        rate(own.map(|(_, tally)| *tally).sum())
    };
    let by_most = right.iter().filter(|tally| 2 * tally.right > tally.poses).count();
    Rates {
        poses: rate(right.iter().copied().sum()),
        of_class: [of_class(0), of_class(1)],
        sequences: by_most as f64 / draw.len() as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recordings::Recordings;

    fn built_in() -> (TwoClasses, SpatialRig) {
        let mut classes = TwoClasses::of(&Recordings::built_in()).unwrap();
        for sequence in &mut classes.sequences {
            sequence.frames.truncate(25);
        }
        let rig = SpatialRig::new(&classes.skeleton, None).unwrap();
        (classes, rig)
    }

    fn plan<'a>(classes: &'a TwoClasses, rig: &'a SpatialRig) -> Plan<'a> {
        Plan { classes, rig, measures: Measure::all().collect(), each: 3, draws: 5, seed: 7 }
    }

    #[test]
    fn any_number_of_threads_gives_the_same_rates() {
        let (classes, rig) = built_in();
        let plan = plan(&classes, &rig);
        let [one, three] = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| run(&plan, &|_| ())).unwrap()
        });
        assert_eq!(one, three);
        let more = run(&Plan { draws: 6, ..plan }, &|_| ()).unwrap();
        assert_eq!(more.draws[..5], one.draws, "more draws do not change those before");
    }

    #[test]
    fn poses_have_the_class_of_what_they_are_copies_of() {
        let (mut classes, rig) = built_in();
        // All sequences of a class are equal, and in one group.
        for class in [0, 1] {
            let members = classes.members(class);
            let first = classes.sequences[members[0]].clone();
            for member in members {
                classes.sequences[member] = first.clone();
            }
        }
        let study = run(&plan(&classes, &rig), &|_| ()).unwrap();
        for outcome in &study.outcomes {
            // Without its group there is no other sequence of its class.
            let expected = if outcome.leave == LeaveOut::Sequence { 1.0 } else { 0.0 };
            let rates = Rates { poses: expected, of_class: [expected; 2], sequences: expected };
            assert_eq!(outcome.draws, vec![rates; 5], "{} {:?}", outcome.measure, outcome.leave);
        }
    }
}
