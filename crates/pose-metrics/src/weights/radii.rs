//! Radii of the bones' cylinders.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::Deserialize;

use super::error::Error;
use crate::character::{COORDINATE_MAX_M, Character, VertexArea};

/// The source of the cylinders' radii. The cylinder of a joint is the bone that ends in it.
#[derive(Debug, Clone, PartialEq)]
pub enum Radii {
    /// Estimated from the mesh, see [`of_mesh_m`]; for bones without skin, [`PER_LENGTH`] of their lengths.
    Estimated,
    /// One radius for all bones, m.
    Uniform(f64),
    /// Radii from a file, see [`read`].
    Given(RadiusTable),
}

/// The radii in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct RadiusTable {
    file: PathBuf,
    /// Line number and radius, by the joint at the end of the bone.
    rows: BTreeMap<String, (u64, f64)>,
}

/// Radius per length of a bone without further information.
///
/// Ratios from 0.03 to 0.4 were tried. This ratio gives the smallest difference from the article's list for Geno: the
/// weights differ by 24 % (root mean square of the logarithms); the weight of the neck, a thick short bone, is 62 % too
/// small.
pub const PER_LENGTH: f64 = 0.25;

/// Length below which a bone has no direction and no surface.
const LENGTH_MIN_M: f64 = 1e-6;

impl Radii {
    /// Returns the radius of the bone that ends in each joint, in m; 0 for the root and for bones without length.
    ///
    /// # Errors
    /// [`Error`] for a radius that is negative, not finite or larger than any character, a joint of the file that
    /// the character lacks, and a bone of the character that the file lacks.
    pub fn of(&self, character: &Character) -> Result<Vec<f64>, Error> {
        match self {
            Self::Estimated => Ok(estimated_m(character)),
            Self::Uniform(radius_m) => {
                if !is_radius(*radius_m) {
                    let (name, expected) = ("radii", A_RADIUS);
                    return Err(Error::Setting { name, expected, found: *radius_m });
                }
                let radius_m = |joint| if has_bone(character, joint) { *radius_m } else { 0.0 };
                Ok((0..character.joints().len()).map(radius_m).collect())
            }
            Self::Given(given) => given.of(character),
        }
    }
}

const A_RADIUS: &str = "metres from 0 to 100000";

/// Returns whether a radius is plausible: at most the maximum coordinate of a character. False for NaN.
fn is_radius(radius_m: f64) -> bool {
    (0.0..=COORDINATE_MAX_M).contains(&radius_m)
}

fn has_bone(character: &Character, joint: usize) -> bool {
    character.bone_length_m(joint) > LENGTH_MIN_M
}

#[derive(Deserialize)]
struct Row {
    joint: String,
    radius_m: Option<f64>,
}

/// Reads radii from a CSV with the columns `joint` and `radius_m`, in any order and possibly with further columns,
/// as [`super::table::csv`] writes it. A row without a radius is ignored.
///
/// # Errors
/// [`Error::RadiusFile`] and [`Error::RadiusColumns`] if it is not a table of radii, [`Error::RadiusRow`] for a
/// radius that is negative, not finite or larger than any character, and for a joint that occurs twice.
pub fn read(file: &Path) -> Result<RadiusTable, Error> {
    let in_file = |source| Error::RadiusFile { file: file.to_path_buf(), source };
    let mut reader = csv::Reader::from_path(file).map_err(in_file)?;
    let mut rows = BTreeMap::new();
    let headers = reader.headers().map_err(in_file)?.clone();
    if !["joint", "radius_m"].iter().all(|name| headers.iter().any(|column| column == *name)) {
        let found = headers.iter().collect::<Vec<_>>().join(", ");
        return Err(Error::RadiusColumns { file: file.to_path_buf(), found });
    }
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(in_file)? {
        let line = record.position().map_or(0, csv::Position::line);
        let Row { joint, radius_m } = record.deserialize(Some(&headers)).map_err(in_file)?;
        let Some(radius_m) = radius_m else { continue };
        let refuse = |expected: &str, found: String| {
            let (file, expected) = (file.to_path_buf(), expected.to_owned());
            Err(Error::RadiusRow { file, line, joint: joint.clone(), expected, found })
        };
        if !is_radius(radius_m) {
            return refuse(A_RADIUS, format!("{radius_m:?}"));
        }
        if let Some((first, _)) = rows.insert(joint.clone(), (line, radius_m)) {
            return refuse("each joint once", format!("it in line {first} too"));
        }
    }
    Ok(RadiusTable { file: file.to_path_buf(), rows })
}

impl RadiusTable {
    fn of(&self, character: &Character) -> Result<Vec<f64>, Error> {
        for (joint, (line, _)) in &self.rows {
            if character.find(joint).is_none() {
                return Err(Error::RadiusRow {
                    file: self.file.clone(),
                    line: *line,
                    joint: joint.clone(),
                    expected: format!("a joint of {}", character.name()),
                    found: "none of this name".into(),
                });
            }
        }
        let joints = character.joints();
        let row = |joint: usize| self.rows.get(&joints[joint].name).map(|(_, radius_m)| *radius_m);
        let mut missing =
            (0..joints.len()).filter(|joint| has_bone(character, *joint) && row(*joint).is_none());
        if let Some(first) = missing.next() {
            let (file, joint) = (self.file.clone(), joints[first].name.clone());
            return Err(Error::RadiusMissing { file, joint, more: missing.count() });
        }
        Ok((0..joints.len()).map(|joint| row(joint).unwrap_or(0.0)).collect())
    }
}

fn estimated_m(character: &Character) -> Vec<f64> {
    let by_mesh_m = of_mesh_m(character);
    let radius_m = |(joint, by_mesh_m): (usize, Option<f64>)| {
        by_mesh_m.unwrap_or_else(|| PER_LENGTH * character.bone_length_m(joint))
    };
    by_mesh_m.into_iter().enumerate().map(radius_m).collect()
}

/// Returns the radius of the bone that ends in each joint, estimated from the skin around it, in m; `None` without
/// skin or bone.
///
/// The radius is the mean distance between the bone's axis and the skin that moves with the joint at the bone's start,
/// weighted by area and by the skin's weight for that joint. If several bones start at the joint, skin counts for the
/// nearest bone. If no bone starts at the joint, its skin counts for the bone that ends there.
///
/// For Geno the resulting cylinders give weights within 10 % of the article's (root mean square of the logarithms); for
/// the toes, which are flat, within 33 %. Other estimates differ from the same list by 10 % (median distance), 12 %
/// (distance from the bone instead of its axis), 11 % (only the skin beside the bone) and 24 % (radii of equal
/// surface).
pub fn of_mesh_m(character: &Character) -> Vec<Option<f64>> {
    let mut sums = vec![(0.0, 0.0); character.joints().len()];
    if let Some(mesh) = character.mesh() {
        let bones = bones_of(character);
        let vertices = mesh.positions_m.iter().zip(&mesh.skin);
        for ((position_m, skin), area_m2) in vertices.zip(mesh.vertex_areas_m2(VertexArea::Surface))
        {
            for (joint, share) in skin {
                let nearest = bones[*joint]
                    .iter()
                    .min_by(|a, b| a.distance_m(*position_m).total_cmp(&b.distance_m(*position_m)));
                let Some(bone) = nearest else { continue };
                let (sum_m3, sum_m2) = &mut sums[bone.end];
                *sum_m3 += area_m2 * share * bone.axis_distance_m(*position_m);
                *sum_m2 += area_m2 * share;
            }
        }
    }
    let mean = |(sum_m3, sum_m2)| (sum_m2 > 0.0).then(|| sum_m3 / sum_m2);
    sums.into_iter().map(mean).collect()
}

/// A bone of non-zero length.
struct Bone {
    /// Joint at the end of the bone.
    end: usize,
    from_m: DVec3,
    /// Vector to the end of the bone.
    along_m: DVec3,
}

impl Bone {
    fn new(character: &Character, end: usize) -> Option<Self> {
        let [from_m, to_m] = character.bone_m(end)?;
        has_bone(character, end).then(|| Self { end, from_m, along_m: to_m - from_m })
    }

    /// Returns the distance of a point from the bone.
    fn distance_m(&self, point_m: DVec3) -> f64 {
        let from_m = point_m - self.from_m;
        let place = from_m.dot(self.along_m) / self.along_m.length_squared();
        (from_m - place.clamp(0.0, 1.0) * self.along_m).length()
    }

    /// Returns the distance of a point from the infinite line through the bone.
    fn axis_distance_m(&self, point_m: DVec3) -> f64 {
        (point_m - self.from_m).reject_from(self.along_m).length()
    }
}

/// Returns, for each joint, the bones that its skin surrounds: those that start there, or else the bone that ends
/// there.
fn bones_of(character: &Character) -> Vec<Vec<Bone>> {
    let joints = character.joints();
    let mut bones: Vec<Vec<Bone>> = joints.iter().map(|_| Vec::new()).collect();
    for (end, joint) in joints.iter().enumerate() {
        if let (Some(parent), Some(bone)) = (joint.parent, Bone::new(character, end)) {
            bones[parent].push(bone);
        }
    }
    for (joint, bones) in bones.iter_mut().enumerate() {
        if bones.is_empty() {
            bones.extend(Bone::new(character, joint));
        }
    }
    bones
}
