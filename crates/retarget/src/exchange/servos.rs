//! Positions of a rig's servos during a motion, in their makers' units.

use glam::DQuat;
use sinew_rig::actuation::Actuation;
use sinew_rig::description::{Description, DescriptionError};
use sinew_rig::drive::DriveInputError;
use sinew_rig::limited::NotFinite;
use sinew_rig::mechanism::{JointModel, Mechanism};
use sinew_rig::servo::Address;
use thiserror::Error;

use crate::feasibility::RigMotion;

/// Positions of one servo during a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoTrack {
    /// Name of the servo.
    pub servo: String,
    /// Address on its bus.
    pub address: Address,
    /// Position in every row: encoder steps for a servo with an id, or the pulse in us for a servo on a channel.
    pub positions: Vec<i32>,
    /// Number of rows in which the position was limited to an end of the servo's range.
    pub limited: usize,
}

/// The reason why servo positions were not computed.
#[derive(Debug, Error)]
pub enum ServoTrackError {
    /// The rig has no servos.
    #[error(
        "the rig has no servos: expected `[[servo]]` and `[[drive]]` in its rig.toml; `sinew rig import` does not \
         write them"
    )]
    NoServos,
    /// A servo or drive of the rig is invalid.
    #[error(transparent)]
    Rig(#[from] DescriptionError),
    /// A drive refuses a position.
    #[error("row {row}, servo `{servo}`: {source}")]
    Drive {
        /// Index of the row.
        row: usize,
        /// First servo of the drive.
        servo: String,
        /// Reason of the drive.
        source: DriveInputError,
    },
    /// A position is NaN or infinite.
    #[error("row {row}, servo `{servo}`: {source}")]
    NotFinite {
        /// Index of the row.
        row: usize,
        /// Name of the servo.
        servo: String,
        /// The value that is not finite.
        source: NotFinite,
    },
    /// Two servos have the same number, therefore a table of positions cannot distinguish them.
    #[error(
        "servos `{first}` and `{second}` have the number {number}: expected a number for each servo, over all buses, in a table of \
         positions"
    )]
    SameNumber {
        /// Name of the first servo.
        first: String,
        /// Name of the second servo.
        second: String,
        /// Id or channel of both.
        number: u8,
    },
    /// Positions belong to a servo that the rig does not have.
    #[error("servo {found}: expected the ids or channels of the rig: {expected}")]
    UnknownServo {
        /// Number of the servo.
        found: String,
        /// Numbers of the rig's servos.
        expected: String,
    },
    /// Most positions of a hobby servo are outside the range of pulses.
    #[error("servo `{servo}`: {found} is no pulse of this servo ({least} to {most} us): {unit}")]
    NoPulse {
        /// Name of the servo.
        servo: String,
        /// First position that is outside this range.
        found: i32,
        /// Shortest pulse, us.
        least: i32,
        /// Longest pulse, us.
        most: i32,
        /// Unit that the positions probably have.
        unit: String,
    },
    /// A servo has no position in a frame.
    #[error(
        "servo `{servo}` ({number}): expected a position in every frame, found none in frame {frame}"
    )]
    NoPosition {
        /// Name of the servo.
        servo: String,
        /// Id or channel of the servo.
        number: u8,
        /// Index of the frame.
        frame: usize,
    },
}

/// Pulse at the ends of a hobby servo's range, us.
const PULSES_US: [i32; 2] = [500, 2500];
/// Number of 12-bit steps of a PCA9685 that make a pulse of 2500 us at 60 Hz.
const MOST_STEPS: i32 = 615;
/// Time of a step at 50 Hz, us.
const US_PER_STEP: f64 = 20_000.0 / 4096.0;

/// Refuses positions of a hobby servo that are probably not in us: more than half of them are outside the range of
/// pulses. Fewer of them are accepted, because a motion may exceed a servo's range at times.
pub(super) fn check_pulses(servo: &str, positions: &[i32]) -> Result<(), ServoTrackError> {
    let [least, most] = PULSES_US;
    let mut wrong = positions.iter().filter(|us| !(least..=most).contains(*us));
    let Some(&found) = wrong.next() else { return Ok(()) };
    if 2 * (1 + wrong.count()) <= positions.len() {
        return Ok(());
    }
    let all_are = |range: std::ops::RangeInclusive<i32>| {
        positions.iter().all(|position| range.contains(position))
    };
    let unit = if all_are(-180..=180) {
        "degrees? 1500 us is the middle".to_owned()
    } else if all_are(0..=MOST_STEPS) {
        let us = f64::from(found) * US_PER_STEP;
        format!("12-bit steps of a PCA9685? At 50 Hz {found} of them are {us:.0} us")
    } else {
        "1500 us is the middle".to_owned()
    };
    Err(ServoTrackError::NoPulse { servo: servo.to_owned(), found, least, most, unit })
}

/// Conversion of a servo's own angle to its maker's unit.
#[derive(Debug, Clone, Copy)]
struct Numbering {
    middle: f64,
    per_rad: f64,
}

impl Numbering {
    fn of(rig: &Description, index: usize) -> Self {
        let servo = &rig.servos[index];
        // `actuation` has ensured that the kind is known.
        let model = rig.servo_model(&servo.model).unwrap_or_default();
        let range_rad = model.range_rad.value.max(1e-6);
        if let Some(pulses) = rig.pulses(servo) {
            return Self { middle: pulses.us[1], per_rad: pulses.us_per_rad() };
        }
        let per_rad = model.resolution_rad.value.max(1e-9).recip();
        Self { middle: (0.5 * range_rad * per_rad).round(), per_rad }
    }
}

/// Computes the positions of a rig's servos during a motion.
///
/// # Errors
/// [`ServoTrackError`] if the rig has no servos, a servo or drive is invalid, two servos have one number, a drive
/// refuses a position, or a position is not finite.
pub fn tracks(
    rig: &Description,
    mechanism: &Mechanism,
    motion: &RigMotion,
) -> Result<Vec<ServoTrack>, ServoTrackError> {
    let actuation = actuation(rig)?;
    let mut tracks: Vec<ServoTrack> = rig
        .servos
        .iter()
        .map(|servo| ServoTrack {
            servo: servo.name.clone(),
            address: servo.address,
            positions: Vec::with_capacity(motion.rows.len()),
            limited: 0,
        })
        .collect();
    let places = Places::of(rig, mechanism);
    let numberings = numberings(rig);
    for (row, q) in motion.rows.iter().enumerate() {
        for drive in &actuation.drives {
            let of_drive: Vec<f32> =
                drive.joints.iter().flat_map(|joint| places.of_joint(*joint, q)).collect();
            let first = drive.servos.first().copied().unwrap_or_default();
            let pose = drive.drive.at_joints(&of_drive).map_err(|source| {
                ServoTrackError::Drive { row, servo: rig.servos[first].name.clone(), source }
            })?;
            for (index, shaft_rad) in drive.servos.iter().zip(pose.servos()) {
                let track = &mut tracks[*index];
                let own = actuation.servos[*index].own_position(*shaft_rad).map_err(|source| {
                    ServoTrackError::NotFinite { row, servo: track.servo.clone(), source }
                })?;
                track.limited += usize::from(own.reason.is_some() || pose.reason().is_some());
                let numbering = numberings[*index];
                let number = numbering.middle + f64::from(own.value) * numbering.per_rad;
                #[expect(clippy::cast_possible_truncation, reason = "saturates")]
                track.positions.push(number.round() as i32);
            }
        }
    }
    tracks.retain(|track| !track.positions.is_empty());
    Ok(tracks)
}

/// Computes the rig's motion from servo positions; joints without servos stay at home.
///
/// # Errors
/// [`ServoTrackError`] if the rig has no servos, a servo or drive is invalid, two servos have one number, a servo has
/// no position in a row, or a drive refuses a position. Tracks of other servos are ignored.
pub fn motion(
    rig: &Description,
    mechanism: &Mechanism,
    tracks: &[ServoTrack],
    dt_s: f64,
) -> Result<RigMotion, ServoTrackError> {
    let actuation = actuation(rig)?;
    let places = Places::of(rig, mechanism);
    let numberings = numberings(rig);
    let rows = tracks.iter().map(|track| track.positions.len()).max().unwrap_or(0);
    let mut motion = RigMotion { dt_s, rows: Vec::with_capacity(rows) };
    for row in 0..rows {
        let mut q = mechanism.home();
        for drive in &actuation.drives {
            let mut shafts_rad = Vec::with_capacity(drive.servos.len());
            for index in &drive.servos {
                let servo = &rig.servos[*index];
                let track = tracks.iter().find(|track| track.address == servo.address);
                let position =
                    track.and_then(|track| track.positions.get(row)).ok_or_else(|| {
                        ServoTrackError::NoPosition {
                            servo: servo.name.clone(),
                            number: number_of(servo.address),
                            frame: row,
                        }
                    })?;
                let numbering = numberings[*index];
                let own_rad = (f64::from(*position) - numbering.middle) / numbering.per_rad;
                #[expect(clippy::cast_possible_truncation, reason = "drives compute in f32")]
                shafts_rad.push(actuation.servos[*index].shaft_position(own_rad as f32));
            }
            let pose = drive.drive.at_servos(&shafts_rad).map_err(|source| {
                let first = drive.servos.first().copied().unwrap_or_default();
                ServoTrackError::Drive { row, servo: rig.servos[first].name.clone(), source }
            })?;
            let mut of_drive = pose.joints();
            for joint in &drive.joints {
                of_drive = places.take(*joint, of_drive, &mut q);
            }
        }
        motion.rows.push(q);
    }
    Ok(motion)
}

fn numberings(rig: &Description) -> Vec<Numbering> {
    (0..rig.servos.len()).map(|index| Numbering::of(rig, index)).collect()
}

/// Returns the id or the channel of an address.
pub fn number_of(address: Address) -> u8 {
    match address {
        Address::Id(number) | Address::Channel(number) => number,
    }
}

fn actuation(rig: &Description) -> Result<Actuation, ServoTrackError> {
    let actuation = rig.actuation()?;
    if actuation.drives.is_empty() {
        return Err(ServoTrackError::NoServos);
    }
    for (index, servo) in rig.servos.iter().enumerate() {
        let number = number_of(servo.address);
        let mut before = rig.servos[..index].iter();
        if let Some(first) = before.find(|first| number_of(first.address) == number) {
            let [first, second] = [first, servo].map(|servo| servo.name.clone());
            return Err(ServoTrackError::SameNumber { first, second, number });
        }
    }
    Ok(actuation)
}

/// For each joint of a description, its kind and its coordinates' range in `q`.
struct Places {
    joints: Vec<Option<(JointModel, std::ops::Range<usize>)>>,
}

impl Places {
    fn of(rig: &Description, mechanism: &Mechanism) -> Self {
        let ranges = mechanism.coordinate_ranges();
        let place = |name: &str| {
            // The base has no joint in the description.
            let body =
                mechanism.bodies.iter().skip(1).position(|link| link.joint_name == name)? + 1;
            Some((mechanism.bodies[body].joint, ranges[body].clone()))
        };
        Self { joints: rig.joints.iter().map(|joint| place(&joint.name)).collect() }
    }

    /// Returns a joint's coordinates for a drive; for a ball joint its rotation vector.
    fn of_joint(&self, joint: usize, q: &[f64]) -> Vec<f32> {
        let Some((dof, range)) = &self.joints[joint] else { return Vec::new() };
        let of_joint = q.get(range.clone()).unwrap_or_default();
        let single = |x: &f64| {
            #[expect(clippy::cast_possible_truncation, reason = "drives compute in f32")]
            let single = *x as f32;
            single
        };
        match (dof, of_joint) {
            (JointModel::Spherical, &[x, y, z, w]) => {
                let turn = DQuat::from_xyzw(x, y, z, w).to_scaled_axis();
                turn.to_array().iter().map(single).collect()
            }
            _ => of_joint.iter().map(single).collect(),
        }
    }

    /// Stores a joint's coordinates from a drive in `q`; returns the remaining numbers of the drive.
    fn take<'a>(&self, joint: usize, of_drive: &'a [f32], q: &mut [f64]) -> &'a [f32] {
        let Some((dof, range)) = &self.joints[joint] else { return of_drive };
        let count = dof.kind().dof_count();
        let (own, rest) = of_drive.split_at_checked(count).unwrap_or_default();
        let slots = &mut q[range.clone()];
        if let (JointModel::Spherical, &[x, y, z]) = (dof, own) {
            let turn = glam::DVec3::new(f64::from(x), f64::from(y), f64::from(z));
            slots.copy_from_slice(&DQuat::from_scaled_axis(turn).to_array());
        } else {
            for (slot, own) in slots.iter_mut().zip(own) {
                *slot = f64::from(*own);
            }
        }
        rest
    }
}
