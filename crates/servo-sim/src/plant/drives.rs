//! The ways in which a rig's joints move, and how servos' shafts go with them.

use sinew_rig::actuation::JoinedDrive;
use sinew_rig::drive::{Drive, DriveInputError, DrivePose, Numbers};
use sinew_rig::mechanism::JointModel;
use sinew_rig::servo::Servo;

use super::mechanics::Mechanics;

/// Joints that a drive moves, and its servos.
///
/// A drive has as many ways to move as the fewer of its dofs and servos: joints that share a servo go as it goes,
/// servos that share a joint go as that goes.
#[derive(Debug, Clone)]
pub(super) struct Driven {
    drive: Drive,
    /// Dofs of the mechanism.
    pub(super) dofs: Vec<usize>,
    /// Where their positions are in `q`; of a ball joint the first of four.
    coordinates: Vec<usize>,
    is_ball: bool,
    /// Places on the bench.
    pub(super) servos: Vec<usize>,
    /// Turns of each servo for a turn of its shaft, as the drive sees it.
    gears: Vec<f64>,
    /// Own position of each servo where its shaft is at zero, from where its encoder counts zero, rad.
    zeros_rad: Vec<f64>,
}

/// How a drive moves at one pose: for each of its ways the speeds of its dofs, and of its servos.
pub(super) struct DriveAxes {
    pub(super) joints: Vec<Vec<f64>>,
    pub(super) servos: Vec<Vec<f64>>,
}

impl Driven {
    /// `places`: of each joint of the description, its body. `benched`: of each servo of the rig, its place on the
    /// bench and the middle of its encoder, rad. None if one of them has none.
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

    /// Whether its ways are the same at all poses.
    pub(super) fn is_linear(&self) -> bool {
        matches!(&self.drive, Drive::Matrix(matrix) if !matrix.is_ball())
    }

    /// The drive where the joints are.
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

    /// Puts joints where the servos can have them.
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

    /// Own positions of the servos, rad from where their encoders count zero.
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
