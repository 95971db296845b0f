//! How near a motion on a rig is to its performer, and which changes of the rig would bring it nearer.

use std::fmt::Write as _;

use sinew_retarget::feasibility::{Excess, Kind, Limits, Report, RigMotion};

use super::text;

/// Limits beyond which a motion no longer looks like the performer's: largest mean angle between limbs, deg; largest
/// mean distance of a hand, as a share of the arm; smallest share of the joints' way.
const STRANGE_DEG: f64 = 30.0;
const STRANGE_SHARE: f64 = 0.25;
const STRANGE_WAY: f64 = 0.5;

/// How near a motion on a rig is to its performer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Likeness {
    /// Mean and largest angle between the limbs of rig and performer, deg; `None` if no limb is followed.
    pub limbs_deg: Option<[f64; 2]>,
    /// Mean and largest distance of a hand from the performer's, scaled to the rig, as shares of the arm; `None` if no
    /// hand's path is followed.
    pub hands: Option<[f64; 2]>,
    /// Way of all joints in the motion, as a share of their way before a fit.
    pub way: f64,
}

impl Likeness {
    /// Returns a line about the limbs or the hands; an empty text if the rig follows neither.
    pub fn line(&self, limbs: usize) -> String {
        let mut out = String::new();
        if let Some([mean, most]) = self.hands {
            let [mean, most] = [mean, most].map(|share| 100.0 * share);
            let _ = writeln!(
                out,
                "hand: {mean:.1} % of the arm's length off the performer's path in the mean, {most:.1} % at most"
            );
        }
        if let Some([mean, most]) = self.limbs_deg {
            let _ = writeln!(
                out,
                "{limbs} limbs: {mean:.1} deg from the performer's on average, {most:.1} at most"
            );
        }
        out
    }

    /// Returns the reason why the motion no longer looks like the performer's; `None` if it does.
    pub fn strange(&self) -> Option<String> {
        let mut why = Vec::new();
        match (self.hands, self.limbs_deg) {
            (Some([mean, _]), _) if mean > STRANGE_SHARE => {
                why.push(format!(
                    "the hand is {:.0} % of the arm's length off its path",
                    100.0 * mean
                ));
            }
            (None, Some([mean, _])) if mean > STRANGE_DEG => {
                why.push(format!("the limbs are {mean:.0} deg off the performer's"));
            }
            _ => {}
        }
        if self.way < STRANGE_WAY {
            why.push(format!("{:.0} % of the way is left", 100.0 * self.way));
        }
        (!why.is_empty()).then(|| why.join(", "))
    }
}

/// Returns the sum of the ways of all joints in a motion, as a share of that in another motion, at most 1.
pub(super) fn way_share(motion: &RigMotion, given: &RigMotion) -> f64 {
    let way = |motion: &RigMotion| -> f64 {
        let step = |pair: &[Vec<f64>]| -> f64 {
            pair[0].iter().zip(&pair[1]).map(|(from, to)| (to - from).abs()).sum()
        };
        motion.rows.windows(2).map(step).sum()
    };
    let all = way(given);
    if all > 0.0 { (way(motion) / all).min(1.0) } else { 1.0 }
}

/// Describes which changes of the rig would preserve more of a motion. `given`: how the motion exceeds the limits
/// before a fit. There is a line for each kind of limit, with the joint that exceeds it most.
pub(super) fn helps(limits: &Limits, given: &Report) -> Vec<String> {
    let need = |excess: &Excess| (excess.value / excess.limit).abs();
    let worst = |kind: Kind| {
        let of_kind = given.excesses.iter().filter(|excess| excess.kind == kind);
        of_kind.max_by(|a, b| match kind {
            Kind::Range | Kind::LinkedRange => {
                (a.value - a.limit).abs().total_cmp(&(b.value - b.limit).abs())
            }
            _ => need(a).total_cmp(&need(b)),
        })
    };
    let kinds = [
        (Kind::Range, "a wider range"),
        (Kind::LinkedRange, "a wider linked range"),
        (Kind::Speed, "a faster servo or less gear"),
        (Kind::Acceleration, "a larger acceleration in rig.toml"),
        (Kind::Effort, "a stronger servo, a gear, a spring, or less weight beyond it"),
        (Kind::Heat, "a stronger servo, or less weight beyond it"),
    ];
    let line = |(kind, help): (Kind, &str)| {
        let excess = worst(kind)?;
        let dof = &limits.dofs[excess.dof];
        let told = text::excess(dof.slides, excess, [0.0; 2]);
        Some(format!("{}: the clip asks for {} {told}: {help}", dof.name, kind.name()))
    };
    kinds.into_iter().filter_map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_that_is_nobodys_says_why() {
        let near = Likeness { limbs_deg: Some([6.0, 40.0]), hands: None, way: 0.9 };
        assert_eq!(near.strange(), None);
        let far = Likeness { limbs_deg: Some([41.2, 90.0]), way: 0.2, ..near };
        assert_eq!(
            far.strange().unwrap(),
            "the limbs are 41 deg off the performer's, 20 % of the way is left"
        );
        // The path of a small arm's hand is what counts, not the directions of its limbs.
        let arm = Likeness { limbs_deg: Some([41.2, 90.0]), hands: Some([0.02, 0.1]), way: 0.9 };
        assert_eq!(arm.strange(), None);
        let off = Likeness { hands: Some([0.3, 0.9]), ..arm };
        assert_eq!(off.strange().unwrap(), "the hand is 30 % of the arm's length off its path");
    }

    #[test]
    fn the_way_that_is_left_is_a_share() {
        let motion = |scale: f64| RigMotion {
            dt_s: 0.01,
            rows: (0..100).map(|row| vec![scale * (f64::from(row) * 0.1).sin(), 0.0]).collect(),
        };
        assert!((way_share(&motion(0.2), &motion(1.0)) - 0.2).abs() < 1e-9);
        assert!((way_share(&motion(0.0), &motion(0.0)) - 1.0).abs() < 1e-9);
    }
}
