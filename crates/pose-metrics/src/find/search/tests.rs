use glam::{DQuat, DVec3};
use proptest::prelude::*;
use sinew_host_util::random::{Random, Subject};
use sinew_mocap::{Skeleton, SkeletonJoint};

use super::*;
use crate::spatial::Measure;

/// Returns a trunk with two limbs.
fn skeleton() -> Skeleton {
    let joint = |name: &str, parent, x, y| SkeletonJoint {
        name: name.into(),
        parent,
        offset_m: DVec3::new(x, y, 0.0),
        end_sites_m: Vec::new(),
    };
    Skeleton {
        joints: vec![
            joint("hips", None, 0.0, 0.0),
            joint("chest", Some(0), 0.0, 0.4),
            joint("arm", Some(1), 0.2, 0.1),
            joint("hand", Some(2), 0.5, 0.0),
            joint("leg", Some(0), 0.1, -0.1),
            joint("foot", Some(4), 0.0, -0.8),
        ],
    }
}

/// Returns a random walk of rotations, which stands still at times to produce equal poses.
fn motion(random: &mut Random, frames: usize, turn: f64) -> Vec<Vec<DQuat>> {
    let mut pose: Vec<DQuat> = skeleton()
        .joints
        .iter()
        .map(|_| DQuat::from_scaled_axis(random.normal3() * turn))
        .collect();
    let mut motion = Vec::with_capacity(frames);
    for _ in 0..frames {
        motion.push(pose.clone());
        if random.unit() < 0.8 {
            for rotation in &mut pose {
                *rotation =
                    (*rotation * DQuat::from_scaled_axis(random.normal3() * 0.1)).normalize();
            }
        }
    }
    motion
}

fn subject() -> Subject {
    Subject::Sway
}

/// Returns the moments without the search's bounds: places in order of their distance, except those near a better
/// one.
fn told(search: &Search<'_>, limits: Limits) -> Vec<Moment> {
    let mut workspace = Workspace::new();
    let all: Vec<Moment> = search
        .places()
        .into_iter()
        .map(|place| {
            let squares = search.pairs(place).map(|(a, b)| {
                let distance = f64::from(search.measuring.distance(a, b, &mut workspace));
                distance * distance
            });
            let distance = libm::sqrt(squares.sum::<f64>() / search.query.len() as f64);
            Moment { clip: place.0, pose: place.1, distance }
        })
        .collect();
    let key = |moment: &Moment| (moment.distance.to_bits(), moment.clip, moment.pose);
    let mut moments: Vec<Moment> = all
        .iter()
        .filter(|moment| {
            !all.iter().any(|other| {
                other.clip == moment.clip
                    && other.pose.abs_diff(moment.pose) < limits.apart
                    && key(other) < key(moment)
            })
        })
        .filter(|moment| !search.closed[moment.clip].contains(&moment.pose))
        .copied()
        .collect();
    moments.sort_by_key(key);
    moments.truncate(limits.count);
    moments
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn the_search_finds_what_computing_all_finds(
        seed in any::<u64>(),
        lengths in prop::collection::vec(0_usize..70, 1..5),
        query_length in prop::sample::select(vec![1_usize, 1, 2, 9, 20]),
        limits in (1_usize..8, 0_usize..12).prop_map(|(count, apart)| Limits { count, apart }),
        measure in prop::sample::select(Measure::all().collect::<Vec<_>>()),
        turn in prop::sample::select(vec![0.02, 0.5, 2.0]),
        is_of_library in any::<bool>(),
        closed in (0_usize..30, 0_usize..20),
    ) {
        let rig = SpatialRig::new(&skeleton(), None).unwrap();
        let measuring = RigMeasure::new(&rig, measure);
        let mut random = Random::new(seed, subject());
        let motions: Vec<_> = lengths.iter().map(|frames| motion(&mut random, *frames, turn)).collect();
        let mut query = motion(&mut random, query_length, turn);
        if is_of_library && motions[0].len() >= query_length {
            query = motions[0][..query_length].to_vec();
        }
        let measured = |motion: &Vec<Vec<DQuat>>| -> Vec<MeasuredPose> {
            motion.iter().map(|pose| measuring.pose(pose).unwrap()).collect()
        };
        let clips: Vec<_> = motions.iter().map(measured).collect();
        let query = measured(&query);
        let search = Search::new(&rig, &measuring, &query, &clips);
        let search = search.without(clips.len() - 1, closed.0..closed.0 + closed.1);
        let found = search.nearest(limits, |_| ());
        let all = search.nearest_of_all(limits, |_| ());
        prop_assert_eq!(&found.moments, &all.moments);
        prop_assert_eq!(&all.moments, &told(&search, limits));
        prop_assert_eq!((all.work.computed, all.work.bounds), (all.work.all, 0));
        prop_assert_eq!(found.work.all, all.work.all);
        let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        prop_assert_eq!(found, one_thread.install(|| search.nearest(limits, |_| ())));
    }

    /// Checks that the margin of the bound is far above the rounding: a hundredth of it would be sufficient.
    #[test]
    fn lines_are_not_shorter_than_the_bound(seed in any::<u64>(), turn in -6.0..0.5, weighted in any::<bool>()) {
        let rig = SpatialRig::new(&skeleton(), None).unwrap();
        let line = Measure::new(Metric::Line);
        let measuring = RigMeasure::new(&rig, if weighted { line.weighted() } else { line });
        let search = Search::new(&rig, &measuring, &[], &[]);
        let mut random = Random::new(seed, subject());
        let a = motion(&mut random, 1, 1.5).swap_remove(0);
        let turn = 10.0_f64.powf(turn);
        let b: Vec<DQuat> =
            a.iter().map(|q| *q * DQuat::from_scaled_axis(random.normal3() * turn)).collect();
        let (a, b) = (measuring.pose(&a).unwrap(), measuring.pose(&b).unwrap());
        let way_m = f64::from(measuring.position_distance(&a, &b));
        let line_m = f64::from(measuring.distance(&a, &b, &mut Workspace::new()));
        let margin_m = 1e-5 * way_m + search.slack_m;
        prop_assert!(line_m - way_m > -0.1 * margin_m, "{line_m} {way_m} {margin_m}");
    }
}

#[test]
fn lines_far_away_are_spared() {
    let rig = SpatialRig::new(&skeleton(), None).unwrap();
    let measuring = RigMeasure::new(&rig, Measure::new(Metric::Line));
    let mut random = Random::new(1, subject());
    let motion = motion(&mut random, 2000, 0.5);
    let clips: Vec<Vec<_>> =
        vec![motion.iter().map(|pose| measuring.pose(pose).unwrap()).collect()];
    for length in [1, 12] {
        let query = &clips[0][1000..1000 + length];
        let search = Search::new(&rig, &measuring, query, &clips);
        let found = search.nearest(Limits { count: 5, apart: 6 }, |_| ());
        assert_eq!((found.moments[0].pose, found.moments.len()), (1000, 5));
        assert!(found.work.spared() > 0.5, "{:?}", found.work);
    }
}

/// Checks that geodesics are visited in the order of the straight-line distance, and that the nearest are still
/// found.
#[test]
fn geodesics_far_away_are_spared() {
    let rig = SpatialRig::new(&skeleton(), None).unwrap();
    let mut random = Random::new(2, subject());
    let motion = motion(&mut random, 200, 0.5);
    let of = |metric| {
        let measuring = RigMeasure::new(&rig, Measure::new(metric).weighted());
        let clips: Vec<Vec<_>> =
            vec![motion.iter().map(|pose| measuring.pose(pose).unwrap()).collect()];
        let search = Search::new(&rig, &measuring, &clips[0][100..102], &clips);
        let limits = Limits { count: 3, apart: 6 };
        (search.nearest(limits, |_| ()), search.nearest_of_all(limits, |_| ()))
    };
    let (found, all) = of(Metric::Geodesic);
    assert_eq!(found.moments, all.moments);
    assert!(found.work.computed > 0 && found.work.spared() > 0.5, "{:?}", found.work);
    // A line is never shorter than the geodesic, and in this test longer.
    let lines = of(Metric::Line).0.moments;
    for (geodesic, line) in found.moments.iter().zip(&lines).skip(1) {
        assert!(geodesic.distance < line.distance, "{geodesic:?} {line:?}");
    }
}
