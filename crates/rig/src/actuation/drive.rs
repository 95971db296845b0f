//! Converts a drive of a description into the form of the board, and checks its numbers.

use super::joined_drive::JoinedDrive;
use crate::description::{Description, DescriptionError, DriveKind, JointType, Path, Step};
use crate::drive::{Curve, Drive, DriveError, FourBar, Links, Matrix};
use crate::number::single;
use crate::servo::Servo;

/// Returns the drive at an index of the description.
pub(super) fn of(
    rig: &Description,
    servos: &[Servo],
    index: usize,
) -> Result<JoinedDrive, DescriptionError> {
    let described = &rig.drives[index];
    let refused = |key, expected: &str, found: String| DescriptionError {
        path: Path(vec![Step::Key("drive"), Step::Index(index), Step::Key(key)]),
        item: format!("drive {:?}", described.joints.join(", ")),
        expected: expected.to_owned(),
        found,
    };
    let unknown = |key, name: &str| refused(key, "a name that there is", format!("{name:?}"));
    let joints = described
        .joints
        .iter()
        .map(|name| {
            let place = rig.joints.iter().position(|joint| joint.name == *name);
            place.ok_or_else(|| unknown("joints", name))
        })
        .collect::<Result<Vec<_>, _>>()?;
    let servo_indices = described
        .servos
        .iter()
        .map(|name| {
            let place = rig.servos.iter().position(|servo| servo.name == *name);
            place.ok_or_else(|| unknown("servos", name))
        })
        .collect::<Result<Vec<_>, _>>()?;
    let balls =
        joints.iter().filter(|joint| rig.joints[**joint].kind == JointType::Spherical).count();
    if balls > 0 && joints.len() > 1 {
        let expected = "a spherical joint alone in its drive";
        return Err(refused("joints", expected, format!("{} joints", joints.len())));
    }
    let range_rad = servo_indices.first().map_or([0.0; 2], |servo| servos[*servo].shaft_range());
    let drive = drive(&described.kind, balls > 0, range_rad).map_err(|error| {
        refused(
            key(&described.kind),
            "a drive that moves all of its joints well",
            error.to_string(),
        )
    })?;
    Ok(JoinedDrive { drive, joints, servos: servo_indices })
}

fn key(kind: &DriveKind) -> &'static str {
    match kind {
        DriveKind::Matrix { .. } => "matrix",
        DriveKind::Curve { .. } => "curve",
        DriveKind::FourBar { .. } => "four_bar",
    }
}

/// Creates the drive as a board stores it. `range_rad` is the range of its servo's shaft.
fn drive(kind: &DriveKind, ball: bool, range_rad: [f32; 2]) -> Result<Drive, DriveError> {
    match kind {
        DriveKind::Matrix { rows, offset } => {
            let rows: Vec<Vec<f32>> =
                rows.iter().map(|row| row.iter().copied().map(single).collect()).collect();
            let offset: Vec<f32> = offset.iter().copied().map(single).collect();
            let matrix = if ball { Matrix::of_ball } else { Matrix::new };
            Ok(matrix(&rows, &offset)?.into())
        }
        DriveKind::Curve { points } => {
            let points: Vec<[f32; 2]> = points.iter().map(|point| point.map(single)).collect();
            Ok(Curve::new(&points)?.into())
        }
        DriveKind::FourBar {
            ground_m,
            crank_m,
            coupler_m,
            rocker_m,
            crank_zero_rad,
            rocker_zero_rad,
            crossed,
        } => {
            let links = Links {
                ground_m: single(*ground_m),
                crank_m: single(*crank_m),
                coupler_m: single(*coupler_m),
                rocker_m: single(*rocker_m),
                crank_zero_rad: single(*crank_zero_rad),
                rocker_zero_rad: single(*rocker_zero_rad),
                crossed: *crossed,
            };
            Ok(FourBar::new(links, range_rad)?.into())
        }
    }
}
