//! Idle life: a long loop of breathing, blinking, glances and weight shifts, in which the seam is invisible.
//!
//! The words in a joint's name decide its [`Role`]. All moves are drawn from a seed and placed on a circle of time.
//! Each move takes at least as long as the joint's limits need.

mod actor;
mod alike;
mod moves;
mod role;
mod score;
#[cfg(test)]
mod tests;

use sinew_retarget::feasibility::RigMotion;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;
use thiserror::Error;

use actor::{Actor, align};
use alike::most_alike;
pub use role::Role;
use score::Drift;

/// Rate of the motion's rows, Hz.
const RATE_HZ: f64 = 100.0;
/// Share of an amplitude that is slow drift; eyes and lids have no drift.
const DRIFT: f64 = 0.25;
/// Largest permitted correlation of two windows of 10 s.
const ALIKE_MAX: f64 = 0.95;
/// Number of attempts to find a loop in which no two windows are alike.
const ATTEMPTS: u64 = 12;
/// Shares of the usual amplitudes. They are tried in this order until all limits are kept.
const SHARES: [f64; 4] = [1.0, 0.7, 0.4, 0.2];

/// Settings of idle life.
#[derive(Debug, Clone, PartialEq)]
pub struct IdleSettings {
    /// Length of the loop, s.
    pub seconds: f64,
    /// Seed of all draws.
    pub seed: u64,
    /// Roles of single joints, by name. They replace the roles that the names give.
    pub uses: Vec<(Role, String)>,
}

/// A loop of idle life.
#[derive(Debug, Clone, PartialEq)]
pub struct IdleLoop {
    /// The motion. Its last row equals its first row.
    pub motion: RigMotion,
    /// For each role that takes part, the names of its joints.
    pub used: Vec<(Role, Vec<String>)>,
    /// Names of the joints that stay at home.
    pub still: Vec<String>,
    /// Share of the usual amplitudes that the loop uses.
    pub share: f64,
    /// The joint that uses the largest share of its maximum speed, and this share.
    pub fastest: (String, f64),
    /// Largest correlation between two windows of 10 s that do not overlap.
    pub alike: f64,
}

/// The reason why there is no loop of idle life.
#[derive(Debug, Error)]
pub enum IdleError {
    /// The length is invalid.
    #[error("expected a loop of 20 to 3600 s, found {0} s")]
    Seconds(f64),
    /// The rig has no such joint.
    #[error("the rig has no joint `{found}`: expected one of {expected}")]
    NoJoint {
        /// Name of the joint.
        found: String,
        /// Names of all joints.
        expected: String,
    },
    /// A joint with a given role cannot take part.
    #[error("joint `{0}`: expected one axis, and a range if it slides")]
    Axes(String),
    /// No joint takes part.
    #[error(
        "no name of a joint tells its part (lid, eye, brow, head, neck, chest, spine, waist, shoulder, arm ..): name joints with \
         `--use ROLE=JOINT`; the joints are {0}"
    )]
    Nothing(String),
    /// A limit is exceeded even with the smallest amplitudes.
    #[error("even with small motions {0}")]
    Limit(String),
    /// Two windows are alike in every attempt.
    #[error(
        "two windows of 10 s are alike (correlation {0:.3}) in every attempt: expected more joints, or a shorter loop"
    )]
    Alike(f64),
}

/// Makes a loop of idle life for a rig on its stand.
///
/// # Errors
/// [`IdleError`] if the length is invalid, a joint of `uses` is unknown or cannot take part, no joint takes part, every
/// attempt has windows that are alike, or a limit is exceeded even with the smallest amplitudes.
pub fn idle(mechanism: &Mechanism, settings: &IdleSettings) -> Result<IdleLoop, IdleError> {
    if !(20.0..=3600.0).contains(&settings.seconds) {
        return Err(IdleError::Seconds(settings.seconds));
    }
    let roles = roles(mechanism, &settings.uses)?;
    let mut exceeded = String::new();
    for share in SHARES {
        let mut actors: Vec<Actor> = roles
            .iter()
            .filter_map(|(body, role)| Actor::of(mechanism, *body, *role, share))
            .collect();
        align(mechanism, &mut actors);
        if actors.is_empty() {
            return Err(IdleError::Nothing(names(mechanism).join(", ")));
        }
        match looped(mechanism, &actors, settings)? {
            Ok((motion, alike)) => {
                let fastest = fastest(mechanism, &actors, &motion);
                let of_role = |role: Role| {
                    let of_role = actors.iter().filter(|actor| actor.role == role);
                    (role, of_role.map(|actor| actor.name.clone()).collect::<Vec<_>>())
                };
                let used = Role::all().map(of_role).filter(|(_, joints)| !joints.is_empty());
                let is_used = |name: &String| actors.iter().any(|actor| actor.name == *name);
                let still = names(mechanism).into_iter().filter(|name| !is_used(name)).collect();
                let used = used.collect();
                return Ok(IdleLoop { motion, used, still, share, fastest, alike });
            }
            Err(what) => exceeded = what,
        }
    }
    Err(IdleError::Limit(exceeded))
}

/// Makes a loop in which no two windows are alike, and returns it with their largest correlation. The inner error names
/// a limit that the loop exceeds.
fn looped(
    mechanism: &Mechanism,
    actors: &[Actor],
    settings: &IdleSettings,
) -> Result<Result<(RigMotion, f64), String>, IdleError> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "20 s to an hour")]
    let count = (settings.seconds * RATE_HZ).round() as usize;
    let (loop_s, seed) = (count as f64 / RATE_HZ, settings.seed);
    let mut alike = 0.0;
    for attempt in 0..ATTEMPTS {
        let moves = score::moves(actors, loop_s, seed, attempt);
        let drifts: Vec<Drift> = (0..)
            .zip(actors)
            .map(|(number, _)| Drift::new(loop_s, seed, attempt, number))
            .collect();
        let value = |actor: usize, time_s: f64| match actors[actor].role {
            Role::Blink | Role::EyeTurn | Role::EyeNod => moves[actor].at(time_s),
            _ => (1.0 - DRIFT) * moves[actor].at(time_s) + DRIFT * drifts[actor].at(time_s),
        };
        alike = most_alike(loop_s, |time_s| {
            (0..actors.len()).map(|actor| value(actor, time_s)).collect()
        });
        if alike > ALIKE_MAX {
            continue;
        }
        let row = |row: usize| {
            let mut q = mechanism.home();
            for (index, actor) in actors.iter().enumerate() {
                let time_s = (row % count) as f64 / RATE_HZ;
                q[actor.place] = actor.middle + actor.amplitude * value(index, time_s);
            }
            q
        };
        let motion = RigMotion { dt_s: RATE_HZ.recip(), rows: (0..=count).map(row).collect() };
        let exceeded = exceeded(mechanism, actors, &motion);
        return Ok(exceeded.map_or(Ok((motion, alike)), Err));
    }
    Err(IdleError::Alike(alike))
}

/// Returns the bodies whose joints take part, with their roles.
fn roles(mechanism: &Mechanism, uses: &[(Role, String)]) -> Result<Vec<(usize, Role)>, IdleError> {
    for (role, found) in uses {
        let body = mechanism.bodies.iter().position(|link| link.joint_name == *found);
        let body = body.ok_or_else(|| IdleError::NoJoint {
            found: found.clone(),
            expected: names(mechanism).join(", "),
        })?;
        if *role != Role::Still && Actor::of(mechanism, body, *role, 1.0).is_none() {
            return Err(IdleError::Axes(found.clone()));
        }
    }
    let role = |name: &str| {
        let given = uses.iter().rev().find(|(_, joint)| joint == name);
        given.map(|(role, _)| *role).or_else(|| Role::of(name)).filter(|role| *role != Role::Still)
    };
    let bodies = mechanism.bodies.iter().enumerate();
    Ok(bodies.filter_map(|(body, link)| Some((body, role(&link.joint_name)?))).collect())
}

fn names(mechanism: &Mechanism) -> Vec<String> {
    let moving = mechanism.bodies.iter().filter(|link| link.joint != JointModel::Fixed);
    moving.map(|link| link.joint_name.clone()).collect()
}

/// Returns the absolute speed and acceleration of a coordinate, for each row of a loop.
fn rates(motion: &RigMotion, place: usize) -> impl Iterator<Item = [f64; 2]> {
    let (rows, dt_s) = (&motion.rows[1..], motion.dt_s);
    (0..rows.len()).map(move |row| {
        let at = |shift: usize| rows[(row + shift) % rows.len()][place];
        let speed = (at(1) - at(0)).abs() / dt_s;
        [speed, (at(2) - 2.0 * at(1) + at(0)).abs() / (dt_s * dt_s)]
    })
}

/// Describes the first limit that a loop exceeds; `None` if it keeps all.
fn exceeded(mechanism: &Mechanism, actors: &[Actor], motion: &RigMotion) -> Option<String> {
    for actor in actors {
        let link = &mechanism.bodies[actor.body];
        let of_range = |range: &[f64; 2]| {
            motion.rows.iter().any(|q| !(range[0]..=range[1]).contains(&q[actor.place]))
        };
        if link.ranges.first().is_some_and(of_range) {
            return Some(format!("joint `{}` leaves its range", actor.name));
        }
        let beyond = |[speed, acceleration]: [f64; 2]| {
            speed > link.speed || acceleration > link.acceleration
        };
        if rates(motion, actor.place).any(beyond) {
            return Some(format!("joint `{}` exceeds its speed or acceleration", actor.name));
        }
    }
    let ranges = mechanism.coordinate_ranges();
    let start = |body: usize| ranges.get(body).map_or(0, |range| range.start);
    mechanism.linked.iter().find_map(|linked| {
        let sum = |q: &Vec<f64>| {
            linked.factor * q[start(linked.body)] + linked.other_factor * q[start(linked.other)]
        };
        let [least, most] = linked.range;
        let is_beyond = |q| !(least - 1e-9..=most + 1e-9).contains(&sum(q));
        let [one, other] =
            [linked.body, linked.other].map(|body| mechanism.bodies[body].joint_name.as_str());
        motion
            .rows
            .iter()
            .any(is_beyond)
            .then(|| format!("joints `{one}` and `{other}` leave the range that joins them"))
    })
}

/// Returns the joint that uses the largest share of its maximum speed, and this share.
fn fastest(mechanism: &Mechanism, actors: &[Actor], motion: &RigMotion) -> (String, f64) {
    let share = |actor: &Actor| {
        let limit = mechanism.bodies[actor.body].speed;
        let most = rates(motion, actor.place).map(|[speed, _]| speed).fold(0.0, f64::max);
        (actor.name.clone(), most / limit)
    };
    let shares = actors.iter().map(share);
    shares.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
}
