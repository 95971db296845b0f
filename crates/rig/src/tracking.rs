//! Limits that each servo's gear sets to the control loop of its joint: bandwidth of the observer, stiffness of the
//! servo's own loop, and radius of the joint's rest zone.

use sinew_core::TreeError;
use sinew_core::bandwidth::Bandwidth;
use sinew_core::coordinates::CoordinatesError;

use crate::actuation::JoinedDrive;
use crate::description::{Description, DescriptionError, ServoModel};
use crate::drive::DriveInputError;
use crate::mechanism::{BODY_COUNT_MAX, Link, Mechanism};
use crate::number::single;
use crate::review::{ControlLoop, FlexibleJoint, inertia_ranges};
use crate::stiffness::Stiffness;

/// Limits by the gear of one servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoTracking {
    /// Bandwidth of the joint's observer, with its reason; `None` for a servo that moves no joint.
    pub bandwidth: Option<Bandwidth>,
    /// Stiffness of the servo's own loop, with its reason; `None` for a servo that moves no joint or has no such
    /// loop.
    pub stiffness: Option<Stiffness>,
    /// Maximum inertia that the servo moves, without its rotor, at its own shaft, kg m².
    pub load_inertia_kg_m2: f64,
    /// Half the play of its gear plus a step of its encoder, at its own shaft, rad.
    pub blind_rad: f64,
    /// `blind_rad` converted to the joint, rad (m for a slide): the radius of the joint's rest zone.
    pub rest: f64,
}

impl ServoTracking {
    /// Returns whether oscillations of the joint's loop decay, for the gear in the servo's data and the maximum
    /// load. The tick is `dt_s`, torques act `latency_ticks` late, the stiffness is `kp_per_s2`, and the winding adds a
    /// damping of `braking_nm_s`. The result is true for a servo without a bandwidth, because it has no such loop.
    /// O(1).
    pub fn decays(
        &self,
        model: &ServoModel,
        dt_s: f64,
        latency_ticks: usize,
        kp_per_s2: f64,
        braking_nm_s: f64,
    ) -> bool {
        let Some(bandwidth) = self.bandwidth else { return true };
        let rotor_inertia = model.rotor_inertia_kg_m2.value;
        let joint = FlexibleJoint {
            rotor_inertia,
            load_inertia: self.load_inertia_kg_m2.max(rotor_inertia),
            stiffness: model.gear_stiffness(),
            gear_damping: model.gear_damping(),
            damping: model.damping_nm_s.value + braking_nm_s,
        };
        let control = ControlLoop {
            dt_s,
            latency_ticks,
            late_s: 0.0,
            bandwidth_rad_s: f64::from(bandwidth.rad_s),
            kp_per_s2,
            torque_share: 1.0,
        };
        control.growth_per_s(&joint) < 0.0
    }
}

/// The reason why the limits were not computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrackingError {
    /// A servo or a drive is invalid.
    #[error(transparent)]
    Description(#[from] DescriptionError),
    /// The bodies are not a valid tree of `sinew-core`.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// A pose is invalid for that tree.
    #[error("a pose within the ranges: {0}")]
    Pose(#[from] CoordinatesError),
    /// A drive refuses the home pose.
    #[error("a drive at the home pose: {0}")]
    Drive(#[from] DriveInputError),
}

/// Returns the limits of each servo of a rig, in the rig's order, for a tick of `dt_s` seconds: see
/// [`Bandwidth::of_loaded_gear`]. Levers are computed in the home pose; loads are the maximum of 64 poses. O(n).
///
/// # Errors
/// [`TrackingError`] if the rig does not fit `sinew-core`, or a drive or a servo is invalid.
pub fn tracking(
    rig: &Description,
    mechanism: &Mechanism,
    dt_s: f64,
) -> Result<Vec<ServoTracking>, TrackingError> {
    let actuation = rig.actuation()?;
    let loads = greatest_loads(mechanism)?;
    let mut servos: Vec<ServoTracking> = rig
        .servos
        .iter()
        .map(|servo| {
            // `actuation` has refused unknown models.
            let model = rig.servo_model(&servo.model).unwrap_or_default();
            let blind_rad = model.half_play_rad() + model.resolution_rad.value;
            ServoTracking {
                bandwidth: None,
                stiffness: None,
                load_inertia_kg_m2: 0.0,
                blind_rad,
                rest: 0.0,
            }
        })
        .collect();
    for drive in &actuation.drives {
        let Some((home, loads)) = of_drive(rig, mechanism, drive, &loads) else { continue };
        let pose = drive.drive.at_joints(&home)?;
        for (place, index) in drive.servos.iter().enumerate() {
            let mut alone = vec![0.0; drive.servos.len()];
            alone[place] = 1.0;
            let moved = pose.joint_velocities(&alone)?;
            let share = f64::from(pose.servo_velocities(&moved)?[place]);
            let gear = f64::from(actuation.servos[*index].settings().gear).abs();
            let square = |(load, moved): (&f64, &f32)| load * f64::from(*moved).powi(2);
            let at_shaft: f64 = loads.iter().zip(&moved).map(square).sum();
            // Servos that share a joint share its load.
            let load = if share > 0.0 { at_shaft / share / (gear * gear) } else { 0.0 };
            let Some(model) = rig.servo_model(&rig.servos[*index].model) else { continue };
            let (stiffness, rotor) = (model.gear_stiffness(), model.rotor_inertia_kg_m2.value);
            // Hobby servos have no rotor data: the rule then returns an error, and no loop is closed.
            let bandwidth = Bandwidth::of_loaded_gear(
                single(stiffness),
                single(rotor),
                single(load).max(f32::MIN_POSITIVE),
                single(dt_s),
            );
            let servo = &mut servos[*index];
            servo.bandwidth = bandwidth.ok();
            servo.stiffness = Stiffness::of(&model, load);
            servo.load_inertia_kg_m2 = load;
            let farthest = moved.iter().map(|moved| f64::from(moved.abs())).fold(0.0, f64::max);
            servo.rest = servo.blind_rad / gear * farthest;
        }
    }
    Ok(servos)
}

/// Returns home positions and maximum inertias of a drive's dofs; `None` if one of its joints was merged.
fn of_drive(
    rig: &Description,
    mechanism: &Mechanism,
    drive: &JoinedDrive,
    loads: &[Vec<f64>],
) -> Option<(Vec<f32>, Vec<f64>)> {
    let (mut home, mut own) = (Vec::new(), Vec::new());
    for joint in &drive.joints {
        let name = &rig.joints[*joint].name;
        let body = mechanism.bodies.iter().position(|link| link.joint_name == *name)?;
        let link = &mechanism.bodies[body];
        let count = link.joint.kind().dof_count();
        if link.home.len() == count {
            home.extend(link.home.iter().copied().map(single));
        } else {
            // The home of a ball joint is its zero pose.
            home.extend(vec![0.0; count]);
        }
        own.extend(&loads[body]);
    }
    Some((home, own))
}

/// Returns the maximum inertia of each dof of each body, without rotors, with all joints beyond it held.
fn greatest_loads(mechanism: &Mechanism) -> Result<Vec<Vec<f64>>, TrackingError> {
    let tree = mechanism.tree::<BODY_COUNT_MAX>()?;
    let mut ranges = inertia_ranges(mechanism, &tree)?.into_iter();
    let of_link = |link: &Link| {
        let dofs = ranges.by_ref().take(link.joint.kind().dof_count());
        dofs.map(|[_, most]| (most - link.rotor_inertia).max(0.0)).collect()
    };
    Ok(mechanism.bodies.iter().map(of_link).collect())
}
