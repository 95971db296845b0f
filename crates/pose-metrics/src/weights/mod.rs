//! How much each joint of a character matters: what `core` needs to weigh it, and its tables.
//!
//! All numbers are `core`'s ([`sinew_core::importance`]). Bones and surfaces are measured here, in f64; what is weighed
//! is f32.

mod error;
mod limits;
pub mod radii;
pub mod table;

use std::fmt::{self, Display};

use glam::DVec3;
use serde::Serialize;
use sinew_core::glam::Vec3;
use sinew_core::importance::{
    Importance, MeshSurface, RestPose, cylinder_surface, descendants_length,
};

use crate::character::{Character, VertexArea};
pub use error::Error;
pub use limits::JOINT_COUNT_MAX;
use radii::Radii;

/// What a joint is weighed by. After D. Holden, "Joint Error Propagation" (2025).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The length of the bones that hang on it.
    Lengths,
    /// The surface of the bones that hang on it, as cylinders, and how far away it is.
    Cylinders,
    /// The skin that moves with it, and how far away that is.
    Mesh,
}

impl Method {
    /// All, in the order in which they are shown.
    pub const ALL: [Self; 3] = [Self::Lengths, Self::Cylinders, Self::Mesh];

    /// The name in tables and files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lengths => "lengths",
            Self::Cylinders => "cylinders",
            Self::Mesh => "mesh",
        }
    }

    /// The unit of the weights before they are normalised, and so of the base.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Lengths => "m",
            Self::Cylinders | Self::Mesh => "m³",
        }
    }
}

impl Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// How joints are weighed.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The weight that every joint begins with, in the method's unit; without, [`Settings::base_of`] tells.
    pub base: Option<f64>,
    /// What a bone still counts one joint further up, by lengths.
    pub discount: f64,
    /// What a vertex stands for, by the mesh.
    pub vertex_area: VertexArea,
    /// Of the cylinders.
    pub radii: Radii,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            base: None,
            discount: 0.9,
            vertex_area: VertexArea::Surface,
            radii: Radii::Estimated,
        }
    }
}

impl Settings {
    /// The base of a method.
    ///
    /// By default those that the article's own list back-solves to. Its printed 0.001 m³ goes with surfaces that its
    /// code has too small: by half for cylinders (half a bone's length stands for all of it), by 0.546 for Geno's mesh
    /// ([`VertexArea::Article`]). On whole surfaces 0.002 and 0.00183 m³ are the same. By lengths it prints 0.01 m, and
    /// its list has 0.1.
    pub fn base_of(&self, method: Method) -> f64 {
        self.base.unwrap_or(match (method, self.vertex_area) {
            (Method::Lengths, _) => 0.1,
            (Method::Cylinders, _) => 0.002,
            (Method::Mesh, VertexArea::Surface) => 0.00183,
            (Method::Mesh, VertexArea::Article) => 0.001,
        })
    }
}

/// The weights of one method.
#[derive(Debug, Clone, PartialEq)]
pub struct Weighing {
    /// The method.
    pub method: Method,
    /// The weight that every joint began with, in the method's unit.
    pub base: f64,
    /// By joint, in the character's order; they sum to 1.
    pub weights: Vec<f64>,
}

/// Weighs the joints of a character.
///
/// # Errors
/// [`Error`] if it has more than [`JOINT_COUNT_MAX`] joints or is too large for f32, a setting makes no
/// sense, the radii do not fit it, or it has no mesh with a surface to weigh it by.
pub fn weigh(
    character: &Character,
    method: Method,
    settings: &Settings,
) -> Result<Weighing, Error> {
    let base = settings.base_of(method);
    check("base", base, A_BASE, (0.0..=BASE_MAX).contains(&base))?;
    let rest_pose = rest_pose(character)?;
    let importance = match method {
        Method::Lengths => {
            let discount = settings.discount;
            check("discount", discount, "a number from 0 to 1", (0.0..=1.0).contains(&discount))?;
            descendants_length(&rest_pose, single(base), single(discount))?
        }
        Method::Cylinders => {
            let radii_m: Vec<f32> = settings.radii.of(character)?.into_iter().map(single).collect();
            cylinder_surface(&rest_pose, &radii_m, single(base))?
        }
        Method::Mesh => by_mesh(character, rest_pose, settings.vertex_area, single(base))?,
    };
    let weights = importance.normalised().as_slice().iter().copied().map(f64::from).collect();
    Ok(Weighing { method, base, weights })
}

/// Larger ones are damage, as they would leave nothing of the largest character's joints; f32 holds their sums.
const BASE_MAX: f64 = 1e15;

const A_BASE: &str = "a number from 0 to 1e15";

fn check(name: &'static str, found: f64, expected: &'static str, good: bool) -> Result<(), Error> {
    if good { Ok(()) } else { Err(Error::Setting { name, expected, found }) }
}

fn rest_pose(character: &Character) -> Result<RestPose<JOINT_COUNT_MAX>, Error> {
    let joints = character.joints();
    if joints.len() > JOINT_COUNT_MAX {
        return Err(Error::TooManyJoints { found: joints.len() });
    }
    let parents: Vec<Option<usize>> = joints.iter().map(|joint| joint.parent).collect();
    let origin_m = origin_m(character);
    let positions_m: Vec<Vec3> =
        joints.iter().map(|joint| (joint.position_m - origin_m).as_vec3()).collect();
    Ok(RestPose::new(&parents, &positions_m)?)
}

/// Where the first joint is: f32 has more digits near it than near the world's origin.
fn origin_m(character: &Character) -> DVec3 {
    character.joints()[0].position_m
}

fn by_mesh(
    character: &Character,
    rest_pose: RestPose<JOINT_COUNT_MAX>,
    vertex_area: VertexArea,
    base_m3: f32,
) -> Result<Importance<JOINT_COUNT_MAX>, Error> {
    let mesh = character.mesh().ok_or(Error::NoMesh)?;
    if !mesh.has_surface() {
        return Err(Error::NoSurface { triangles: mesh.triangles.len() });
    }
    let areas_m2 = mesh.vertex_areas_m2(vertex_area);
    let mut surface = MeshSurface::new(rest_pose, base_m3)?;
    let origin_m = origin_m(character);
    let vertices = mesh.positions_m.iter().zip(&mesh.skin).zip(areas_m2);
    let mut influences = Vec::new();
    for (vertex, ((position_m, skin), area_m2)) in vertices.enumerate() {
        influences.clear();
        influences.extend(skin.iter().map(|(joint, share)| (*joint, single(*share))));
        surface
            .add((*position_m - origin_m).as_vec3(), single(area_m2), &influences)
            .map_err(|source| Error::Vertex { vertex, source })?;
    }
    Ok(surface.importance()?)
}

#[expect(clippy::cast_possible_truncation, reason = "what is too large for f32 is refused")]
fn single(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod tests;
