//! Up direction and unit of length of a file.

use glam::{DQuat, DVec3};

use super::note::{NoteKind, Notes};
use super::options::Options;
use crate::description::{Description, JointType, Mount};

/// Up direction and unit of a file, with the reasons for them.
#[derive(Debug, Clone, PartialEq)]
pub struct World {
    /// Axis that points up, unit vector.
    pub up: DVec3,
    /// Reason for this axis.
    pub up_reason: String,
    /// Length of a unit, m.
    pub metres_per_unit: f64,
    /// Reason for this unit.
    pub unit_reason: String,
}

const YOU: &str = "as you specified";
const FORMAT: &str = "as its format says";
const GRAVITY: &str = "as its gravity shows";
/// Units that gravity can reveal, m.
const UNITS: [f64; 4] = [0.01, 0.001, 0.0254, 0.1];
/// Relative tolerance of gravity against 9.81 m/s²: 9.8 and 9.80665 are accepted.
const GRAVITY_TOLERANCE: f64 = 0.002;

impl World {
    /// Chooses axis and unit from the user's options, otherwise from gravity if the file has it; otherwise z and
    /// the metre, which are the usual choice of robot formats.
    pub(super) fn of(options: &Options, gravity: Option<DVec3>) -> Self {
        let against = gravity.and_then(|gravity| {
            let up = -gravity.try_normalize()?;
            DVec3::AXES.into_iter().find(|axis| up.dot(*axis) > 1.0 - GRAVITY_TOLERANCE)
        });
        let by_gravity = gravity.and_then(|gravity| {
            let is = |unit: &f64| (gravity.length() * unit / 9.81 - 1.0).abs() < GRAVITY_TOLERANCE;
            UNITS.into_iter().find(is)
        });
        let (up, up_reason) = (options.up.map(|up| (up, YOU)))
            .or_else(|| against.filter(|up| *up != DVec3::Z).map(|up| (up, GRAVITY)))
            .unwrap_or((DVec3::Z, FORMAT));
        let (metres_per_unit, unit_reason) = (options.metres_per_unit.map(|unit| (unit, YOU)))
            .or_else(|| by_gravity.map(|unit| (unit, GRAVITY)))
            .unwrap_or((1.0, FORMAT));
        Self {
            up,
            up_reason: up_reason.to_owned(),
            metres_per_unit,
            unit_reason: unit_reason.to_owned(),
        }
    }

    /// Sets the mount so that the rig is upright.
    pub(super) fn stand(&self, description: &mut Description, notes: &mut Notes) {
        let (up, why) = (self.up, &self.up_reason);
        if up == DVec3::Y {
            return notes.add(NoteKind::Changed, format!("y is up ({why}), as in a rig"));
        }
        description.mount = if up == DVec3::Z {
            Mount::z_up()
        } else {
            let turn = DQuat::from_rotation_arc(up, DVec3::Y);
            Mount { rotation_xyzw: turn.to_array(), ..Mount::default() }
        };
        let (axis, turn) =
            if up == DVec3::Z { ("z", "-90 deg about x") } else { ("x", "90 deg about z") };
        notes.add(
            NoteKind::Changed,
            format!(
                "{axis} is up ({why}), and y in a rig: mount.rotation_xyzw turns the rig by {turn}, once. If another axis \
                 is up in this file, say so with --up"
            ),
        );
    }

    /// Converts lengths to metres.
    pub(super) fn measure(&self, description: &mut Description, notes: &mut Notes) {
        let unit = self.metres_per_unit;
        if (unit - 1.0).abs() <= 0.0 {
            return;
        }
        let place = |place: &mut [f64]| place.iter_mut().for_each(|x| *x *= unit);
        place(&mut description.mount.position_m);
        for body in &mut description.bodies {
            place(&mut body.center_of_mass_m);
            body.box_m.iter_mut().for_each(|size| place(size));
            for shape in &mut body.shapes {
                place(&mut shape.position_m);
                shape.size_m.iter_mut().for_each(|size| place(size));
                let lengths = [&mut shape.radius_m, &mut shape.length_m];
                lengths.into_iter().flatten().for_each(|length| *length *= unit);
            }
            body.inertia_kg_m2 = body.inertia_kg_m2.map(|inertia| inertia.scaled(unit * unit));
        }
        for joint in &mut description.joints {
            place(&mut joint.position_m);
            joint.range_m.iter_mut().for_each(|range| place(range));
            let ways = [&mut joint.home_m, &mut joint.speed_m_s, &mut joint.acceleration_m_s2];
            ways.into_iter().flatten().for_each(|way| *way *= unit);
            if joint.kind != JointType::Prismatic {
                joint.rotor_inertia = joint.rotor_inertia.map(|inertia| inertia * unit * unit);
            }
        }
        let slides = |name: &str| {
            let joint = description.joints.iter().find(|joint| joint.name == name);
            joint.is_some_and(|joint| joint.kind == JointType::Prismatic)
        };
        for limit in &mut description.limits {
            match (slides(&limit.joint), slides(&limit.other)) {
                (false, true) => limit.other_factor /= unit,
                (true, false) => limit.other_factor *= unit,
                _ => {}
            }
            [&mut limit.least_m, &mut limit.most_m]
                .into_iter()
                .flatten()
                .for_each(|way| *way *= unit);
        }
        notes.add(
            NoteKind::Changed,
            format!(
                "lengths by {unit}, and inertia by its square, to metres; masses, efforts, friction and damping stay as \
                 the file has them"
            ),
        );
    }
}
