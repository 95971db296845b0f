//! Ends of head, hands and feet: from joints and end sites of the file, or from a human's proportions.

use sinew_mocap::skeleton_map::End;

use super::super::body::Body;
use super::super::name::Kind;
use super::super::unit::SKULL;
use super::super::vocabulary::Word;

/// Length of a hand relative to the forearm (Drillis and Contini, in D. A. Winter, Biomechanics and Motor Control
/// of Human Movement, figure 4.1).
const HAND_BY_FOREARM: f64 = 0.74;
/// Accepted length of a file's hand relative to the forearm; a shorter one is a stub.
const HAND_SHOWN: std::ops::RangeInclusive<f64> = 0.25..=1.3;
/// Minimum length, relative to the forearm, of a hand whose first bone has zero length. A shorter one lacks its palm.
const HAND_WITH_PALM: f64 = 0.5;
/// Height of the ankle above the sole, relative to the shank (from the same figure: 0.039 and 0.246 of the
/// stature).
const SOLE_BY_SHANK: f64 = 0.16;
/// Minimum distance from the head's joint to its top, relative to the height; a shorter one is a stub.
const HEAD_SHOWN: f64 = 0.04;

/// Finds the ends of a skeleton's segments.
pub(super) struct Ends<'a> {
    body: &'a Body<'a>,
    /// Height of the body, in the skeleton's unit.
    height: f64,
}

/// An end, with a remark if it is not in the file.
type Told = (End, Option<String>);

impl<'a> Ends<'a> {
    pub(super) fn new(body: &'a Body<'a>, height: f64) -> Self {
        Self { body, height }
    }

    /// Returns the top of the head.
    pub(super) fn head(&self, head: usize) -> Told {
        let long = |length: f64| length > HEAD_SHOWN * self.height;
        if long(self.body.site(head)) {
            return (self.site(head), None);
        }
        let mut ends = self.body.children[head]
            .iter()
            .filter(|child| self.body.names[**child].kind == Kind::End);
        if let Some(end) = ends.find(|end| long(self.body.lengths[**end])) {
            return (self.joint(*end), None);
        }
        // A head at the position of its parent has no direction: the previous bone has the direction of the neck.
        let bone =
            self.body.upwards(head).find(|joint| !self.body.is_at_parent(*joint)).unwrap_or(head);
        let ratio = rounded(SKULL * self.height / self.body.lengths[bone].max(f64::MIN_POSITIVE));
        let remark = "the file has no top of the head: 0.130 of the stature above the base of the skull (Drillis and \
                      Contini)";
        (End::Beyond { beyond: self.name(bone), ratio }, Some(remark.to_owned()))
    }

    /// Returns the tip of the middle finger.
    pub(super) fn hand(&self, elbow: usize, wrist: usize) -> Told {
        let forearm = self.body.length(elbow, wrist);
        let is_middle = |joint: usize| self.body.names[joint].rest.contains(&Word::Middle);
        let tip = self
            .tips(wrist)
            .into_iter()
            .filter(|(tip, length)| {
                let palm = self.body.way(wrist, *tip).first().copied();
                let has_palm = palm.is_none_or(|palm| !self.body.is_at_parent(palm));
                HAND_SHOWN.contains(&(length / forearm))
                    && (has_palm || length / forearm > HAND_WITH_PALM)
            })
            .max_by(|a, b| is_middle(a.0).cmp(&is_middle(b.0)).then(a.1.total_cmp(&b.1)));
        if let Some((tip, _)) = tip {
            return (self.tip(tip), None);
        }
        let remark = "the file shows no hand: 0.74 of the forearm (Drillis and Contini)";
        (End::Beyond { beyond: self.name(wrist), ratio: HAND_BY_FOREARM }, Some(remark.to_owned()))
    }

    /// Returns the tip of the foot.
    pub(super) fn foot(&self, ankle: usize, toe: Option<usize>) -> Told {
        let below = toe.unwrap_or(ankle);
        let tip = self.tips(below).into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
        match (tip, toe) {
            (Some((tip, _)), _) => (self.tip(tip), None),
            (None, Some(toe)) => (self.joint(toe), None),
            (None, None) => {
                let remark = "the file shows no foot: it ends at the sole below the ankle";
                (
                    End::Beyond { beyond: self.name(ankle), ratio: SOLE_BY_SHANK },
                    Some(remark.to_owned()),
                )
            }
        }
    }

    /// Returns the outermost joints beyond `joint` (itself if it has no child at a distance), each with the length
    /// of its path including the end site.
    fn tips(&self, joint: usize) -> Vec<(usize, f64)> {
        (joint..self.body.count())
            .filter(|tip| self.body.hangs_on(*tip, joint))
            .filter(|tip| {
                self.body.children[*tip].iter().all(|child| self.body.is_at_parent(*child))
            })
            .filter(|tip| self.body.names[*tip].kind != Kind::Helper)
            .map(|tip| (tip, self.body.length(joint, tip) + self.body.site(tip)))
            .filter(|(_, length)| !self.body.is_zero(*length))
            .collect()
    }

    fn tip(&self, tip: usize) -> End {
        if self.body.is_zero(self.body.site(tip)) { self.joint(tip) } else { self.site(tip) }
    }

    fn joint(&self, joint: usize) -> End {
        End::Joint(self.name(joint))
    }

    fn site(&self, joint: usize) -> End {
        End::Site { site: self.name(joint) }
    }

    fn name(&self, joint: usize) -> String {
        self.body.name(joint).to_owned()
    }
}

/// Rounds to two decimals: the proportions are not known more exactly.
fn rounded(ratio: f64) -> f64 {
    libm::round(100.0 * ratio) / 100.0
}
