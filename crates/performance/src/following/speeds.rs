//! Speeds that the servos of a rig cannot follow.

use sinew_retarget::feasibility::{Efforts, Instant};

use sinew_rig::mechanism::Link;
use sinew_rig::review::{Finding, Review, Severity};

use super::lag::{ServoLag, servo_lags};
use crate::play::{Options, RigParts};
use crate::rig::LoadedRig;
use crate::text;

/// A dof whose servos close their own loop, with the largest speed that they follow.
#[derive(Debug, Clone, PartialEq)]
pub struct FollowedSpeed {
    /// Name of the dof.
    pub joint: String,
    /// Whether the dof slides: units are m instead of rad.
    pub slides: bool,
    /// Largest speed that the servos follow for long under the largest gravity and friction, rad/s. With a larger
    /// speed, the following error grows until the supervisor ends the show. 0 if they do not even carry the load.
    pub most: f64,
    /// Speed limit of the dof, rad/s; `None` without limit.
    pub limit: Option<f64>,
    /// Following error that ends a show, rad.
    pub error: f64,
    /// Whether the error is larger at rest in the home pose.
    pub sags_at_home: bool,
    /// Whether the error is larger at rest in the pose with the largest gravity.
    pub sags: bool,
}

impl FollowedSpeed {
    /// Returns the speeds of a rig's dofs by position; none if the rig cannot play and no drive is given.
    ///
    /// # Errors
    /// The rig cannot play with the given drive, or has an invalid home pose.
    pub fn each(rig: &LoadedRig, review: &Review, options: Options) -> anyhow::Result<Vec<Self>> {
        let mechanism = &rig.mechanism;
        let parts = match RigParts::new(&rig.description, mechanism, options) {
            Ok(parts) => parts,
            Err(_) if options.drive.is_none() => return Ok(Vec::new()),
            Err(why) => return Err(why.into()),
        };
        let lags = servo_lags(&parts)?;
        if lags.is_empty() {
            return Ok(Vec::new());
        }
        let still = vec![0.0; review.by_dof.len()];
        let home = Instant { q: mechanism.home(), qd: still.clone(), qdd: still };
        let mut held = Vec::new();
        Efforts::of(mechanism)?.at(&home, &mut held)?;
        let friction = |link: &Link| {
            let own = [link.friction, link.damping];
            std::iter::repeat_n(own, link.joint.kind().dof_count())
        };
        let frictions: Vec<[f64; 2]> = mechanism.bodies.iter().flat_map(friction).collect();
        let error = f64::from(parts.following_limit().most_rad);
        let of = |lag: &ServoLag| {
            let own = &review.by_dof[lag.dof];
            let [friction, damping] = frictions[lag.dof];
            let most = lag.most_speed(error, own.gravity_effort + friction, damping);
            Self {
                joint: own.name.clone(),
                slides: own.slides,
                most: most.max(0.0),
                limit: own.speed_limit,
                error,
                sags_at_home: lag.sags(error, held[lag.dof].abs()),
                sags: lag.sags(error, own.gravity_effort),
            }
        };
        Ok(lags.iter().map(of).collect())
    }

    /// Returns the finding that the servos do not carry the rig, if so.
    pub fn finding(&self) -> Option<Finding> {
        let error = text::change(self.slides, self.error);
        let (severity, pose) = match self {
            Self { sags_at_home: true, .. } => (Severity::Fault, "the home pose"),
            Self { sags: true, .. } => (Severity::Warning, "the pose with the largest gravity"),
            _ => return None,
        };
        let text = format!(
            "in {pose} its servo, driven by position, sags by more than {error}: a show that rests there ends with a \
             following error"
        );
        Some(Finding { severity, about: format!("joint {}", self.joint), text })
    }
}
