//! Walking or running, told by the nearest pose of other sequences (section 4 of the paper).

mod nearest;
mod report;

use serde::Serialize;
use sinew_host_util::random::{Random, Subject};
use sinew_pose_metrics::spatial::{Measure, RigMeasure, SpatialRig};

pub use nearest::Nearest;
pub(crate) use report::paper;
pub use report::{json, tables};

use super::classes::{ClassesError, Labelled, TwoClasses};

/// What to try.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    /// The classes.
    pub classes: &'a TwoClasses,
    /// How poses are seen.
    pub rig: &'a SpatialRig,
    /// The distances to compare; differences are against the first.
    pub measures: Vec<Measure>,
    /// Sequences of each class in a draw.
    pub each: usize,
    /// How often sequences are drawn.
    pub draws: usize,
    /// What they are drawn by.
    pub seed: u64,
}

/// Which poses are no neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LeaveOut {
    /// Those of the same sequence.
    Sequence,
    /// Those of the same group, such as of the same person.
    Group,
}

impl LeaveOut {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Sequence, Self::Group];
}

/// How much of a draw was classified correctly.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rates {
    /// Of all poses.
    pub poses: f64,
    /// Of the poses of each class.
    pub of_class: [f64; 2],
    /// Of sequences, each by the most of its poses.
    pub sequences: f64,
}

/// How many poses of a sequence were classified correctly, over all draws it was in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Tally {
    /// How many were classified.
    pub poses: usize,
    /// How many were classified correctly.
    pub right: usize,
}

impl Tally {
    /// The share of what was right; `None` of none.
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

/// What became of one measure.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The measure.
    pub measure: Measure,
    /// Which poses were no neighbours.
    pub leave: LeaveOut,
    /// By draw.
    pub draws: Vec<Rates>,
    /// By sequence.
    pub sequences: Vec<Tally>,
}

/// What became of all measures.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// The sequences of each draw.
    pub draws: Vec<Vec<usize>>,
    /// By measure, then by what is left out.
    pub outcomes: Vec<Outcome>,
}

impl Study {
    /// What became of a measure.
    pub fn of(&self, measure: Measure, leave: LeaveOut) -> Option<&Outcome> {
        self.outcomes.iter().find(|o| o.measure == measure && o.leave == leave)
    }
}

impl Plan<'_> {
    /// Pairs of poses to compare.
    pub fn steps(&self) -> usize {
        let lengths = || self.classes.sequences.iter().map(|sequence| sequence.frames.len());
        let (all, own): (usize, usize) = (lengths().sum(), lengths().map(|n| n * n).sum());
        self.measures.len() * (all * all - own) / 2
    }
}

/// Draws sequences of both classes again and again, and tells every pose's class by its nearest neighbour in the other
/// sequences of the draw; `progress` is called for pairs of poses.
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

/// The sequences of a draw, in their order.
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

/// How many poses of each sequence of a draw have a nearest neighbour of their class. What has none is not classified
/// correctly.
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
        // Every sequence is that of its class, and all of a class are of one group.
        for class in [0, 1] {
            let members = classes.members(class);
            let first = classes.sequences[members[0]].clone();
            for member in members {
                classes.sequences[member] = first.clone();
            }
        }
        let study = run(&plan(&classes, &rig), &|_| ()).unwrap();
        for outcome in &study.outcomes {
            // Without its group there is none of its class.
            let expected = if outcome.leave == LeaveOut::Sequence { 1.0 } else { 0.0 };
            let rates = Rates { poses: expected, of_class: [expected; 2], sequences: expected };
            assert_eq!(outcome.draws, vec![rates; 5], "{} {:?}", outcome.measure, outcome.leave);
        }
    }
}
