//! Facts about characters: a skeleton at rest, and its skin.

use std::path::Path;

use glam::DVec3;
use sinew_figure::limb_landmark;
use sinew_figure::measured::{self, Measured, UnitOverrides};
use sinew_figure::pipeline::tpose;
use sinew_pose_metrics::character::{self, Character, Options};
use sinew_retarget::skeleton::SkeletonMatch;

use super::inspected::{Common, Inspected, Kind};
use super::maker;

pub(super) fn character(path: &Path, units: UnitOverrides) -> Result<Inspected, String> {
    let read = |units| character::read(path, &Options { units, frame: None });
    // A character of implausible size is shown nevertheless.
    let (character, refused) = match read(units) {
        Ok(character) => (character, None),
        Err(error) => {
            let as_it_is =
                UnitOverrides { metres_per_unit: units.metres_per_unit.or(Some(1.0)), ..units };
            (read(as_it_is).map_err(|_| error.to_string())?, Some(error))
        }
    };
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let format = match extension.to_str() {
        Some("bin") => "Geno.bin",
        Some("urdf") => "URDF",
        _ => "glTF 2.0",
    };
    let mut inspected = of_character(&character, format, path, units);
    // The first note is the size; doubts about it are reported already.
    for note in character.notes().iter().skip(1) {
        if !inspected.notes.contains(note) {
            inspected.notes.push(note.clone());
        }
    }
    inspected.notes.extend(refused.map(|error| format!("other commands refuse it: {error}")));
    Ok(inspected)
}

pub(super) fn of_character(
    character: &Character,
    format: &'static str,
    path: &Path,
    units: UnitOverrides,
) -> Inspected {
    let rest = character.at_rest();
    let matched = SkeletonMatch::new(&rest.skeleton, &[]);
    let mut measured = Measured::of_format(&rest, &matched);
    if units.up.is_some() {
        "after the turn that you asked for".clone_into(&mut measured.up.reason);
    }
    let common = Common {
        kind: Kind::Character,
        format,
        maker: maker::by_text(path),
        skeleton: &rest.skeleton,
        measured: &measured,
        matched: &matched,
        extents: measured::extents(&rest, DVec3::Y),
    };
    let mut inspected = common.inspected();
    // The reader has converted it to metres.
    if let Some(metres_per_unit) = units.metres_per_unit {
        inspected.metres_per_unit = Some(metres_per_unit);
        "as you specified".clone_into(&mut inspected.unit_reason);
    }
    let rest_m = rest.skeleton.rest_positions_m();
    let joint = |body: &str| matched.joint(limb_landmark(body)?);
    let at = |body: &str| joint(body).map_or(DVec3::NAN, |joint| rest_m[joint]);
    inspected.t_pose = tpose::is_t(at).then_some("at rest");
    if let Some(mesh) = character.mesh() {
        inspected.notes.push(format!(
            "its skin has {} vertices and {} triangles",
            mesh.positions_m.len(),
            mesh.triangles.len()
        ));
    }
    inspected
}
