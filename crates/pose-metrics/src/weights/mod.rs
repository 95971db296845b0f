//! The importance of each joint of a character: inputs for `core`'s computation, and tables of its results.
//!
//! `core` computes all results ([`sinew_core::importance`]). This module measures bones and surfaces in f64; the
//! weights are f32.

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

/// The quantity by which a joint is weighted. After D. Holden, "Joint Error Propagation" (2025).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Total length of the joint's descendant bones, each reduced by the discount.
    Lengths,
    /// Surface of the cylinders around the joint's descendant bones, each part times its distance from the joint.
    Cylinders,
    /// Area of the skin that moves with the joint, each part times its distance from the joint.
    Mesh,
}

impl Method {
    /// All methods, in the order in which they are shown.
    pub const ALL: [Self; 3] = [Self::Lengths, Self::Cylinders, Self::Mesh];

    /// Returns the name for tables and files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lengths => "lengths",
            Self::Cylinders => "cylinders",
            Self::Mesh => "mesh",
        }
    }

    /// Returns the unit of the weights before normalization, which is also the unit of the base.
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

/// Settings of the weighting.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Initial weight of every joint, in the method's unit; `None` for the method's default, see
    /// [`Settings::base_of`].
    pub base: Option<f64>,
    /// Factor on a bone's length for each joint further up, 0 to 1; used by the method [`Method::Lengths`].
    pub discount: f64,
    /// Rule for the area of a vertex; used by the method [`Method::Mesh`].
    pub vertex_area: VertexArea,
    /// Radii of the cylinders; used by the method [`Method::Cylinders`].
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
    /// Returns the base of a method.
    ///
    /// The defaults are the values that reproduce the article's own list. The article prints 0.001 m³, but its
    /// code uses surfaces that are too small: by a factor of one half for cylinders (half of a bone's length
    /// represents the whole), and by 0.546 for Geno's mesh ([`VertexArea::Article`]). For complete surfaces the
    /// equivalent values are 0.002 and 0.00183 m³. For lengths the article prints 0.01 m, but its list is computed
    /// with 0.1 m.
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
    /// Method of the weighting.
    pub method: Method,
    /// Initial weight of every joint, in the method's unit.
    pub base: f64,
    /// Weights by joint, in the character's order. Their sum is 1.
    pub weights: Vec<f64>,
}

/// Computes the weights of a character's joints.
///
/// # Errors
/// [`Error`] if it has more than [`JOINT_COUNT_MAX`] joints or is too large for f32, a setting is invalid, the
/// radii do not fit it, or it has no mesh with a surface and the method needs one.
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

/// Maximum base. Larger values indicate damage, since they would hide the weights of the largest character's
/// joints. f32 can represent the sums.
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

/// Returns the position of the first joint as the origin: f32 is more accurate near it than far from the world's
/// origin.
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
