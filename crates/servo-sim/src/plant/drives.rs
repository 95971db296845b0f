//! The independent motions of a rig's drives: speeds of joints and of servo shafts.

use sinew_rig::actuation::JoinedDrive;
use sinew_rig::drive::{Drive, DriveInputError, DrivePose, Numbers};
use sinew_rig::mechanism::JointModel;
use sinew_rig::servo::Servo;

use super::mechanics::Mechanics;

/// A drive with the joints that it moves, and its servos.
///
/// The number of independent motions of a drive is the smaller of the numbers of dofs and servos: joints that share a
/// servo move together, and so do servos that share a joint.
#[derive(Debug, Clone)]
pub(super) struct Driven {
    drive: Drive,
    /// Dofs of the drive in the mechanism.
    pub(super) dofs: Vec<usize>,
    /// Indices of the joints' positions in `q`; for a ball joint only the first of four.
    coordinates: Vec<usize>,
    is_ball: bool,
    /// Indices of the servos on the bench.
    pub(super) servos: Vec<usize>,
    /// Turns of each servo for one turn of the drive's shaft.
    gears: Vec<f64>,
    /// Own position of each servo, rad, when the drive's shaft is at zero.
    zeros_rad: Vec<f64>,
}

/// Independent motions of a drive at one pose. For each motion: the speeds of the drive's dofs, and of its servos, if
/// the motion has speed 1.
pub(super) struct DriveAxes {
    pub(super) joints: Vec<Vec<f64>>,
    pub(super) servos: Vec<Vec<f64>>,
}

impl Driven {
    /// Creates a drive. `places` is the body of each joint of the description. `benched` is, for each servo of the rig,
    /// its index on the bench and the middle of its encoder, rad. Returns `None` if a joint has no body, or a servo is
    /// not on the bench.
    pub(super) fn new(
        of: &JoinedDrive,
        servos: &[Servo],
        mechanics: &Mechanics,
        places: &[Option<usize>],
        benched: &[Option<(usize, f64)>],
    ) -> Option<Self> {
        let (mut dofs, mut coordinates, mut is_ball) = (Vec::new(), Vec::new(), false);
        for joint in &of.joints {
            let body = places[*joint]?;
            let first = mechanics.places[body][1];
            is_ball |= mechanics.mechanism.bodies[body].joint == JointModel::Spherical;
            for (axis, dof) in mechanics.dofs_of(body).enumerate() {
                dofs.push(dof);
                coordinates.push(first + axis);
            }
        }
        let own = |servo: &usize| servos[*servo].settings();
        let benched: Vec<(usize, f64)> =
            of.servos.iter().map(|servo| benched[*servo]).collect::<Option<_>>()?;
        Some(Self {
            drive: of.drive.clone(),
            dofs,
            coordinates,
            is_ball,
            gears: of.servos.iter().map(|servo| own(servo).gear.into()).collect(),
            zeros_rad: of
                .servos
                .iter()
                .zip(&benched)
                .map(|(servo, (_, middle))| middle + f64::from(own(servo).offset_rad))
                .collect(),
            servos: benched.into_iter().map(|(place, _)| place).collect(),
        })
    }

    pub(super) fn ways(&self) -> usize {
        self.dofs.len().min(self.servos.len())
    }

    /// Returns whether the drive's motions are the same at all poses.
    pub(super) fn is_linear(&self) -> bool {
        matches!(&self.drive, Drive::Matrix(matrix) if !matrix.is_ball())
    }

    /// Returns the pose of the drive at joint coordinates `q`.
    pub(super) fn at(&self, q: &[f64]) -> Result<DrivePose<'_>, DriveInputError> {
        let joints: Vec<f32> = if let (true, Some(first)) = (self.is_ball, self.coordinates.first())
        {
            let [x, y, z, w] = [0, 1, 2, 3].map(|k| q[first + k]);
            let turn = glam::DQuat::from_xyzw(x, y, z, w);
            let shorter = if w < 0.0 { -turn } else { turn };
            shorter.to_scaled_axis().to_array().map(single).to_vec()
        } else {
            self.coordinates.iter().map(|place| single(q[*place])).collect()
        };
        self.drive.at_joints(&joints)
    }

    /// Moves joints to positions that the servos can reach.
    pub(super) fn settle(&self, q: &mut [f64]) -> Result<(), DriveInputError> {
        if self.dofs.len() > self.servos.len() {
            let shafts = Numbers::from_slice(self.at(q)?.servos()).unwrap_or_default();
            for (place, joint) in
                self.coordinates.iter().zip(self.drive.at_servos(&shafts)?.joints())
            {
                q[*place] = (*joint).into();
            }
        }
        Ok(())
    }

    /// Returns the servos' own positions, rad, zero where their encoders count zero.
    pub(super) fn positions_rad(&self, pose: &DrivePose<'_>) -> Vec<f64> {
        let shafts = pose.servos().iter();
        shafts
            .zip(self.gears.iter().zip(&self.zeros_rad))
            .map(|(shaft, (gear, zero))| gear * f64::from(*shaft) + zero)
            .collect()
    }

    pub(super) fn ways_at(&self, pose: &DrivePose<'_>) -> Result<DriveAxes, DriveInputError> {
        let (mut joints, mut servos) = (Vec::new(), Vec::new());
        let count = self.ways();
        let leads = self.dofs.len() <= self.servos.len();
        for way in 0..count {
            let unit: Vec<f32> =
                (0..count).map(|other| f32::from(u8::from(other == way))).collect();
            let (of_joints, of_shafts) = if leads {
                (Numbers::from_slice(&unit).unwrap_or_default(), pose.servo_velocities(&unit)?)
            } else {
                (pose.joint_velocities(&unit)?, Numbers::from_slice(&unit).unwrap_or_default())
            };
            joints.push(of_joints.iter().map(|speed| f64::from(*speed)).collect());
            let own = of_shafts.iter().zip(&self.gears);
            servos.push(own.map(|(speed, gear)| gear * f64::from(*speed)).collect());
        }
        Ok(DriveAxes { joints, servos })
    }
}

#[expect(clippy::cast_possible_truncation, reason = "drives compute in f32")]
fn single(number: f64) -> f32 {
    number as f32
}
