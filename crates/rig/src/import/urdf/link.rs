//! Reads links of a URDF and their masses.

use glam::DVec3;
use roxmltree::Node;

use super::super::mass::MASS_MIN_KG;
use super::super::note::{Notes, list};
use super::super::solid::Solid;
use super::super::xml;
use super::joint::origin;
use super::shapes;
use crate::description::Body;
use crate::description::mass::Mass;
use crate::import::error::ImportError;
use crate::import::note::NoteKind;

/// Reads the bodies of links. `balance` replaces impossible inertia; `points` replaces missing inertia by that of a
/// point.
pub(super) fn bodies(
    links: &[Node<'_, '_>],
    balance: bool,
    points: bool,
    notes: &mut Notes,
) -> Result<Vec<Body>, ImportError> {
    let mut bodies = Vec::new();
    // All errors are reported at once, so that a user can repair all bodies in one pass.
    let mut refused: Vec<(ImportError, &str)> = Vec::new();
    for link in links {
        let name = link.attribute("name").unwrap_or_default();
        match mass_properties(*link, balance, points, notes) {
            Ok(mass) => {
                bodies.push(Body { shapes: shapes::of_link(*link), ..mass.body(name) });
            }
            Err(error) => refused.push((error, name)),
        }
    }
    let mut refused = refused.into_iter();
    let Some((mut first, _)) = refused.next() else { return Ok(bodies) };
    let others: Vec<&str> = refused.map(|(_, name)| name).collect();
    if !others.is_empty() {
        first.found.push_str("; also refused: ");
        first.found.push_str(&list(&others));
    }
    Err(first)
}

fn mass_properties(
    link: Node<'_, '_>,
    balance: bool,
    points: bool,
    notes: &mut Notes,
) -> Result<Mass, ImportError> {
    let name = link.attribute("name").unwrap_or_default();
    let Some(inertial) = xml::child(link, "inertial")? else {
        notes.add_of(NoteKind::Changed, "has no `inertial`: a frame without mass", name);
        return Ok(Mass::point(0.0));
    };
    let mass_node = xml::child(inertial, "mass")?
        .ok_or_else(|| xml::refuse(inertial, "an element `mass`", "none"))?;
    xml::required(mass_node, "value")?;
    let mass_kg = xml::not_negative(mass_node, "value")?.unwrap_or(0.0);
    if mass_kg > 0.0 && mass_kg < MASS_MIN_KG {
        let text = format!("weighs {mass_kg:e} kg, which looks like a placeholder; taken as it is");
        notes.add_of(NoteKind::Doubtful, text, name);
    }
    let (position, rotation) = origin(inertial)?;
    let inertia = xml::child(inertial, "inertia")?;
    let Some(inertia) = inertia else {
        let mut mass = fill(link, inertial, mass_kg, points, notes)?;
        if xml::child(inertial, "origin")?.is_some() {
            mass.center_m = position;
        }
        return Ok(mass);
    };
    let moment = |name| {
        xml::required(inertia, name)?;
        Ok::<_, ImportError>(xml::number(inertia, name)?.unwrap_or(0.0))
    };
    let product = |name| Ok::<_, ImportError>(xml::number(inertia, name)?.unwrap_or(0.0));
    let (xx, yy, zz) = (moment("ixx")?, moment("iyy")?, moment("izz")?);
    let (xy, xz, yz) = (product("ixy")?, product("ixz")?, product("iyz")?);
    let inertia_kg_m2 = glam::DMat3::from_cols(
        DVec3::new(xx, xy, xz),
        DVec3::new(xy, yy, yz),
        DVec3::new(xz, yz, zz),
    );
    let mass = Mass { kg: mass_kg, center_m: DVec3::ZERO, inertia_kg_m2 };
    let mass = mass.seen_from(rotation, position);
    if mass_kg >= MASS_MIN_KG && mass.matrix().is_none() {
        notes.add_of(NoteKind::Doubtful, "has mass but no inertia, as a point has", name);
    }
    match mass.fault() {
        None => Ok(mass),
        Some(fault) if balance => {
            let text =
                format!("has {fault}; now the inertia of a ball with the same sum of moments");
            notes.add_of(NoteKind::Changed, text, name);
            Ok(mass.balanced())
        }
        Some(fault) => {
            // All six elements as in the file: the diagonal alone may look correct although the principal moments
            // are wrong.
            let found = format!(
                "{fault}: {mass_kg} kg; ixx {xx:e}, iyy {yy:e}, izz {zz:e}, ixy {xy:e}, ixz {xz:e}, iyz {yz:e} kg m²"
            );
            let expected = "inertia that a body can have; or the option repair-inertia";
            Err(xml::refuse(inertia, expected, found))
        }
    }
}

/// Computes inertia for a given mass from the link's solids at uniform density: those of `collision`, otherwise of
/// `visual`. Without solids, returns a point mass if `points` is true, otherwise fails.
fn fill(
    link: Node<'_, '_>,
    inertial: Node<'_, '_>,
    mass_kg: f64,
    points: bool,
    notes: &mut Notes,
) -> Result<Mass, ImportError> {
    let name = link.attribute("name").unwrap_or_default();
    for shapes in ["collision", "visual"] {
        let solids: Vec<_> = xml::children(link, shapes).map(solid).collect::<Result<_, _>>()?;
        // If one shape is a mesh, the other shapes are not the whole body.
        let Some(solids) = solids.into_iter().collect::<Option<Vec<_>>>() else { continue };
        let volume_m3: f64 = solids.iter().map(|(solid, _)| solid.volume_m3()).sum();
        if volume_m3 <= 0.0 {
            continue;
        }
        let parts = solids.iter().map(|(solid, (position, rotation))| {
            let share_kg = mass_kg * solid.volume_m3() / volume_m3;
            solid.filled(share_kg).seen_from(*rotation, *position)
        });
        let text = format!("has mass but no `inertia`: that of its {shapes} solids, evenly filled");
        notes.add_of(NoteKind::Filled, text, name);
        return Ok(parts.fold(Mass::point(0.0), Mass::plus));
    }
    if points || mass_kg <= 0.0 {
        if mass_kg > 0.0 {
            let text = "has mass but no `inertia`, and no solids to fill it from: that of a point";
            notes.add_of(NoteKind::Filled, text, name);
        }
        return Ok(Mass::point(mass_kg));
    }
    let expected = "an element `inertia`, or solids (box, cylinder, sphere, capsule) to fill it from, since meshes are \
                    not read; or the option repair-inertia, for a point";
    Err(xml::refuse(inertial, expected, "neither"))
}

/// Returns the solid of a `collision` or `visual` and its pose; `None` for a mesh or an empty element.
#[expect(clippy::type_complexity, reason = "a solid and its pose, used once")]
pub(super) fn solid(
    shape: Node<'_, '_>,
) -> Result<Option<(Solid, (DVec3, glam::DQuat))>, ImportError> {
    let Some(geometry) = xml::child(shape, "geometry")? else { return Ok(None) };
    let Some(node) = geometry.children().find(Node::is_element) else { return Ok(None) };
    let length = |name| {
        xml::required(node, name)?;
        Ok::<_, ImportError>(xml::not_negative(node, name)?.unwrap_or(0.0))
    };
    let solid = match node.tag_name().name() {
        "box" => {
            let edges = DVec3::from(xml::vector(node, "size")?.unwrap_or_default());
            if edges.min_element() <= 0.0 {
                return Err(xml::refuse_value(node, "size", "three lengths above zero"));
            }
            Solid::Box(edges)
        }
        "sphere" => Solid::Ellipsoid(DVec3::splat(length("radius")?)),
        "cylinder" => Solid::Cylinder(length("radius")?, length("length")?),
        "capsule" => Solid::Capsule(length("radius")?, length("length")?),
        _ => return Ok(None),
    };
    Ok(Some((solid, origin(shape)?)))
}
