//! Reads masses of an MJCF's bodies, from `inertial` or from geoms.

use glam::{DMat3, DQuat, DVec3};
use roxmltree::Node;

use super::super::mass::MASS_MIN_KG;
use super::super::note::Notes;
use super::super::solid::Solid;
use super::super::xml;
use super::defaults::Element;
use super::model::Model;
use super::parts::Parts;
use super::pose::Pose;
use crate::description::mass::Mass;
use crate::import::error::ImportError;
use crate::import::note::NoteKind;

/// Default density of a geom, kg/m³: that of water.
const DENSITY: f64 = 1000.0;

/// Returns the mass of a body, in its own frame.
pub(super) fn of_body(
    parts: &Parts<'_, '_>,
    name: &str,
    model: &Model<'_, '_, '_>,
    notes: &mut Notes,
) -> Result<Mass, ImportError> {
    let rules = &model.masses;
    let inertial = parts.inertial.filter(|_| rules.from_geoms != Some(true));
    let mut mass = match inertial {
        Some((node, frame)) => of_inertial(node, frame, name, model, notes)?,
        None if rules.from_geoms == Some(false) => Mass::point(0.0),
        None => of_geoms(parts, name, model, notes)?,
    };
    if mass.kg < rules.least_kg {
        let text = format!("now weighs {} kg, by the compiler's boundmass", rules.least_kg);
        notes.add_of(NoteKind::Changed, text, name);
        mass.kg = rules.least_kg;
    }
    if mass.kg > 0.0 && mass.kg < MASS_MIN_KG {
        let text =
            format!("weighs {:e} kg, which looks like a placeholder; taken as it is", mass.kg);
        notes.add_of(NoteKind::Doubtful, text, name);
    }
    let Some(fault) = mass.fault() else { return Ok(mass) };
    if rules.balance || model.options.repair_inertia {
        let text = format!("has {fault}; now the inertia of a ball with the same sum of moments");
        notes.add_of(NoteKind::Changed, text, name);
        return Ok(mass.balanced());
    }
    let expected = "inertia that a body can have; or the option repair-inertia";
    let node = inertial.map_or(parts.node, |(node, _)| node);
    Err(xml::refuse(node, expected, format!("{fault}, with {} kg", mass.kg)))
}

fn of_inertial(
    node: Node<'_, '_>,
    frame: Pose,
    name: &str,
    model: &Model<'_, '_, '_>,
    notes: &mut Notes,
) -> Result<Mass, ImportError> {
    xml::required(node, "mass")?;
    let kg = xml::not_negative(node, "mass")?.unwrap_or(0.0);
    let pose = frame.then(model.angles.pose(node)?);
    let diagonal: Option<[f64; 3]> = xml::vector(node, "diaginertia")?;
    let full: Option<[f64; 6]> = xml::vector(node, "fullinertia")?;
    let inertia_kg_m2 = match (diagonal, full) {
        (Some(_), Some(_)) => {
            return Err(xml::refuse_value(node, "fullinertia", "no diaginertia beside it"));
        }
        (Some(diagonal), None) => DMat3::from_diagonal(diagonal.into()),
        (None, Some([xx, yy, zz, xy, xz, yz])) => {
            DMat3::from_cols_array_2d(&[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        }
        (None, None) => DMat3::ZERO,
    };
    let mass = Mass { kg, center_m: DVec3::ZERO, inertia_kg_m2 };
    if kg >= MASS_MIN_KG && mass.matrix().is_none() {
        notes.add_of(NoteKind::Doubtful, "has mass but no inertia, as a point has", name);
    }
    Ok(mass.seen_from(pose.rotation, pose.position_m))
}

fn of_geoms(
    parts: &Parts<'_, '_>,
    name: &str,
    model: &Model<'_, '_, '_>,
    notes: &mut Notes,
) -> Result<Mass, ImportError> {
    let mut sum = Mass::point(0.0);
    for (geom, frame) in &parts.geoms {
        let group = geom.number("group")?.unwrap_or(0.0);
        let [first, last] = model.masses.groups;
        let own_kg = geom.text("mass").map(|_| geom.not_negative("mass")).transpose()?;
        let density = geom.number("density")?.unwrap_or(DENSITY);
        let weighs = own_kg.map_or(density > 0.0, |kg| kg > 0.0);
        if group < first || group > last || !weighs {
            continue;
        }
        let Some((solid, pose)) = solid(geom, model)? else {
            if matches!(geom.text("type"), Some("plane" | "hfield")) {
                continue;
            }
            if !model.options.repair_inertia {
                let expected = "an `inertial` in the body, or geoms that are solids (sphere, capsule, cylinder, box, \
                                ellipsoid), since meshes are not read; or the option repair-inertia";
                return Err(xml::refuse(
                    geom.node(),
                    expected,
                    "a mesh that makes the body's mass",
                ));
            }
            let pose = frame.then(model.angles.pose_of(geom)?);
            let text = match own_kg {
                Some(_) => "has a mesh that makes its mass: that of a point where the mesh is",
                None => "has a mesh that makes its mass, which is not known: left out",
            };
            notes.add_of(NoteKind::Filled, text, name);
            sum = sum
                .plus(Mass::point(own_kg.unwrap_or(0.0)).seen_from(pose.rotation, pose.position_m));
            continue;
        };
        let kg = own_kg.unwrap_or(density * solid.volume_m3());
        if geom.text("shellinertia") == Some("true") {
            let text = "has a hollow geom (shellinertia): its inertia is that of a full one";
            notes.add_of(NoteKind::Doubtful, text, name);
        }
        let pose = frame.then(pose);
        sum = sum.plus(solid.filled(kg).seen_from(pose.rotation, pose.position_m));
    }
    Ok(sum)
}

/// Returns the solid of a geom and its pose; `None` for a geom that is not a solid, such as a mesh.
pub(super) fn solid(
    geom: &Element<'_, '_>,
    model: &Model<'_, '_, '_>,
) -> Result<Option<(Solid, Pose)>, ImportError> {
    let kind = geom.text("type").unwrap_or("sphere");
    let count = match kind {
        _ if geom.text("mesh").is_some() => return Ok(None),
        "sphere" => 1,
        "capsule" | "cylinder" => 2,
        "box" | "ellipsoid" => 3,
        _ => return Ok(None),
    };
    let mut size = xml::numbers(geom.at("size"), "size", 3)?.unwrap_or_default();
    let mut pose = model.angles.pose_of(geom)?;
    let ends: Option<[f64; 6]> = geom.vector("fromto")?;
    if let Some([a, b, c, d, e, f]) = ends.filter(|_| count > 1) {
        let (from, to) = (DVec3::new(a, b, c), DVec3::new(d, e, f));
        let Some(along) = (from - to).try_normalize() else {
            return Err(xml::refuse_value(geom.at("fromto"), "fromto", "two points that differ"));
        };
        pose.position_m = (from + to) / 2.0;
        pose.rotation = DQuat::from_rotation_arc(DVec3::Z, along);
        // Both transverse dimensions are the first size.
        let radius = size.first().copied().unwrap_or(0.0);
        size = vec![radius; count - 1];
        size.push(from.distance(to) / 2.0);
    }
    let sizes = size.get(..count).filter(|sizes| sizes.iter().all(|size| *size > 0.0));
    let solid = match (kind, sizes) {
        (_, None) => {
            let expected = format!("{count} sizes above zero, of a {kind}");
            return Err(xml::refuse_value(geom.at("size"), "size", expected));
        }
        ("capsule", Some(&[r, half])) => Solid::Capsule(r, 2.0 * half),
        ("cylinder", Some(&[r, half])) => Solid::Cylinder(r, 2.0 * half),
        ("box", Some(&[x, y, z])) => Solid::Box(2.0 * DVec3::new(x, y, z)),
        (_, Some(&[x, y, z])) => Solid::Ellipsoid(DVec3::new(x, y, z)),
        (_, Some(sizes)) => Solid::Ellipsoid(DVec3::splat(sizes.first().copied().unwrap_or(0.0))),
    };
    Ok(Some((solid, pose)))
}
