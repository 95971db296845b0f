//! Finds ranges by hand: with torque off, a person moves the joint from stop to stop, and the ends are recorded.

use std::time::Duration;

use sinew_rig::Description;
use sinew_rig::description::{Joint, JointType};
use sinew_servo_bus::table::Item;

use crate::follow::Follow;
use crate::rig_file::ServoChange;
use crate::rig_servo::{RigServo, own_rad};
use crate::store::{set_torque, torque_is_on};
use crate::table::Role;
use crate::{Client, Exchange, ServiceError, Servo};

/// Interval between readings while a person moves a joint. In this time, a hand turns a joint by less than half a turn.
pub const LOOK_EVERY: Duration = Duration::from_millis(50);
/// Minimum width of a range, deg. A smaller range means that the joint was not moved to both stops.
const LEAST_RANGE_DEG: f64 = 5.0;
/// Maximum speed at which a hand can turn a joint, deg/s.
const MOST_DEG_S: f64 = 1500.0;

/// A servo that a person moves, and the range of its motion so far.
#[derive(Debug, Clone)]
pub struct Track {
    /// Name of the servo in the rig.
    pub name: String,
    servo: Servo,
    item: Item,
    now: i32,
    ends: [i32; 2],
    crossed_seam: bool,
    follow: Follow,
}

impl Track {
    /// Returns the present position, deg from the middle of the encoder.
    pub fn now_deg(&self) -> f64 {
        self.degrees(self.now)
    }

    /// Returns the smallest and the largest position so far, deg from the middle of the encoder.
    pub fn ends_deg(&self) -> [f64; 2] {
        self.ends.map(|counts| self.degrees(counts))
    }

    /// Returns whether the servo has passed the seam of its encoder: such a range is unusable.
    pub fn has_crossed_seam(&self) -> bool {
        self.crossed_seam
    }

    fn degrees(&self, counts: i32) -> f64 {
        own_rad(&self.servo.table, counts).to_degrees()
    }

    fn take(&mut self, counts: i32) {
        let turn = self.servo.table.counts();
        let is_outside = !(0..turn).contains(&counts);
        // A jump of more than half a turn between two readings means that the seam was crossed.
        self.crossed_seam |= is_outside || (counts - self.now).abs() > turn / 2;
        self.now = counts;
        let [least, most] = self.ends;
        self.ends = [least.min(counts), most.max(counts)];
    }
}

/// The servos whose ranges are calibrated, with torque off.
#[derive(Debug, Clone)]
pub struct Calibration {
    tracks: Vec<Track>,
}

impl Calibration {
    /// Switches torque off, and starts at the present positions.
    ///
    /// # Errors
    /// The errors of [`Client::read_bytes`], and [`NotKept`](crate::Registers::NotKept) if torque stays on.
    pub fn begin<E: Exchange>(
        client: &mut Client<E>,
        servos: &[(RigServo, Servo)],
    ) -> Result<Self, ServiceError> {
        let mut tracks = Vec::new();
        for (rig, servo) in servos {
            set_torque(client, servo, false)?;
            let item = servo.table.role(Role::PresentPosition)?;
            let now = client.read(servo, &item)?;
            let follow = Follow::new(&item, MOST_DEG_S).over_seam(servo.table.counts());
            let mut track = Track {
                name: rig.name.clone(),
                servo: servo.clone(),
                item,
                now,
                ends: [now; 2],
                crossed_seam: false,
                follow,
            };
            track.take(now);
            tracks.push(track);
        }
        Ok(Self { tracks })
    }

    /// Reads the present positions.
    ///
    /// # Errors
    /// The errors of [`Client::read_bytes`], and [`ServiceError::State`] if torque is on again, or a position changed
    /// faster than a hand can move it.
    pub fn look<E: Exchange>(&mut self, client: &mut Client<E>) -> Result<(), ServiceError> {
        for track in &mut self.tracks {
            let id = track.servo.id;
            if torque_is_on(client, &track.servo)? {
                let what = "its torque came on while a hand moved it: another program controls it, or it is broken";
                return Err(ServiceError::State { id, what: what.to_owned() });
            }
            let counts = client.read(&track.servo, &track.item)?;
            let possible = track.follow.take(client.now(), counts);
            possible.map_err(|what| ServiceError::State { id, what })?;
            track.take(counts);
        }
        Ok(())
    }

    /// Returns the servos with their ranges so far.
    pub fn tracks(&self) -> &[Track] {
        &self.tracks
    }

    /// Returns the present positions, rad from the middle of the encoders.
    pub fn now_rad(&self) -> Vec<f64> {
        self.tracks.iter().map(|track| own_rad(&track.servo.table, track.now)).collect()
    }

    /// Returns the ranges, reduced by `margin_deg` at both ends.
    ///
    /// # Errors
    /// [`ServiceError::Rig`] if a servo has passed its seam, or was hardly moved.
    pub fn ranges(&self, margin_deg: f64) -> Result<Vec<ServoChange>, ServiceError> {
        self.tracks
            .iter()
            .map(|track| {
                let refused = |what: String| ServiceError::Rig { name: track.name.clone(), what };
                if track.crossed_seam {
                    return Err(refused(
                        "its range passes the seam of its encoder, where it counts from the end to the beginning. \
                         Turn its horn on the shaft, by about half a turn, and calibrate again"
                            .to_owned(),
                    ));
                }
                let [least, most] = track.ends_deg();
                if most - least < 2.0 * margin_deg + LEAST_RANGE_DEG {
                    return Err(refused(format!(
                        "it was moved by {:.1} deg only; move it from stop to stop",
                        most - least
                    )));
                }
                let range_deg = Some([least + margin_deg, most - margin_deg].map(hundredths));
                Ok(ServoChange {
                    name: track.name.clone(),
                    range_deg,
                    ..ServoChange::default()
                })
            })
            .collect()
    }
}

/// Returns the indices of the drives that contain the named joints or servos, or of all drives if `names` is empty.
///
/// # Errors
/// [`ServiceError::Rig`] if a name is unknown.
pub fn drives_of(rig: &Description, names: &[String]) -> Result<Vec<usize>, ServiceError> {
    let mut drives = Vec::new();
    for name in names {
        let drive = rig
            .drives
            .iter()
            .position(|drive| drive.joints.contains(name) || drive.servos.contains(name));
        drives.push(drive.ok_or_else(|| {
            let known: Vec<&str> =
                rig.drives.iter().flat_map(|drive| &drive.joints).map(String::as_str).collect();
            ServiceError::Rig {
                name: rig.name.clone(),
                what: format!("no drive moves {name:?}; there are: {}", known.join(", ")),
            }
        })?);
    }
    if names.is_empty() {
        drives = (0..rig.drives.len()).collect();
    }
    drives.sort_unstable();
    drives.dedup();
    Ok(drives)
}

/// Describes the joints of a drive with their home positions: in degrees, or in mm for a slide. A joint with several
/// axes has no number: its home is its zero pose.
pub fn home_of(rig: &Description, drive: usize) -> Vec<String> {
    let joints = rig.drives.get(drive).map(|drive| drive.joints.as_slice()).unwrap_or_default();
    joints
        .iter()
        .filter_map(|name| rig.joints.iter().find(|joint| joint.name == *name))
        .map(|joint| match (joint.home().first(), joint.kind) {
            (Some(home), JointType::Prismatic) => {
                format!("{} at {:.1} mm", joint.name, home * 1e3)
            }
            (Some(home), JointType::Revolute) => {
                format!("{} at {:.1} deg", joint.name, home.to_degrees())
            }
            _ => format!("{} at its zero pose", joint.name),
        })
        .collect()
}

/// Returns the offsets of a drive's servos, in the drive's order. The joints must be at home while the servos' own
/// positions are `own_rad`.
///
/// # Errors
/// [`ServiceError::Rig`] if the rig's drives are invalid.
pub fn offsets(
    rig: &Description,
    drive: usize,
    own_rad: &[f64],
) -> Result<Vec<ServoChange>, ServiceError> {
    let refused = |what: String| ServiceError::Rig { name: rig.name.clone(), what };
    let actuation = rig.actuation().map_err(|error| refused(error.to_string()))?;
    let drive =
        actuation.drives.get(drive).ok_or_else(|| refused(format!("it has no drive {drive}")))?;
    let home: Vec<f32> = drive
        .joints
        .iter()
        .flat_map(|joint| rig.joints.get(*joint).map(home_coordinates).unwrap_or_default())
        .collect();
    let pose = drive.drive.at_joints(&home).map_err(|error| refused(error.to_string()))?;
    let servos = drive.servos.iter().filter_map(|servo| rig.servos.get(*servo));
    Ok(servos
        .zip(pose.servos())
        .zip(own_rad)
        .map(|((servo, shaft), own)| {
            let turned = f64::from(servo.direction) * servo.gear * f64::from(*shaft);
            ServoChange {
                name: servo.name.clone(),
                offset_deg: Some(hundredths((own - turned).to_degrees())),
                ..ServoChange::default()
            }
        })
        .collect())
}

/// Rounds to 0.01 deg: a hand does not find the end of a range more exactly.
fn hundredths(degrees: f64) -> f64 {
    (degrees * 100.0).round() / 100.0
}

fn home_coordinates(joint: &Joint) -> Vec<f32> {
    if joint.kind == JointType::Spherical {
        // The home pose of a ball joint has a rotation vector of zero.
        return vec![0.0; 3];
    }
    #[expect(clippy::cast_possible_truncation, reason = "a board's numbers are f32")]
    joint.home().into_iter().map(|home| home as f32).collect()
}
