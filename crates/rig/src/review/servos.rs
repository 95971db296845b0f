//! Capability of a rig's servos at its joints.

use std::collections::HashMap;

use super::results::{Capability, Servos, SoftGear, Voltage};
use crate::actuation::{Actuation, JoinedDrive};
use crate::description::{Description, DescriptionError, ServoModel};
use crate::drive::{DriveInputError, DrivePose};
use crate::mechanism::{JointModel, Link, Mechanism};
use crate::number::single;
use crate::servo::Servo;

/// Number of poses over a joint's range at which a curve or a four-bar is evaluated.
const POSES: usize = 33;

/// Number of halvings that find an end of a range: to a millionth of it.
const HALVINGS: usize = 20;

/// Excess over a servo's range that is only rounding, rad: below a step of an encoder with 4096 steps.
const ROUNDING_RAD: f32 = 1e-3;

impl Servos {
    /// Returns the capability of each dof of a mechanism, at the weakest and at the slowest pose of each joint's
    /// range.
    ///
    /// # Errors
    /// [`DescriptionError`] if a servo or a drive is invalid.
    pub fn of(rig: &Description, mechanism: &Mechanism) -> Result<Self, DescriptionError> {
        let actuation = rig.actuation()?;
        let models: Vec<ServoModel> =
            rig.servos.iter().filter_map(|servo| rig.servo_model(&servo.model)).collect();
        let links: HashMap<&str, &Link> =
            mechanism.bodies.iter().map(|link| (link.joint_name.as_str(), link)).collect();
        let mut by_joint: HashMap<&str, Vec<Option<Capability>>> = HashMap::new();
        for drive in &actuation.drives {
            let joints: Vec<&Link> = drive
                .joints
                .iter()
                .filter_map(|joint| links.get(rig.joints[*joint].name.as_str()).copied())
                .collect();
            // `Description::check` ensures finite positions within a joint's range.
            let Ok(all) = capabilities(rig, &actuation, &models, drive, &joints) else { continue };
            let mut all = all.into_iter();
            for joint in &joints {
                let count = joint.joint.kind().dof_count();
                by_joint.insert(&joint.joint_name, all.by_ref().take(count).map(Some).collect());
            }
        }
        let of_link = |link: &Link| {
            let none = || vec![None; link.joint.kind().dof_count()];
            by_joint.remove(link.joint_name.as_str()).unwrap_or_else(none)
        };
        Ok(Self {
            by_dof: mechanism.bodies.iter().flat_map(of_link).collect(),
            stall_current_a: models.iter().map(|model| model.stall_current_a.value).sum(),
            supply_a: rig.supply.map(|supply| supply.current_a),
            voltages: voltages(rig),
        })
    }

    /// Keeps the gears only of dofs whose servos are all driven by current, where the tracker closes the loop.
    /// Other servos close a loop of their own.
    #[must_use]
    pub fn with_loops_of(mut self, is_by_current: impl Fn(&str) -> bool) -> Self {
        for capability in self.by_dof.iter_mut().flatten() {
            if !capability.servos.iter().all(|servo| is_by_current(servo)) {
                capability.gear = None;
            }
        }
        self
    }
}

/// Returns, for each kind of servo in the order of the file, its servos, the supply voltage and the voltage at which
/// the kind's values are valid. Returns nothing if the rig has no supply.
fn voltages(rig: &Description) -> Vec<Voltage> {
    let mut voltages: Vec<Voltage> = Vec::new();
    let Some(supply) = rig.supply else { return voltages };
    for servo in &rig.servos {
        if let Some(known) = voltages.iter_mut().find(|known| known.model == servo.model) {
            known.servos.push(servo.name.clone());
        } else if let Some(model) = rig.servo_model(&servo.model) {
            voltages.push(Voltage {
                servos: vec![servo.name.clone()],
                model: servo.model.clone(),
                supply_v: supply.voltage_v,
                model_v: model.voltage_v.value,
            });
        }
    }
    voltages
}

/// Returns the effort and speed that the servos of one drive can give to one of its dofs at a time, for each dof.
fn capabilities(
    rig: &Description,
    actuation: &Actuation,
    models: &[ServoModel],
    drive: &JoinedDrive,
    joints: &[&Link],
) -> Result<Vec<Capability>, DriveInputError> {
    let servos: Vec<Shaft> = drive
        .servos
        .iter()
        .filter_map(|index| {
            let settings = actuation.servos.get(*index)?.settings();
            Some(Shaft::of(settings.gear, settings.torque_nm, models.get(*index)?))
        })
        .collect();
    let nameless = Capability {
        servos: drive.servos.iter().map(|servo| rig.servos[*servo].name.clone()).collect(),
        continuous: f64::INFINITY,
        stall: f64::INFINITY,
        no_load_speed: f64::INFINITY,
        resolution: 0.0,
        current_per_effort: 0.0,
        guessed: servos.iter().any(|servo| servo.guessed),
        reached: reached(actuation, drive, joints)?,
        gear: None,
    };
    let mut all = vec![nameless; drive.drive.dofs()];
    let gears = gears(&drive.drive.at_joints(&home(joints))?, &servos)?;
    for (capability, gear) in all.iter_mut().zip(gears) {
        capability.gear = Some(gear);
    }
    for q in poses(joints) {
        let pose = drive.drive.at_joints(&q)?;
        for (dof, capability) in all.iter_mut().enumerate() {
            at_pose(&pose, dof, &servos, capability)?;
        }
    }
    Ok(all)
}

/// Returns the part of a joint's range that the servos of its drive permit, from home outwards. Returns nothing if they
/// permit the whole range, or if the drive has several dofs.
fn reached(
    actuation: &Actuation,
    drive: &JoinedDrive,
    joints: &[&Link],
) -> Result<Option<[f64; 2]>, DriveInputError> {
    let ([link], Some(range)) = (joints, joints.first().and_then(|link| link.ranges.first()))
    else {
        return Ok(None);
    };
    let (1, Some(home)) = (link.joint.kind().dof_count(), link.home.first()) else {
        return Ok(None);
    };
    let is_reached = |q: f64| -> Result<bool, DriveInputError> {
        let pose = drive.drive.at_joints(&[single(q)])?;
        let mut servos = drive.servos.iter().filter_map(|index| actuation.servos.get(*index));
        Ok(pose
            .servos()
            .iter()
            .all(|shaft| servos.next().is_none_or(|servo| permits(servo, *shaft))))
    };
    let (mut reached, mut is_whole) = (*range, true);
    for end in &mut reached {
        if is_reached(*end)? {
            continue;
        }
        is_whole = false;
        let (mut inside, mut outside) = (*home, *end);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            *(if is_reached(middle)? { &mut inside } else { &mut outside }) = middle;
        }
        *end = inside;
    }
    Ok((!is_whole).then_some(reached))
}

/// Returns whether a servo's own range contains a position of the drive's shaft, rad.
fn permits(servo: &Servo, shaft_rad: f32) -> bool {
    let limited = servo.own_position(shaft_rad);
    limited.is_ok_and(|own| (servo.shaft_position(own.value) - shaft_rad).abs() < ROUNDING_RAD)
}

/// A servo's data at the input shaft of the drive.
struct Shaft {
    continuous_nm: f64,
    stall_nm: f64,
    speed_rad_s: f64,
    resolution_rad: f64,
    current_a_per_nm: f64,
    gear: SoftGear,
    guessed: bool,
}

impl Shaft {
    fn of(gear: f32, torque_nm: f32, model: &ServoModel) -> Self {
        let gear = f64::from(gear).abs();
        let stall_nm = f64::from(torque_nm).min(model.stall_torque_nm.value);
        let used = [
            &model.continuous_torque_nm,
            &model.stall_torque_nm,
            &model.no_load_speed_rad_s,
            &model.resolution_rad,
            &model.torque_constant_nm_a,
        ];
        Self {
            continuous_nm: gear * model.continuous_torque_nm.value.min(stall_nm),
            stall_nm: gear * stall_nm,
            speed_rad_s: model.no_load_speed_rad_s.value / gear,
            resolution_rad: model.resolution_rad.value / gear,
            current_a_per_nm: 1.0 / (gear * model.torque_constant_nm_a.value),
            gear: SoftGear {
                rotor_inertia: gear * gear * model.rotor_inertia_kg_m2.value,
                stiffness: gear * gear * model.gear_stiffness(),
                gear_damping: gear * gear * model.gear_damping(),
                damping: gear * gear * model.damping_nm_s.value,
                winding_damping: gear * gear * model.winding_damping(),
                play: 2.0 * model.half_play_rad() / gear,
            },
            guessed: used.iter().any(|value| value.is_guess()),
        }
    }
}

/// Returns the gears of a drive's servos, referred to each dof. Inertias, stiffnesses and dampings are multiplied
/// by squared speed ratios and added. Plays are multiplied by the motion of the dof per motion of the servo, and
/// added.
fn gears(pose: &DrivePose<'_>, servos: &[Shaft]) -> Result<Vec<SoftGear>, DriveInputError> {
    let reflected = |of: fn(&SoftGear) -> f64| {
        let each: Vec<f32> = servos.iter().map(|servo| single(of(&servo.gear))).collect();
        pose.reflected_to_joints(&each)
    };
    let rotor_inertia = reflected(|gear| gear.rotor_inertia)?;
    let stiffness = reflected(|gear| gear.stiffness)?;
    let gear_damping = reflected(|gear| gear.gear_damping)?;
    let damping = reflected(|gear| gear.damping)?;
    let winding_damping = reflected(|gear| gear.winding_damping)?;
    let mut play = vec![0.0; pose.joints().len()];
    for (index, servo) in servos.iter().enumerate() {
        let moved = pose.joint_velocities(&unit(servos.len(), index))?;
        for (play, moved) in play.iter_mut().zip(&moved) {
            *play += servo.gear.play * f64::from(moved.abs());
        }
    }
    let gear = |(dof, play): (usize, f64)| {
        let of = |all: &[f32]| all.get(dof).copied().map_or(0.0, f64::from);
        SoftGear {
            rotor_inertia: of(&rotor_inertia),
            stiffness: of(&stiffness),
            gear_damping: of(&gear_damping),
            damping: of(&damping),
            winding_damping: of(&winding_damping),
            play,
        }
    };
    Ok(play.into_iter().enumerate().map(gear).collect())
}

/// Updates each value of the capability that is worse at this pose.
fn at_pose(
    pose: &DrivePose<'_>,
    dof: usize,
    servos: &[Shaft],
    capability: &mut Capability,
) -> Result<(), DriveInputError> {
    let alone = unit(pose.joints().len(), dof);
    let asked: Vec<f64> = pose.servo_torques(&alone)?.iter().map(|x| f64::from(x.abs())).collect();
    let most = |of: fn(&Shaft) -> f64| {
        let shares = servos.iter().zip(&asked).filter(|(_, asked)| **asked > 0.0);
        shares.map(|(servo, asked)| of(servo) / asked).fold(f64::INFINITY, f64::min)
    };
    capability.continuous = capability.continuous.min(most(|servo| servo.continuous_nm));
    capability.stall = capability.stall.min(most(|servo| servo.stall_nm));
    let current: f64 =
        servos.iter().zip(&asked).map(|(servo, asked)| servo.current_a_per_nm * asked).sum();
    capability.current_per_effort = capability.current_per_effort.max(current);
    // Motion of the dof by each servo alone. Their speeds add up, because all servos may move.
    let (mut speed, mut step) = (0.0, 0.0_f64);
    for (index, servo) in servos.iter().enumerate() {
        let moved = pose.joint_velocities(&unit(servos.len(), index))?;
        let moved = moved.get(dof).map_or(0.0, |moved| f64::from(moved.abs()));
        speed += servo.speed_rad_s * moved;
        step = step.max(servo.resolution_rad * moved);
    }
    capability.no_load_speed = capability.no_load_speed.min(speed);
    capability.resolution = capability.resolution.max(step);
    Ok(())
}

fn unit(count: usize, of: usize) -> Vec<f32> {
    (0..count).map(|index| if index == of { 1.0 } else { 0.0 }).collect()
}

/// Returns positions of a drive's joints to evaluate: over the joint's range for a single dof, otherwise the home
/// pose. Only curves and four-bars, which have one joint of one dof, depend on the position.
fn poses(joints: &[&Link]) -> Vec<Vec<f32>> {
    let one_dof = matches!(joints, [link] if link.joint.kind().dof_count() == 1);
    match joints.first().and_then(|link| link.ranges.first()) {
        Some([least, most]) if one_dof => (0..POSES)
            .map(|pose| {
                let share = pose as f64 / (POSES - 1) as f64;
                vec![single(least + share * (most - least))]
            })
            .collect(),
        _ => vec![home(joints)],
    }
}

fn home(joints: &[&Link]) -> Vec<f32> {
    let of_link = |link: &&Link| match link.joint {
        JointModel::Spherical => vec![0.0; 3],
        _ => link.home.iter().map(|position| single(*position)).collect(),
    };
    joints.iter().flat_map(of_link).collect()
}
