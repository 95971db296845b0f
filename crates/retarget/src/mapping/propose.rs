//! Proposes a mapping from the landmarks of a clip and of a rig.

use sinew_mocap::Skeleton;
use sinew_rig::Mechanism;

use super::{Entry, Mapping, Performance, Point};
use crate::Landmark;
use crate::performer::PerformerJoints;
use crate::rig::RigMatch;
use crate::solve::Settings;

/// Confidence of a point that follows only from geometry.
const POINT: f64 = 0.5;

impl Mapping {
    /// Creates a mapping of the landmarks that the clip or the rig has. `of_clip` returns confidence (0 to 1) and
    /// reason for a landmark's joint in the clip.
    pub fn propose(
        names: [&str; 2],
        mechanism: &Mechanism,
        rig: &RigMatch,
        skeleton: &Skeleton,
        joints: &PerformerJoints,
        of_clip: impl Fn(Landmark) -> (f64, String),
    ) -> Self {
        let entry = |landmark: Landmark| {
            let clip = joints.joints[landmark].and_then(|joint| skeleton.joints.get(joint));
            let group = rig.group(landmark);
            // For a hand or a toe without a joint, the mapping contains the point, so that a person can check it.
            let point = rig.points[landmark].filter(|_| group.is_none());
            if clip.is_none() && group.is_none() && point.is_none() {
                return None;
            }
            let of_rig = group.map(|group| (group.confidence, group.reason.clone()));
            let of_rig =
                of_rig.or(point.map(|_| (POINT, "no joint: a point by geometry".to_owned())));
            let of_clip = clip.map(|_| of_clip(landmark));
            let confidence =
                of_rig.iter().chain(&of_clip).map(|(sure, _)| *sure).fold(1.0, f64::min);
            let says = |who: &str, found: Option<(f64, String)>| match found {
                Some((_, reason)) => format!("{who}: {reason}"),
                None => format!("{who}: nothing"),
            };
            let name = |joint: &usize| mechanism.bodies[*joint].joint_name.clone();
            Some(Entry {
                landmark,
                clip: clip.map(|joint| joint.name.clone()),
                rig: group.map_or_else(Vec::new, |group| group.joints.iter().map(name).collect()),
                point: point.map(|point| Point {
                    body: mechanism.bodies[point.body].name.clone(),
                    position_m: point.position_m.to_array().map(micrometres),
                }),
                confidence,
                reason: format!("{}. {}", says("rig", of_rig), says("clip", of_clip)),
            })
        };
        let [rig_name, clip_name] = names.map(str::to_owned);
        Self {
            rig: rig_name,
            clip: clip_name,
            performance: Performance { arms: Settings::of(rig).arms, ..Performance::default() },
            landmarks: Landmark::ALL.into_iter().filter_map(entry).collect(),
            curves: Vec::new(),
        }
    }
}

/// Rounds a length to whole micrometres, for a text that people read.
fn micrometres(x_m: f64) -> f64 {
    (x_m * 1e6).round() / 1e6
}
