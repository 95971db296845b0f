//! Characters: joints at rest, and the skin on them if there is one.
//!
//! A reader per kind of file makes a [`Character`]: metres, right-handed, y up. Characters that cannot be
//! are refused here, whatever file they came from; a reader names the place in the file.

mod error;
mod geno;
mod gltf;
mod mocap;
mod size;
mod surface;
mod urdf;

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec3;
use sinew_figure::measured::Told;

pub use error::{Error, Place, Refusal};
pub use surface::VertexArea;

use error::refuse;

/// Far above any character's: what bounds the memory that a small file can ask for.
const JOINT_COUNT_MAX: usize = 1024;

/// A character at rest: joints in the order of the file, and its skin.
#[derive(Debug, Clone, PartialEq)]
pub struct Character {
    name: String,
    joints: Vec<Joint>,
    mesh: Option<Mesh>,
    /// How tall it is, in which unit, and what was overlooked in its file.
    notes: Vec<String>,
}

/// A joint at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// The name, unlike all others of the character.
    pub name: String,
    /// Index of the parent joint, which may come later; `None` for the one root.
    pub parent: Option<usize>,
    /// Where it is in the world, in metres.
    pub position_m: DVec3,
}

/// A skinned triangle mesh in the rest pose.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Every vertex in the world, in metres.
    pub positions_m: Vec<DVec3>,
    /// The joints that each vertex moves with: their indices and shares, which are above 0 and sum to 1.
    pub skin: Vec<Vec<(usize, f64)>>,
    /// The vertices of each triangle.
    pub triangles: Vec<[usize; 3]>,
}

/// What a file does not tell.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// The length of its unit, and which axis points up.
    pub told: Told,
    /// The frame of a motion whose pose is the rest pose; without, all rotations are zero.
    pub frame: Option<usize>,
}

impl Options {
    /// Refuses what only motions have a use for.
    fn ensure_default(&self) -> Result<(), Refusal> {
        let of_motions = "a motion, or this option left out";
        if self.frame.is_some() {
            return Err(refuse("--frame", of_motions, "a file of one pose"));
        }
        Ok(())
    }
}

impl Character {
    /// A character of checked parts.
    ///
    /// # Errors
    /// [`Refusal`] for no joint or too many, names that are not different, parents that are no tree with one root,
    /// numbers that are not finite, and vertices or joints that are not there.
    pub fn new(name: String, joints: Vec<Joint>, mesh: Option<Mesh>) -> Result<Self, Refusal> {
        check_joints(&joints)?;
        if let Some(mesh) = &mesh {
            mesh.check(joints.len())?;
        }
        Ok(Self { name, joints, mesh, notes: Vec::new() })
    }

    /// What it is called: the stem of its file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The joints, in the order of the file.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// The skin.
    pub fn mesh(&self) -> Option<&Mesh> {
        self.mesh.as_ref()
    }

    /// What a person should know of it: its size first.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The bone that ends in a joint, from its parent; `None` for the root.
    pub fn bone_m(&self, joint: usize) -> Option<[DVec3; 2]> {
        let Joint { parent, position_m, .. } = self.joints[joint];
        Some([self.joints[parent?].position_m, position_m])
    }

    /// Length of the bone that ends in a joint; 0 for the root.
    pub fn bone_length_m(&self, joint: usize) -> f64 {
        self.bone_m(joint).map_or(0.0, |[from, to]| from.distance(to))
    }

    /// Index of the joint called `name`.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }
}

/// Larger coordinates are damage: no character is a hundred kilometres large.
pub(crate) const COORDINATE_MAX_M: f64 = 1e5;

/// Longer names are damage, and would make pictures of any width.
const NAME_BYTES_MAX: usize = 256;

/// Whether a place can be one of a character's; NaN cannot.
fn is_place(position_m: DVec3) -> bool {
    position_m.abs().max_element() <= COORDINATE_MAX_M && position_m.is_finite()
}

const A_PLACE: &str = "finite coordinates of at most 100000 m";

fn check_joints(joints: &[Joint]) -> Result<(), Refusal> {
    let count = joints.len();
    if !(1..=JOINT_COUNT_MAX).contains(&count) {
        return Err(refuse("the character", format!("1 to {JOINT_COUNT_MAX} joints"), count));
    }
    let mut places = BTreeMap::new();
    for (index, Joint { name, parent, position_m }) in joints.iter().enumerate() {
        let item = || format!("joint {index} `{name}`");
        if name.len() > NAME_BYTES_MAX {
            let expected = format!("a name of at most {NAME_BYTES_MAX} bytes");
            return Err(refuse(format!("joint {index}"), expected, name.len()));
        }
        if let Some(first) = places.insert(name, index) {
            return Err(refuse(item(), "a name of its own", format!("that of joint {first}")));
        }
        if let Some(parent) = parent.filter(|parent| *parent >= count) {
            return Err(refuse(item(), format!("a parent below {count}"), parent));
        }
        if !is_place(*position_m) {
            return Err(refuse(item(), A_PLACE, position_m));
        }
    }
    let mut roots = joints.iter().filter(|joint| joint.parent.is_none());
    if let (Some(first), Some(second)) = (roots.next(), roots.next()) {
        let found = format!("`{}` and `{}`", first.name, second.name);
        return Err(refuse("the character", "one joint without a parent", found));
    }
    for (index, joint) in joints.iter().enumerate() {
        // A way that is longer than the character goes round in it; without a root every way does.
        let way = std::iter::successors(joint.parent, |parent| joints[*parent].parent);
        if way.take(count).count() == count {
            let item = format!("joint {index} `{}`", joint.name);
            return Err(refuse(item, "ancestors that end at a root", "a loop of parents"));
        }
    }
    Ok(())
}

impl Mesh {
    fn check(&self, joints: usize) -> Result<(), Refusal> {
        let Self { positions_m, skin, triangles } = self;
        if skin.len() != positions_m.len() {
            return Err(refuse(
                "the mesh",
                format!("skin of {} vertices", positions_m.len()),
                skin.len(),
            ));
        }
        for (vertex, (position_m, shares)) in positions_m.iter().zip(skin).enumerate() {
            let item = || format!("vertex {vertex}");
            if !is_place(*position_m) {
                return Err(refuse(item(), A_PLACE, position_m));
            }
            if let Some((joint, _)) = shares.iter().find(|(joint, _)| *joint >= joints) {
                return Err(refuse(item(), format!("joints below {joints}"), joint));
            }
            let sum: f64 = shares.iter().map(|(_, share)| share).sum();
            if !((sum - 1.0).abs() < 1e-6 && shares.iter().all(|(_, share)| *share > 0.0)) {
                return Err(refuse(item(), "shares above 0 that sum to 1", sum));
            }
        }
        for (index, triangle) in triangles.iter().enumerate() {
            if let Some(vertex) = triangle.iter().find(|vertex| **vertex >= positions_m.len()) {
                let expected = format!("vertices below {}", positions_m.len());
                return Err(refuse(format!("triangle {index}"), expected, vertex));
            }
        }
        Ok(())
    }
}

/// How far stored shares may sum from 1: eight of eight bits, each rounded.
const SHARE_ROUNDING: f64 = 0.02;

/// Larger shares are damage: writers that do not divide by the sum have at most a few times 1.
const SHARE_MAX: f64 = 1e3;

/// The shares of a vertex as a file stores them: those above 0, made to sum to exactly 1; and whether they did but for
/// rounding.
fn shares(
    stored: impl IntoIterator<Item = (usize, f64)>,
) -> Result<(Vec<(usize, f64)>, bool), Refusal> {
    let mut shares: Vec<(usize, f64)> = Vec::new();
    for (joint, share) in stored {
        if !(0.0..=SHARE_MAX).contains(&share) {
            return Err(refuse("weight", "a number from 0 to 1000", share));
        }
        if share > 0.0 {
            shares.push((joint, share));
        }
    }
    let sum = shares.iter().fold(0.0, |sum, (_, share)| sum + share);
    if sum <= 0.0 {
        return Err(refuse("weights", "a sum of 1", sum));
    }
    let is_one = (sum - 1.0).abs() <= SHARE_ROUNDING;
    Ok((shares.into_iter().map(|(joint, share)| (joint, share / sum)).collect(), is_one))
}

/// The files that [`read`] knows, for messages.
pub const NAMES: &str = "Geno.bin, *.glb, *.gltf, *.vrm, *.urdf, *.bvh, *.amc or humanoid3d_*.txt";

/// Reads the character in a file, of the kind that its name says, or else its content.
///
/// # Errors
/// [`Error`], which names the file, and the place in it.
pub fn read(path: &Path, options: &Options) -> Result<Character, Error> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let kind = extension.to_str();
    let of_format = |character: Character| {
        // URDF has z up, and its reader has turned that: what is told is told of the file's axes.
        let up = if kind == Some("urdf") { urdf::in_character } else { |axis| axis };
        let refused = |refusal| Error::Refused { file: path.to_path_buf(), refusal };
        size::of_format(character, options.told, up, kind == Some("urdf")).map_err(refused)
    };
    if matches!(kind, Some("bin" | "glb" | "gltf" | "vrm" | "urdf")) {
        options
            .ensure_default()
            .map_err(|refusal| Error::Refused { file: path.to_path_buf(), refusal })?;
    }
    match kind {
        Some("bin") => parsed(path, geno::parse).and_then(of_format),
        Some("glb" | "gltf" | "vrm") => {
            parsed(path, |bytes, name| gltf::parse(bytes, name, folder)).and_then(of_format)
        }
        Some("urdf") => parsed(path, urdf::parse).and_then(of_format),
        _ => mocap::read(path, options),
    }
}

/// Reads a file whole and parses it; the character is called after the file's stem.
fn parsed(
    path: &Path,
    parse: impl FnOnce(&[u8], String) -> Result<Character, Refusal>,
) -> Result<Character, Error> {
    let file = path.to_path_buf();
    let bytes = sinew_mocap::read::bytes(path)
        .map_err(|source| Error::Io { file: file.clone(), source })?;
    parse(&bytes, stem(path)).map_err(|refusal| Error::Refused { file, refusal })
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests;
