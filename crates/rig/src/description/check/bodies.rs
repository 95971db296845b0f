//! Checks masses and inertias.

use super::part::{Part, Sign, shown};
use crate::description::error::{DescriptionError, Step};
use crate::description::{Body, BodyShape, InertiaMatrix, ShapeKind};

/// Tolerance for rounding, as a fraction of the trace. It is half the tolerance of `sinew-core`
/// ([`sinew_core::Inertia::validate`]), so that an accepted inertia is accepted there too, in f32 and after bodies
/// are merged.
const ROUNDING: f64 = 5e-6;

pub(super) fn check(part: Part<'_>, body: &Body) -> Result<(), DescriptionError> {
    part.number(&[Step::Key("mass_kg")], body.mass_kg, Sign::NotNegative)?;
    let center = [Step::Key("center_of_mass_m")];
    part.numbers(&center, &body.center_of_mass_m, Sign::Any)?;
    if let Some(size_m) = &body.box_m {
        let at = [Step::Key("box_m")];
        part.numbers(&at, size_m, Sign::NotNegative)?;
        if body.inertia_kg_m2.is_some() {
            let expected = "either inertia_kg_m2 or box_m";
            return Err(part.refuse(&at, expected, "both"));
        }
        if body.mass_kg <= 0.0 {
            return Err(part.refuse(&at, "mass_kg above 0 beside a box", "a box without mass"));
        }
    }
    for (index, shape) in body.shapes.iter().enumerate() {
        check_shape(part, index, shape)?;
    }
    body.inertia_kg_m2.as_ref().map_or(Ok(()), |inertia| check_inertia(part, body, inertia))
}

/// Refuses a solid that lacks a length of its kind, has a length that its kind does not have, or whose position,
/// rotation or colour is invalid.
fn check_shape(part: Part<'_>, index: usize, shape: &BodyShape) -> Result<(), DescriptionError> {
    let at = |key| [Step::Key("shape"), Step::Index(index), Step::Key(key)];
    let size = shape.size_m.as_ref().map(<[f64; 3]>::as_slice);
    let [radius, length] =
        [&shape.radius_m, &shape.length_m].map(|x| x.as_ref().map(std::slice::from_ref));
    let (kind, needs) = match shape.kind {
        ShapeKind::Box => ("box", [true, false, false]),
        ShapeKind::Sphere => ("sphere", [false, true, false]),
        ShapeKind::Cylinder => ("cylinder", [false, true, true]),
        ShapeKind::Capsule => ("capsule", [false, true, true]),
    };
    let keys = [("size_m", size), ("radius_m", radius), ("length_m", length)];
    for ((key, values), is_needed) in keys.into_iter().zip(needs) {
        match values {
            Some(values) if is_needed => {
                for value in values {
                    part.number(&at(key), *value, Sign::Positive)?;
                }
            }
            Some(_) => {
                return Err(part.refuse(&at(key), format!("no such length of a {kind}"), "one"));
            }
            None if is_needed => {
                return Err(part.refuse(&at(key), format!("the length of a {kind}"), "nothing"));
            }
            None => {}
        }
    }
    part.numbers(&at("position_m"), &shape.position_m, Sign::Any)?;
    part.unit_length_at(&at("rotation_xyzw"), &shape.rotation_xyzw)?;
    let color = shape.color_rgb.unwrap_or_default();
    if color.iter().all(|share| (0.0..=1.0).contains(share)) {
        return Ok(());
    }
    let found = crate::number::list_text(&color);
    Err(part.refuse(&at("color_rgb"), "three numbers from 0 to 1", found))
}

fn check_inertia(
    part: Part<'_>,
    body: &Body,
    inertia: &InertiaMatrix,
) -> Result<(), DescriptionError> {
    let at = [Step::Key("inertia_kg_m2")];
    let InertiaMatrix { xx, xy, xz, yy, yz, zz } = *inertia;
    for (key, value) in [("xy", xy), ("xz", xz), ("yz", yz)] {
        part.number(&[at[0], Step::Key(key)], value, Sign::Any)?;
    }
    for (key, value) in [("xx", xx), ("yy", yy), ("zz", zz)] {
        part.number(&[at[0], Step::Key(key)], value, Sign::NotNegative)?;
    }
    let size = [xx, xy, xz, yy, yz, zz].iter().fold(0.0_f64, |size, x| size.max(x.abs()));
    if size <= 0.0 {
        return Ok(());
    }
    if body.mass_kg <= 0.0 {
        let found = format!("inertia up to {} without mass", shown(&at, size));
        return Err(part.refuse(&at, "mass_kg above 0 beside an inertia", found));
    }
    if is_possible(inertia) {
        return Ok(());
    }
    let expected = "an inertia that a body can have: each principal moment from 0 to the sum of the other two \
                    (kg m², about the centre of mass)";
    let found = format!(
        "xx {}, yy {}, zz {}; xy {}, xz {}, yz {}",
        shown(&at, xx),
        shown(&at, yy),
        shown(&at, zz),
        shown(&at, xy),
        shown(&at, xz),
        shown(&at, yz)
    );
    Err(part.refuse(&at, expected, found))
}

/// Returns whether the second moments of mass `Σ = tr(I)/2 - I` are positive semidefinite up to [`ROUNDING`]
/// (Wensing, Kim & Slotine 2018). Tests `Σ / tr(I) + ROUNDING` for positive definiteness, by Sylvester's criterion.
/// This bounds the eigenvalues, therefore rotated and added inertias pass too.
pub(crate) fn is_possible(inertia: &InertiaMatrix) -> bool {
    let InertiaMatrix { xx, xy, xz, yy, yz, zz } = *inertia;
    let trace = xx + yy + zz;
    if trace <= 0.0 {
        return false;
    }
    let [a, b, c] = [xx, yy, zz].map(|moment| 0.5 - moment / trace + ROUNDING);
    let [d, e, f] = [xy, xz, yz].map(|product| -product / trace);
    let minors =
        [a, a * b - d * d, a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e)];
    minors.iter().all(|minor| *minor > 0.0)
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DQuat};

    use super::*;

    fn turned(moments: [f64; 3], rotation: DQuat) -> InertiaMatrix {
        let r = DMat3::from_quat(rotation);
        let m = r * DMat3::from_diagonal(moments.into()) * r.transpose();
        InertiaMatrix {
            xx: m.x_axis.x,
            xy: m.y_axis.x,
            xz: m.z_axis.x,
            yy: m.y_axis.y,
            yz: m.z_axis.y,
            zz: m.z_axis.z,
        }
    }

    #[test]
    fn rods_and_plates_pass_however_they_are_turned_and_worse_does_not() {
        for step in 0..100 {
            let angle = f64::from(step) * 0.37;
            let axis = glam::DVec3::new(angle.sin(), angle.cos(), 0.3).normalize();
            let rotation = DQuat::from_axis_angle(axis, angle);
            for moments in [[1e-5, 1e-5, 0.0], [1.0, 1.0, 2.0], [3.0, 3.0, 3.0]] {
                assert!(is_possible(&turned(moments, rotation)), "{moments:?} {angle}");
            }
            // 0.1 % beyond a plate, 200 times the tolerance.
            assert!(!is_possible(&turned([1.0, 1.0, 2.004], rotation)), "{angle}");
        }
    }
}
