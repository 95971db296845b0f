//! A linear model of a dof whose servos close their own loop.

use sinew_firmware::drives::DriveSettings;
use sinew_retarget::feasibility::DofPeaks;
use sinew_rig::drive::DriveInputError;
use sinew_rig::stiffness::DELAY_S;

use crate::play::{Drive, RigParts};

/// Age of the error's two positions, in ticks: a goal is followed until the end of its tick, and a reading is from the
/// tick before.
const LATE_TICKS: f64 = 2.0;
/// Share of the torque and of the speed up to which a bound counts: beyond it, sagging voltage and friction may leave
/// the servo without torque.
const MOST_SHARE: f64 = 0.8;

/// A dof whose servos close their own loop and report their position. Units: rad and N m, for a slide m and N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoLag {
    /// Index of the dof.
    pub dof: usize,
    /// Effort per position error of the servos.
    pub stiffness: f64,
    /// Effort per position error that the controller assumes. It differs from `stiffness` by the voltage of the supply.
    assumed_stiffness: f64,
    /// Largest error under any load that stays between a peak and its negative, as a multiple of the error at rest
    /// under the peak; see `peak_gain`.
    pub peak_gain: f64,
    /// Effort that the motors lose per speed, by back-EMF.
    pub drag: f64,
    /// Maximum effort, at standstill.
    pub stall: f64,
    /// Maximum speed that the servos' firmware commands; infinite without limit.
    pub speed_cap: f64,
    /// Maximum offset of the goal beyond the target, by which the controller compensates the effort.
    offset: f64,
    /// Length of a tick, s.
    tick_s: f64,
}

impl ServoLag {
    /// Returns a bound of the error in a motion with these peaks: `peak_gain load / stiffness + speed 2 dt`, where the
    /// load is the effort plus `drag` times the speed. `None` if the servos may lack the effort or the speed, or if
    /// their loop does not damp, so that the error has no bound.
    pub fn bound(&self, peaks: &DofPeaks) -> Option<f64> {
        let load = peaks.effort + self.drag * peaks.speed;
        let is_strong =
            load <= MOST_SHARE * self.stall && peaks.speed <= MOST_SHARE * self.speed_cap;
        (is_strong && self.peak_gain.is_finite()).then(|| {
            self.peak_gain * load / self.stiffness + LATE_TICKS * self.tick_s * peaks.speed
        })
    }

    /// Returns the load that the servos cannot hold with an error of at most `most`, however long they try.
    fn most_load(&self, most: f64) -> f64 {
        // Without enough voltage the servo is softer than the controller assumes, and its offset is too small.
        let missing = self.stiffness.recip() - self.assumed_stiffness.recip();
        let within_offset = most / missing;
        let is_within = missing > 0.0 && within_offset <= self.assumed_stiffness * self.offset;
        let by_stiffness =
            if is_within { within_offset } else { self.stiffness * (most + self.offset) };
        by_stiffness.min(self.stall)
    }

    /// Returns the speed above which the error exceeds `most` if the motion lasts, under a constant load; 0 or less if
    /// the servos cannot even carry the load. The load includes Coulomb friction; `damping` is the viscous friction.
    pub fn most_speed(&self, most: f64, load: f64, damping: f64) -> f64 {
        ((self.most_load(most) - load) / (self.drag + damping)).min(self.speed_cap)
    }

    /// Returns whether the servos cannot carry a load at rest with an error of at most `most`.
    pub fn sags(&self, most: f64, load: f64) -> bool {
        load > self.most_load(most)
    }
}

/// Returns the peak gain of a loop with a damping that is this share of the critical one: the integral of the absolute
/// impulse response, divided by the response at rest. Each half swing is `e^-x` of the half swing before it, with
/// `x = π ζ / √(1 - ζ²)`. A load that changes its sign with the swings adds them all up: `(1 + e^-x) / (1 - e^-x)`. It
/// is 2.6 for a damping of 0.25, which the rule of the P gain demands of most servos. O(1).
pub(super) fn peak_gain(damping_ratio: f64) -> f64 {
    if damping_ratio >= 1.0 {
        return 1.0;
    }
    let ratio = damping_ratio.max(0.0);
    let half_swing = (-std::f64::consts::PI * ratio / (1.0 - ratio * ratio).sqrt()).exp();
    (1.0 + half_swing) / (1.0 - half_swing)
}

/// Returns the models of all dofs whose servos close their own loop and report their position, at the worst of the home
/// pose and the ends of each range.
///
/// # Errors
/// [`DriveInputError`] if a drive does not accept a pose of its range.
pub fn servo_lags(parts: &RigParts) -> Result<Vec<ServoLag>, DriveInputError> {
    let board = parts.compact();
    let mut lags: Vec<ServoLag> = Vec::new();
    for drive in board.drives() {
        let dofs: Vec<usize> = drive.dofs.iter().map(|dof| usize::from(*dof)).collect();
        if dofs.first().and_then(|dof| parts.drives[*dof]) != Some(Drive::Position) {
            continue;
        }
        let servos: Vec<Shaft> =
            drive.servos.iter().filter_map(|servo| Shaft::of(parts, usize::from(*servo))).collect();
        let at = |position: fn(&sinew_rig::board::BoardDof) -> f32| -> Vec<f32> {
            dofs.iter().map(|dof| position(&board.dofs()[*dof])).collect()
        };
        let mut poses = vec![at(|dof| dof.home)];
        // Only a drive of one dof depends on the position.
        if dofs.len() == 1 {
            let ends = [at(|dof| dof.range[0]), at(|dof| dof.range[1])];
            poses.extend(ends.into_iter().filter(|pose| pose.iter().all(|at| at.is_finite())));
        }
        for (place, dof) in dofs.iter().enumerate() {
            let mut worst: Option<ServoLag> = None;
            for pose in &poses {
                let lag = at_pose(&drive.drive.at_joints(pose)?, (*dof, place), &servos)?;
                let lag = ServoLag { tick_s: 1e-6 * f64::from(parts.tick_us()), ..lag };
                worst = Some(worst.map_or(lag, |worst| worst.and(lag)));
            }
            lags.extend(worst);
        }
    }
    lags.sort_by_key(|lag| lag.dof);
    Ok(lags)
}

impl ServoLag {
    /// Returns the worse of both values of each kind.
    fn and(self, other: Self) -> Self {
        Self {
            stiffness: self.stiffness.min(other.stiffness),
            assumed_stiffness: self.assumed_stiffness.min(other.assumed_stiffness),
            peak_gain: self.peak_gain.max(other.peak_gain),
            drag: self.drag.max(other.drag),
            stall: self.stall.min(other.stall),
            speed_cap: self.speed_cap.min(other.speed_cap),
            offset: self.offset.min(other.offset),
            ..self
        }
    }
}

/// A servo, at the shaft that its drive uses.
struct Shaft {
    stiffness: f32,
    peak_gain: f64,
    assumed_stiffness: f32,
    drag: f32,
    stall: f64,
    speed_cap: f64,
    offset: f64,
}

impl Shaft {
    /// Returns the servo at an index of the rig, if it is driven by position.
    fn of(parts: &RigParts, servo: usize) -> Option<Self> {
        let settings = *parts.compact().servos()[servo].servo.settings();
        let setup = parts.setup(servo);
        let DriveSettings::Position(own) = setup.drive else { return None };
        let kind = &parts.servos[servo].own.kind;
        let gear = settings.gear.abs();
        // Torque and stiffness of a motor are in proportion to its voltage, its back-EMF is not.
        let voltage_v = parts.supply_v().map_or(kind.voltage_v, f64::from);
        let voltage = voltage_v / kind.voltage_v;
        let stall_nm = f64::from(setup.stall_nm) * voltage;
        let assumed = settings.position_gain_nm_rad * own.gain_ratio * gear * gear;
        #[expect(clippy::cast_possible_truncation, reason = "drives compute in f32")]
        let stiffness = assumed * voltage as f32;
        let drag = own.drag_nm_s * gear * gear;
        // The load with the most inertia swings the longest. The delay of the servo's loop takes from its damping.
        let rotor = kind.rotor_inertia_kg_m2;
        let inertia = rotor + parts.load_inertias_kg_m2[servo].max(rotor);
        let at_motor = f64::from(stiffness / (gear * gear));
        let damping = kind.damping_nm_s + f64::from(own.drag_nm_s) - at_motor * DELAY_S;
        Some(Self {
            stiffness,
            peak_gain: peak_gain(0.5 * damping / (at_motor * inertia).sqrt()),
            assumed_stiffness: assumed,
            drag,
            stall: stall_nm.min(settings.torque_nm.into()) * f64::from(gear),
            speed_cap: kind.speed_cap_rad_s.unwrap_or(f64::INFINITY) / f64::from(gear),
            offset: f64::from(own.offset_rad / gear),
        })
    }
}

fn at_pose(
    pose: &sinew_rig::drive::DrivePose<'_>,
    (dof, place): (usize, usize),
    servos: &[Shaft],
) -> Result<ServoLag, DriveInputError> {
    let mut alone = vec![0.0; pose.joints().len()];
    alone[place] = 1.0;
    let (torques, speeds) = (pose.servo_torques(&alone)?, pose.servo_velocities(&alone)?);
    let reflected = |of: fn(&Shaft) -> f32| -> Result<f64, DriveInputError> {
        let each: Vec<f32> = servos.iter().map(of).collect();
        Ok(pose.reflected_to_joints(&each)?.get(place).copied().map_or(0.0, f64::from))
    };
    let least = |of: fn(&Shaft) -> f64, shares: &[f32]| {
        let each = servos.iter().zip(shares).filter(|(_, share)| share.abs() > 0.0);
        each.map(|(servo, share)| of(servo) / f64::from(share.abs())).fold(f64::INFINITY, f64::min)
    };
    Ok(ServoLag {
        dof,
        stiffness: reflected(|servo| servo.stiffness)?,
        assumed_stiffness: reflected(|servo| servo.assumed_stiffness)?,
        peak_gain: servos.iter().map(|servo| servo.peak_gain).fold(1.0, f64::max),
        drag: reflected(|servo| servo.drag)?,
        stall: least(|servo| servo.stall, &torques),
        speed_cap: least(|servo| servo.speed_cap, &speeds),
        offset: least(|servo| servo.offset, &speeds),
        tick_s: 0.0,
    })
}
