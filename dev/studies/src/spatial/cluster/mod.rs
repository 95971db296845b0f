//! Separates walking from running by clusters of the poses of one sequence of each (section 4 of the paper).

mod report;

use std::ops::Range;

use rayon::prelude::*;
use serde::Serialize;
use sinew_host_util::random::{Random, Subject};
use sinew_pose_metrics::spatial::{Distances, Measure, MeasuredPose, RigMeasure, SpatialRig, Workspace};

pub use report::{json, tables};
pub(crate) use report::{over_pairs, paper};

use super::classes::{ClassesError, TwoClasses};
use super::medoid_shift;

/// Settings of the study.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    /// The two classes.
    pub classes: &'a TwoClasses,
    /// The rig for the poses.
    pub rig: &'a SpatialRig,
    /// The distances to compare; differences are relative to the first.
    pub measures: Vec<Measure>,
    /// Number of pairs of sequences to draw.
    pub pairs: usize,
    /// Seed of the draws.
    pub seed: u64,
}

/// Two clusters of the poses of a pair of sequences.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Clustering {
    /// The smallest bandwidth of the kernel that makes two clusters, in the measure's unit.
    pub bandwidth: f64,
    /// The cluster of every pose, 0 or 1; poses of the first sequence are first.
    pub of: Vec<usize>,
}

/// Shares of a pair's poses that are in the cluster of their sequence, for the better assignment of clusters to
/// sequences.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rates {
    /// Share of all poses.
    pub poses: f64,
    /// The mean of the shares of both sequences' poses.
    pub balanced: f64,
}

/// Choice of the sequences of a pair, and of their parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Pairing {
    /// One sequence of each class, whole.
    Whole,
    /// The pairs of `Whole`, with the longer sequence cut to the length of the shorter one, around its middle.
    Cut,
    /// One sequence of each class, both of one group, cut.
    OneGroup,
    /// Two sequences of the first class, of two groups, cut: they do not differ in class.
    OneClass,
}

impl Pairing {
    /// All pairings.
    pub const ALL: [Self; 4] = [Self::Whole, Self::Cut, Self::OneGroup, Self::OneClass];
}

/// A pair of sequences.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// Indices of the sequences.
    pub sequences: [usize; 2],
    /// Ranges of their poses.
    pub poses: [Range<usize>; 2],
}

/// Results of one measure.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Measure of the distances.
    pub measure: Measure,
    /// Kind of the pairs.
    pub pairing: Pairing,
    /// Clusterings by pair; `None` if no bandwidth makes two clusters.
    pub clusterings: Vec<Option<Clustering>>,
    /// Rates by pair; without two clusters, those of a single cluster.
    pub rates: Vec<Rates>,
    /// Rates by pair for random clusters of the same sizes.
    pub by_chance: Vec<Rates>,
}

/// Results of all measures.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// The pairs of every pairing that has any.
    pub pairs: Vec<(Pairing, Vec<Pair>)>,
    /// Outcomes by measure, then by pairing.
    pub outcomes: Vec<Outcome>,
}

impl Study {
    /// Returns the results of a measure.
    pub fn of(&self, measure: Measure, pairing: Pairing) -> Option<&Outcome> {
        self.outcomes.iter().find(|o| o.measure == measure && o.pairing == pairing)
    }
}

impl Pair {
    fn new(classes: &TwoClasses, sequences: [usize; 2], pairing: Pairing) -> Self {
        let lengths = sequences.map(|own| classes.sequences[own].frames.len());
        let shorter = lengths[0].min(lengths[1]);
        let poses = lengths.map(|length| {
            let count = if pairing == Pairing::Whole { length } else { shorter };
            let first = (length - count) / 2;
            first..first + count
        });
        Self { sequences, poses }
    }

    /// Returns the number of poses of each sequence.
    pub fn lengths(&self) -> [usize; 2] {
        self.poses.each_ref().map(ExactSizeIterator::len)
    }

    /// Returns a clustering with all poses in one cluster.
    pub fn in_one(&self) -> Vec<usize> {
        vec![0; self.lengths().iter().sum()]
    }
}

/// Draws pairs of sequences, and makes two clusters of the poses of each pair by every measure; `progress` is called
/// with numbers of pairs.
///
/// # Errors
/// [`ClassesError`] if there is no sequence of a class, or a pose cannot be compared.
pub fn run(plan: &Plan<'_>, progress: &(dyn Fn(usize) + Sync)) -> Result<Study, ClassesError> {
    plan.classes.expect(1)?;
    let drawn = Pairing::ALL.map(|pairing| (pairing, draw(plan, pairing)));
    let pairs: Vec<_> = drawn.into_iter().filter(|(_, pairs)| !pairs.is_empty()).collect();
    let mut outcomes = Vec::new();
    for measure in &plan.measures {
        let measuring = RigMeasure::new(plan.rig, *measure);
        let poses = plan.classes.measured(&measuring)?;
        for (pairing, pairs) in &pairs {
            let found = |pair: &Pair| {
                let clustering = cluster(&measuring, &poses, pair);
                progress(1);
                clustering
            };
            let clusterings: Vec<Option<Clustering>> = pairs.par_iter().map(found).collect();
            let (mut of_found, mut by_chance) = (Vec::new(), Vec::new());
            for (number, (pair, clustering)) in pairs.iter().zip(&clusterings).enumerate() {
                let mut of = clustering.as_ref().map_or_else(|| pair.in_one(), |c| c.of.clone());
                of_found.push(rates(&of, pair));
                Random::numbered(plan.seed, number as u64, Subject::Chance).shuffle(&mut of);
                by_chance.push(rates(&of, pair));
            }
            outcomes.push(Outcome {
                measure: *measure,
                pairing: *pairing,
                clusterings,
                rates: of_found,
                by_chance,
            });
        }
    }
    Ok(Study { pairs, outcomes })
}

/// Draws pairs, each with equal probability. A larger number of pairs does not change the earlier ones. Empty if
/// there are no pairs.
fn draw(plan: &Plan<'_>, pairing: Pairing) -> Vec<Pair> {
    let classes = plan.classes;
    let [first, second] = [0, 1].map(|class| classes.members(class));
    let others = if pairing == Pairing::OneClass { &first } else { &second };
    let group = |own: usize| &classes.sequences[own].group;
    let all: Vec<[usize; 2]> = first
        .iter()
        .flat_map(|own| others.iter().map(move |other| [*own, *other]))
        .filter(|[own, other]| match pairing {
            Pairing::Whole | Pairing::Cut => true,
            Pairing::OneGroup => group(*own) == group(*other),
            Pairing::OneClass => own < other && group(*own) != group(*other),
        })
        .collect();
    let pair = |number: usize| {
        let mut random = Random::numbered(plan.seed, number as u64, Subject::Draws);
        Pair::new(classes, all[random.below(all.len())], pairing)
    };
    let count = if all.is_empty() { 0 } else { plan.pairs };
    (0..count).map(pair).collect()
}

/// Makes two clusters of the poses of a pair.
fn cluster(
    measuring: &RigMeasure<'_>,
    poses: &[Vec<MeasuredPose>],
    pair: &Pair,
) -> Option<Clustering> {
    let both = pair.sequences.iter().zip(&pair.poses);
    let poses: Vec<&MeasuredPose> =
        both.flat_map(|(own, some)| &poses[*own][some.clone()]).collect();
    let distance = |workspace: &mut Workspace, a: usize, b: usize| {
        measuring.distance(poses[a], poses[b], workspace)
    };
    let distances = Distances::new(poses.len(), Workspace::new, distance, |_| ());
    let (bandwidth, of) = medoid_shift::with_clusters(&distances, 2).next()?;
    Some(Clustering { bandwidth, of })
}

/// Returns how well clusters of a pair's poses fit its sequences.
pub(crate) fn rates(of: &[usize], pair: &Pair) -> Rates {
    let [first, second] = pair.lengths();
    let (of_first, of_second) = of.split_at(first);
    let share = |of: &[usize]| of.iter().filter(|own| **own == 0).count() as f64 / of.len() as f64;
    // These shares assume that the first sequence is cluster 0. If it is cluster 1, each share `s` is `1 - s`.
    let (right, other_right) = (share(of_first), 1.0 - share(of_second));
    let [count, other_count] = [first, second].map(|count| count as f64);
    let poses = (right * count + other_right * other_count) / (count + other_count);
    let balanced = 0.5 * (right + other_right);
    Rates { poses: poses.max(1.0 - poses), balanced: balanced.max(1.0 - balanced) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recordings::Recordings;

    #[test]
    fn clusters_are_called_by_the_class_that_they_fit() {
        let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
        let pair = |lengths: [usize; 2]| Pair { sequences: [0, 1], poses: lengths.map(|n| 0..n) };
        for flip in [0, 1] {
            let of: Vec<usize> = [0, 0, 0, 1, 1, 1].map(|cluster| cluster ^ flip).into();
            let some = rates(&of, &pair([4, 2]));
            assert!(close(some.poses, 5.0 / 6.0) && close(some.balanced, 0.875), "{some:?}");
        }
        let one = rates(&[0; 10], &pair([8, 2]));
        assert!(close(one.poses, 0.8) && close(one.balanced, 0.5), "{one:?}");
    }

    #[test]
    fn any_number_of_threads_gives_the_same_clusters() {
        let mut classes = TwoClasses::of(&Recordings::built_in()).unwrap();
        for sequence in &mut classes.sequences {
            sequence.frames.truncate(25);
        }
        let rig = SpatialRig::new(&classes.skeleton, None).unwrap();
        let measures = Measure::all().collect();
        let plan = Plan { classes: &classes, rig: &rig, measures, pairs: 3, seed: 1 };
        let [one, three] = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| run(&plan, &|_| ())).unwrap()
        });
        assert_eq!(one, three);
        for outcome in &one.outcomes {
            let found = || outcome.clusterings.iter().flatten();
            assert!(found().all(|c| c.of.contains(&0) && c.of.contains(&1)));
        }
    }

    #[test]
    fn pairs_are_what_they_are_called() {
        let mut classes = TwoClasses::of(&Recordings::built_in()).unwrap();
        let rig = SpatialRig::new(&classes.skeleton, None).unwrap();
        let mut plan = Plan { classes: &classes, rig: &rig, measures: vec![], pairs: 20, seed: 1 };
        assert!(draw(&plan, Pairing::OneGroup).is_empty(), "every clip is a group");
        let mut joined = classes.clone();
        for (number, sequence) in joined.sequences.iter_mut().enumerate() {
            sequence.group = (number % 3).to_string();
        }
        plan.classes = &joined;
        let of = |index: usize| (joined.sequences[index].class, &joined.sequences[index].group);
        for pairing in Pairing::ALL {
            let pairs = draw(&plan, pairing);
            assert_eq!(pairs.len(), 20);
            for pair in pairs {
                let [(class, group), (other_class, other_group)] = pair.sequences.map(of);
                assert_eq!(class == other_class, pairing == Pairing::OneClass);
                assert!(pairing != Pairing::OneGroup || group == other_group);
                assert!(pairing != Pairing::OneClass || group != other_group);
                let [length, other_length] = pair.lengths();
                assert!(pairing == Pairing::Whole || length == other_length);
            }
        }
        classes.sequences.truncate(1);
        assert!(classes.expect(1).is_err());
    }
}
