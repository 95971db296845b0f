//! Ranges found by hand: torque off, a person moves the joint from stop to stop, and the ends are kept.

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

/// How often to look while a person moves a joint: a hand turns no joint by half a turn meanwhile.
pub const LOOK_EVERY: Duration = Duration::from_millis(50);
/// A range that is smaller than this was not gone through.
const LEAST_RANGE_DEG: f64 = 5.0;
/// No hand turns a joint faster.
const MOST_DEG_S: f64 = 1500.0;

/// A servo that a person moves.
#[derive(Debug, Clone)]
pub struct Track {
    /// The rig's name for it.
    pub name: String,
    servo: Servo,
    item: Item,
    now: i32,
    ends: [i32; 2],
    crossed_seam: bool,
    follow: Follow,
}

impl Track {
    /// Where it is, from the middle of its encoder.
    pub fn now_deg(&self) -> f64 {
        self.degrees(self.now)
    }

    /// The least and the most so far.
    pub fn ends_deg(&self) -> [f64; 2] {
        self.ends.map(|counts| self.degrees(counts))
    }

    /// Whether it has passed the seam of its encoder: such a range cannot be used.
    pub fn has_crossed_seam(&self) -> bool {
        self.crossed_seam
    }

    fn degrees(&self, counts: i32) -> f64 {
        own_rad(&self.servo.table, counts).to_degrees()
    }

    fn take(&mut self, counts: i32) {
        let turn = self.servo.table.counts();
        let is_outside = !(0..turn).contains(&counts);
        // From one look to the next nobody moves by half a turn, but the count does at the seam.
        self.crossed_seam |= is_outside || (counts - self.now).abs() > turn / 2;
        self.now = counts;
        let [least, most] = self.ends;
        self.ends = [least.min(counts), most.max(counts)];
    }
}

/// Servos whose ranges are looked for. Their torque is off.
#[derive(Debug, Clone)]
pub struct Calibration {
    tracks: Vec<Track>,
}

impl Calibration {
    /// Switches torque off, and begins where the servos are.
    ///
    /// # Errors
    /// Those of [`Client::read_bytes`].
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

    /// Looks where they are.
    ///
    /// # Errors
    /// Those of [`Client::read_bytes`], and [`ServiceError::State`] if torque came on, or one is where no hand can have
    /// turned it.
    pub fn look<E: Exchange>(&mut self, client: &mut Client<E>) -> Result<(), ServiceError> {
        for track in &mut self.tracks {
            let id = track.servo.id;
            if torque_is_on(client, &track.servo)? {
                let what = "its torque came on while a hand moved it: another program talks to it, or it is broken";
                return Err(ServiceError::State { id, what: what.to_owned() });
            }
            let counts = client.read(&track.servo, &track.item)?;
            let possible = track.follow.take(client.now(), counts);
            possible.map_err(|what| ServiceError::State { id, what })?;
            track.take(counts);
        }
        Ok(())
    }

    /// The servos, and how far they went.
    pub fn tracks(&self) -> &[Track] {
        &self.tracks
    }

    /// Where they are, rad from the middle of their encoders.
    pub fn now_rad(&self) -> Vec<f64> {
        self.tracks.iter().map(|track| own_rad(&track.servo.table, track.now)).collect()
    }

    /// The ranges, `margin_deg` short of both ends.
    ///
    /// # Errors
    /// [`ServiceError::Rig`] if one has passed its seam, or was hardly moved.
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
                let range_deg = Some([least + margin_deg, most - margin_deg]);
                Ok(ServoChange { name: track.name.clone(), range_deg, offset_deg: None })
            })
            .collect()
    }
}

/// The drives that some joints, or servos, of a rig belong to; all of them where none is named. As indices.
///
/// # Errors
/// [`ServiceError::Rig`] if nothing has a name.
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

/// Joints of a drive, with where they are at home: degrees, or mm of a slide; none for a joint of several axes, which
/// is at its zero pose.
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

/// Offsets of a drive's servos, whose joints stand at home while the servos' own positions are `own_rad`, in the
/// drive's order.
///
/// # Errors
/// [`ServiceError::Rig`] if the rig's drives are not sound.
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
                range_deg: None,
                offset_deg: Some((own - turned).to_degrees()),
            }
        })
        .collect())
}

fn home_coordinates(joint: &Joint) -> Vec<f32> {
    if joint.kind == JointType::Spherical {
        // Of its rotation vector: at home it is at its zero pose.
        return vec![0.0; 3];
    }
    #[expect(clippy::cast_possible_truncation, reason = "a board's numbers are f32")]
    joint.home().into_iter().map(|home| home as f32).collect()
}
