//! Finds the joints that form each body of the figure.

use sinew_mocap::Skeleton;
use sinew_mocap::skeleton_map::{BodyJoints, End};

use super::super::SkeletonMatch;
use super::super::body::Body;
use super::super::name::{Kind, Part};
use super::ends::Ends;
use super::error::FigureMappingError;
use super::note::Note;
use crate::skeleton::found::Found;
use crate::{Landmark, Side};

/// Factor on the confidence in a body whose bone has no length.
const NO_LENGTH: f64 = 0.6;

/// A proposed body.
pub(super) struct Proposed {
    pub part: BodyJoints,
    pub note: Note,
}

/// A skeleton that has all landmarks that the figure needs.
pub(super) struct Draft<'a> {
    body: Body<'a>,
    matched: &'a SkeletonMatch,
    /// The joint that carries legs and trunk: the pelvis, or the common parent of pelvis and spine (DAZ, MMD, 3ds
    /// Max).
    pelvis: usize,
    /// Joints of the spine from the pelvis (not included) to the chest.
    spine: Vec<usize>,
    /// The joint where the head begins: the neck, or the head itself.
    neck: usize,
}

impl<'a> Draft<'a> {
    pub(super) fn new(
        skeleton: &'a Skeleton,
        matched: &'a SkeletonMatch,
    ) -> Result<Self, FigureMappingError> {
        let optional = |landmark: Landmark| matches!(landmark, Landmark::Neck | Landmark::Toe(_));
        let missing: Vec<_> = matched
            .missing()
            .filter(|(landmark, _)| !optional(*landmark))
            .map(|(landmark, reason)| (landmark, reason.to_owned()))
            .collect();
        let at = |landmark| matched.joint(landmark);
        let (Some(pelvis), Some(chest), Some(head)) =
            (at(Landmark::Pelvis), at(Landmark::Chest), at(Landmark::Head))
        else {
            return Err(FigureMappingError::Missing(missing));
        };
        if !missing.is_empty() {
            return Err(FigureMappingError::Missing(missing));
        }
        let body = Body::new(skeleton, &[]);
        let pelvis = body.common_ancestor(pelvis, chest);
        let mut spine = body.way(pelvis, chest);
        spine.retain(|joint| body.names[*joint].kind != Kind::Helper);
        Ok(Self { pelvis, spine, neck: at(Landmark::Neck).unwrap_or(head), body, matched })
    }

    /// Returns the joint of a landmark that [`new`](Self::new) has found.
    fn joint(&self, landmark: Landmark) -> usize {
        self.matched.joint(landmark).unwrap_or(0)
    }

    /// Returns pelvis, abdomen, thorax and head.
    pub(super) fn trunk(&self) -> Vec<Proposed> {
        let pelvis = self.pelvis;
        let (abdomen, thorax) = self.spine.split_at(self.spine.len() / 2);
        let thorax_origin = thorax.first().copied().unwrap_or(pelvis);
        let abdomen_origin = abdomen.first().copied().unwrap_or(pelvis);
        let away = self.spine.iter().find(|joint| !self.at_one_place(pelvis, **joint));
        let pelvis_end = away.copied().unwrap_or(self.neck);
        let abdomen_end = if thorax.is_empty() { self.neck } else { thorax_origin };
        let head = self.joint(Landmark::Head);
        let (head_end, head_remark) = Ends::new(&self.body, self.matched.height()).head(head);
        let spine = self.names(&self.spine);
        let split = match (abdomen, thorax) {
            ([], []) => Some(
                "no joint between pelvis and neck: one joint turns pelvis, abdomen and thorax"
                    .to_owned(),
            ),
            ([], [_]) => Some(
                "one joint between pelvis and neck: the abdomen turns as the pelvis does"
                    .to_owned(),
            ),
            ([_], [_]) => None,
            _ => Some(format!("the spine {spine} is shared by abdomen and thorax")),
        };
        let origin_landmark = if self.neck == head { Landmark::Head } else { Landmark::Neck };
        vec![
            self.proposed(
                "pelvis",
                pelvis,
                pelvis,
                End::Joint(self.name(pelvis_end)),
                &[Landmark::Pelvis],
                None,
            ),
            self.proposed(
                "abdomen",
                abdomen_origin,
                self.turner(abdomen, abdomen_end).unwrap_or(pelvis),
                End::Joint(self.name(abdomen_end)),
                &[Landmark::Pelvis, Landmark::Chest],
                split.clone(),
            ),
            self.proposed(
                "thorax",
                thorax_origin,
                self.turner(thorax, self.neck).unwrap_or(thorax_origin),
                End::Joint(self.name(self.neck)),
                &[Landmark::Chest],
                None,
            ),
            self.proposed(
                "head",
                self.neck,
                head,
                head_end,
                &[origin_landmark, Landmark::Head],
                head_remark,
            ),
        ]
    }

    /// Returns clavicle, upper arm, forearm and hand.
    pub(super) fn arm(&self, side: Side) -> Vec<Proposed> {
        let landmarks = [Landmark::Shoulder(side), Landmark::Elbow(side), Landmark::Wrist(side)];
        let [shoulder, elbow, wrist] = landmarks.map(|landmark| self.joint(landmark));
        let (clavicle, rotation, remark) = self.clavicle(shoulder);
        let (end, end_remark) = Ends::new(&self.body, self.matched.height()).hand(elbow, wrist);
        vec![
            self.proposed(
                &named("clavicle", side),
                clavicle,
                rotation,
                self.at(shoulder),
                &[landmarks[0]],
                remark,
            ),
            self.bone(&named("upper_arm", side), shoulder, elbow, &landmarks[..2]),
            self.bone(&named("forearm", side), elbow, wrist, &landmarks[1..]),
            self.proposed(&named("hand", side), wrist, wrist, end, &landmarks[2..], end_remark),
        ]
    }

    /// Returns thigh, shank and foot.
    pub(super) fn leg(&self, side: Side) -> Vec<Proposed> {
        let landmarks = [Landmark::Hip(side), Landmark::Knee(side), Landmark::Ankle(side)];
        let [hip, knee, ankle] = landmarks.map(|landmark| self.joint(landmark));
        let toe = self.matched.joint(Landmark::Toe(side));
        let (end, remark) = Ends::new(&self.body, self.matched.height()).foot(ankle, toe);
        vec![
            self.bone(&named("thigh", side), hip, knee, &landmarks[..2]),
            self.bone(&named("shank", side), knee, ankle, &landmarks[1..]),
            self.proposed(&named("foot", side), ankle, ankle, end, &landmarks[2..], remark),
        ]
    }

    /// Returns the bone from one joint of a limb to the next; joints between them that only twist rotate its far
    /// end.
    fn bone(&self, name: &str, origin: usize, end: usize, landmarks: &[Landmark]) -> Proposed {
        let way = self.body.way(origin, end);
        let between: Vec<usize> =
            [origin].into_iter().chain(way[..way.len() - 1].iter().copied()).collect();
        let rotation = self.turner(&between, end).unwrap_or(origin);
        let remark = (rotation != origin)
            .then(|| format!("{} turn it, the last determines its frame", self.names(&between)));
        self.proposed(name, origin, rotation, self.at(end), landmarks, remark)
    }

    /// Returns the joint where a clavicle begins, the joint that rotates it, and a remark.
    fn clavicle(&self, shoulder: usize) -> (usize, usize, Option<String>) {
        let chest = self.joint(Landmark::Chest);
        let mut way = self.body.way(self.body.common_ancestor(chest, shoulder), shoulder);
        way.pop();
        way.retain(|joint| *joint != self.neck && self.body.names[*joint].kind != Kind::Helper);
        let called = |joint: &usize| self.body.names[*joint].says(Part::Clavicle) > 0.0;
        if let Some(first) = way.iter().position(called) {
            way.drain(..first);
        }
        if let (Some(origin), Some(rotation)) = (way.first(), self.turner(&way, shoulder)) {
            return (*origin, rotation, None);
        }
        let (_, thorax) = self.spine.split_at(self.spine.len() / 2);
        let rotation = self.turner(thorax, self.neck).unwrap_or(chest);
        let remark =
            "no clavicle joint: it begins at the neck and turns as the chest does".to_owned();
        (self.neck, rotation, Some(remark))
    }

    /// Returns the last of `joints` that is not at the place of `end`, and therefore moves `end` when it turns. `None`
    /// if all are at this place.
    fn turner(&self, joints: &[usize], end: usize) -> Option<usize> {
        joints.iter().rev().find(|joint| !self.at_one_place(**joint, end)).copied()
    }

    /// Returns whether two joints have the same position at rest.
    fn at_one_place(&self, a: usize, b: usize) -> bool {
        let rest = &self.body.poses[0];
        self.body.is_zero(rest.at(a).distance(rest.at(b)))
    }

    fn name(&self, joint: usize) -> String {
        self.body.name(joint).to_owned()
    }

    fn at(&self, joint: usize) -> End {
        End::Joint(self.name(joint))
    }

    fn names(&self, joints: &[usize]) -> String {
        joints
            .iter()
            .map(|joint| format!("`{}`", self.body.name(*joint)))
            .collect::<Vec<_>>()
            .join(", ")
    }

    fn proposed(
        &self,
        body: &str,
        origin: usize,
        rotation: usize,
        end: End,
        landmarks: &[Landmark],
        remark: Option<String>,
    ) -> Proposed {
        let found = landmarks.iter().filter_map(|landmark| self.matched.get(*landmark));
        let lowest = found.min_by(|a, b| a.confidence.total_cmp(&b.confidence));
        let (confidence, reason) = lowest
            .map_or((0.0, String::new()), |Found { confidence, reason, .. }| {
                (*confidence, reason.clone())
            });
        let end_joint = match &end {
            End::Joint(name) => self.body.skeleton.find(name),
            _ => None,
        };
        let (confidence, reason) = match end_joint {
            Some(joint) if self.at_one_place(origin, joint) => (
                confidence * NO_LENGTH,
                format!("from `{}` to `{}` it has no length", self.name(origin), self.name(joint)),
            ),
            _ => (confidence, reason),
        };
        let part = BodyJoints { origin: self.name(origin), rotation: self.name(rotation), end };
        Proposed {
            part,
            note: Note {
                body: body.to_owned(),
                confidence,
                reason,
                remarks: remark.into_iter().collect(),
            },
        }
    }
}

fn named(body: &str, side: Side) -> String {
    format!("{body}_{}", if side == Side::Left { 'l' } else { 'r' })
}
