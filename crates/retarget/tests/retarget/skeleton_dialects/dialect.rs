//! Small skeletons with the names of many makers, from `dialects.txt`.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use glam::DVec3;
use sinew_mocap::{Skeleton, SkeletonJoint};
use sinew_retarget::{Landmark, Side};

/// Positions of a human of 1.75 m in a T-pose, y up, z forward, for the middle and the left side, in metres.
const PLACES: [(&str, [f64; 3]); 33] = [
    ("floor", [0.0, 0.0, 0.0]),
    ("pelvis", [0.0, 0.98, 0.0]),
    ("spine", [0.0, 1.06, -0.01]),
    ("spine2", [0.0, 1.16, -0.01]),
    ("spine3", [0.0, 1.25, -0.01]),
    ("chest", [0.0, 1.32, -0.01]),
    ("neck", [0.0, 1.49, -0.01]),
    ("neck2", [0.0, 1.53, 0.0]),
    ("head", [0.0, 1.57, 0.01]),
    ("head_end", [0.0, 1.75, 0.01]),
    ("jaw", [0.0, 1.58, 0.05]),
    ("eye", [0.03, 1.63, 0.09]),
    ("breast", [0.08, 1.30, 0.1]),
    ("tail", [0.0, 0.98, -0.15]),
    ("buttock", [0.05, 0.96, 0.0]),
    ("clavicle", [0.03, 1.45, 0.0]),
    ("shoulder", [0.17, 1.44, -0.01]),
    ("upper_arm", [0.30, 1.44, -0.01]),
    ("elbow", [0.47, 1.44, -0.02]),
    ("forearm", [0.58, 1.44, -0.01]),
    ("wrist", [0.73, 1.44, 0.0]),
    ("thumb", [0.76, 1.43, 0.04]),
    ("palm", [0.77, 1.44, 0.0]),
    ("knuckle", [0.82, 1.44, 0.0]),
    ("finger", [0.86, 1.44, 0.0]),
    ("hand_end", [0.92, 1.44, 0.0]),
    ("hip", [0.09, 0.93, 0.0]),
    ("thigh", [0.095, 0.72, 0.01]),
    ("knee", [0.10, 0.51, 0.01]),
    ("shank", [0.10, 0.29, 0.0]),
    ("ankle", [0.10, 0.08, -0.02]),
    ("toe", [0.11, 0.02, 0.12]),
    ("toe_end", [0.11, 0.01, 0.2]),
];

/// Skeletons of the file.
pub(crate) static DIALECTS: LazyLock<Vec<Dialect>> = LazyLock::new(|| {
    let lines = include_str!("dialects.txt").lines().filter(|line| !line.starts_with('#'));
    let mut dialects = Vec::new();
    let mut sides = ["", ""];
    for line in lines.filter(|line| !line.is_empty()) {
        if let Some((maker, written)) =
            line.strip_prefix('[').and_then(|line| line.split_once("] "))
        {
            sides = written.split_once(' ').expect("left and right").into();
            dialects.push(Dialect::new(maker));
        } else {
            dialects.last_mut().expect("a maker before the first chain").add_chain(line, sides);
        }
    }
    dialects
});

/// A skeleton, and the expected joint of each landmark.
#[derive(Clone)]
pub(crate) struct Dialect {
    pub(crate) maker: &'static str,
    pub(crate) skeleton: Skeleton,
    pub(crate) expected: BTreeMap<Landmark, String>,
}

impl Dialect {
    fn new(maker: &'static str) -> Self {
        Self { maker, skeleton: Skeleton { joints: Vec::new() }, expected: BTreeMap::new() }
    }

    fn add_chain(&mut self, line: &str, [left, right]: [&str; 2]) {
        if line.contains('*') {
            for (side, written) in [(Side::Left, left), (Side::Right, right)] {
                self.add(&line.replace('*', written), Some(side));
            }
        } else {
            self.add(line, None);
        }
    }

    /// Adds a chain of the middle or of one side.
    fn add(&mut self, chain: &str, side: Option<Side>) {
        let mut parent = None;
        for joint in chain.split(" > ") {
            parent = Some(match joint.split_once('=') {
                None => self.skeleton.find(joint).expect(joint),
                Some((name, is)) => self.add_joint(name, is, side, parent),
            });
        }
    }

    fn add_joint(
        &mut self,
        name: &str,
        is: &str,
        side: Option<Side>,
        parent: Option<usize>,
    ) -> usize {
        let mut words = is.split('+');
        let place = words.next().expect("a place");
        let bare = place.trim_start_matches('!');
        let prefix = match side {
            Some(Side::Left) => "l_",
            Some(Side::Right) => "r_",
            None => "",
        };
        for landmark in (place != bare).then_some(bare).into_iter().chain(words) {
            let landmark = Landmark::named(&format!("{prefix}{landmark}")).expect(landmark);
            self.expected.insert(landmark, name.to_owned());
        }
        let place = PLACES.iter().find(|(name, _)| *name == bare).expect(bare);
        let mirror =
            if side == Some(Side::Right) { DVec3::new(-1.0, 1.0, 1.0) } else { DVec3::ONE };
        let parent_m = parent.map_or(DVec3::ZERO, |parent| {
            self.skeleton.joints[0].offset_m + self.skeleton.rest_positions_m()[parent]
        });
        self.skeleton.joints.push(SkeletonJoint {
            name: name.to_owned(),
            parent,
            offset_m: DVec3::from(place.1) * mirror - parent_m,
            end_sites_m: Vec::new(),
        });
        self.skeleton.joints.len() - 1
    }
}
