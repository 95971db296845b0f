//! Checks drives: each joint and servo has at most one drive, and the numbers of a drive fit its joints and servos.

use super::names::Names;
use super::part::{Part, Sign};
use crate::description::error::{DescriptionError, Step};
use crate::description::{Description, Drive, DriveKind, Joint, JointType, UnitKeys};

/// Drive of each joint and of each servo.
pub(super) struct Owners {
    joints: Vec<Option<usize>>,
    servos: Vec<Option<usize>>,
}

impl Owners {
    pub(super) fn new(rig: &Description) -> Self {
        Self { joints: vec![None; rig.joints.len()], servos: vec![None; rig.servos.len()] }
    }
}

pub(super) fn check(
    rig: &Description,
    (joint_names, servo_names): (&Names<'_>, &Names<'_>),
    owners: &mut Owners,
    index: usize,
    drive: &Drive,
) -> Result<(), DescriptionError> {
    let name = drive.joints.join(", ");
    let part = Part::of("drive", index, &name);
    let joints = take(part, "joints", &drive.joints, joint_names, &mut owners.joints, index)?;
    take(part, "servos", &drive.servos, servo_names, &mut owners.servos, index)?;
    let joints: Vec<&Joint> = joints.iter().map(|joint| &rig.joints[*joint]).collect();
    for (place, joint) in joints.iter().enumerate() {
        if matches!(joint.kind, JointType::Fixed | JointType::Free) {
            let expected =
                "a joint that a drive can move: revolute, prismatic, universal or spherical";
            let at = [Step::Key("joints"), Step::Index(place)];
            return Err(part.refuse(&at, expected, format!("{:?}, which is not", joint.name)));
        }
    }
    check_kind(part, drive, &joints)
}

/// Assigns the named parts to a drive, and returns their indices. Fails if another drive has one of them.
fn take(
    part: Part<'_>,
    key: &'static str,
    names: &[String],
    known: &Names<'_>,
    owners: &mut [Option<usize>],
    drive: usize,
) -> Result<Vec<usize>, DescriptionError> {
    if names.is_empty() {
        return Err(part.refuse(&[Step::Key(key)], "at least one name", "[]"));
    }
    let mut indices = Vec::new();
    for (place, name) in names.iter().enumerate() {
        let at = [Step::Key(key), Step::Index(place)];
        let index = known.find(part, &at, name)?;
        if let Some(owner) = owners[index] {
            let found = format!("{name:?}, which is in drive[{owner}] already");
            return Err(part.refuse(&at, "a name that is in no drive yet", found));
        }
        owners[index] = Some(drive);
        indices.push(index);
    }
    Ok(indices)
}

fn check_kind(part: Part<'_>, drive: &Drive, joints: &[&Joint]) -> Result<(), DescriptionError> {
    match &drive.kind {
        DriveKind::Matrix { rows, offset } => check_matrix(part, drive, joints, rows, offset),
        DriveKind::Curve { points } => {
            one_to_one(part, drive, joints, "curve")?;
            let at = [Step::Key("curve"), Step::Key(UnitKeys::of(joints.iter().copied()).points)];
            for (place, point) in points.iter().enumerate() {
                let at = [at[0], at[1], Step::Index(place)];
                part.numbers(&at, point, Sign::Any)?;
            }
            if points.len() < 2 {
                let found = format!("{} points", points.len());
                return Err(part.refuse(&at, "at least two points", found));
            }
            Ok(())
        }
        DriveKind::FourBar {
            ground_m,
            crank_m,
            coupler_m,
            rocker_m,
            crank_zero_rad,
            rocker_zero_rad,
            ..
        } => {
            one_to_one(part, drive, joints, "four_bar")?;
            for (key, value, sign) in [
                ("ground_m", ground_m, Sign::Positive),
                ("crank_m", crank_m, Sign::Positive),
                ("coupler_m", coupler_m, Sign::Positive),
                ("rocker_m", rocker_m, Sign::Positive),
                ("crank_zero_deg", crank_zero_rad, Sign::Any),
                ("rocker_zero_deg", rocker_zero_rad, Sign::Any),
            ] {
                part.number(&[Step::Key("four_bar"), Step::Key(key)], *value, sign)?;
            }
            if joints.iter().any(|joint| joint.kind != JointType::Revolute) {
                let expected = "a revolute joint: the rocker turns";
                return Err(part.refuse(&[Step::Key("joints")], expected, "another type"));
            }
            Ok(())
        }
    }
}

fn check_matrix(
    part: Part<'_>,
    drive: &Drive,
    joints: &[&Joint],
    rows: &[Vec<f64>],
    offset: &[f64],
) -> Result<(), DescriptionError> {
    let dofs: usize = joints.iter().map(|joint| joint.kind.dof_count()).sum();
    let servos = drive.servos.len();
    let at = [Step::Key("matrix"), Step::Key("rows")];
    for (place, row) in rows.iter().enumerate() {
        let at = [at[0], at[1], Step::Index(place)];
        part.numbers(&at, row, Sign::Any)?;
        if row.len() != servos {
            let expected = format!("a number for each of the {servos} servos");
            return Err(part.refuse(&at, expected, format!("{} numbers", row.len())));
        }
    }
    if rows.len() != dofs {
        let expected = format!("a row for each of the {dofs} degrees of freedom of its joints");
        return Err(part.refuse(&at, expected, format!("{} rows", rows.len())));
    }
    let at = [Step::Key("matrix"), Step::Key(UnitKeys::of(joints.iter().copied()).offset)];
    part.numbers(&at, offset, Sign::Any)?;
    if offset.is_empty() {
        return Ok(());
    }
    if offset.len() != rows.len() {
        let expected = format!("a number for each of the {} rows, or none", rows.len());
        return Err(part.refuse(&at, expected, format!("{} numbers", offset.len())));
    }
    let slides = joints.iter().filter(|joint| joint.kind == JointType::Prismatic).count();
    if slides > 0 && slides < joints.len() {
        let expected = "no offset, since some of the joints turn and some slide";
        return Err(part.refuse(&at, expected, "one"));
    }
    Ok(())
}

/// Checks that a curve or a linkage connects one servo and one joint.
fn one_to_one(
    part: Part<'_>,
    drive: &Drive,
    joints: &[&Joint],
    kind: &'static str,
) -> Result<(), DescriptionError> {
    let dofs: usize = joints.iter().map(|joint| joint.kind.dof_count()).sum();
    for (key, count, expected) in [
        ("joints", dofs, "one joint of one degree of freedom"),
        ("servos", drive.servos.len(), "one servo"),
    ] {
        if count != 1 {
            let expected = format!("{expected}, since the drive is a {}", kind.replace('_', "-"));
            return Err(part.refuse(&[Step::Key(key)], expected, count));
        }
    }
    Ok(())
}
