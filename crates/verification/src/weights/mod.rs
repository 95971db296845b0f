//! Verifies the importance of joints (`weights/1`).

mod case;
mod rounded;

use std::num::NonZeroU16;

use sinew_core::importance::{
    Importance, ImportanceError, MeshSurface, RestPose, cylinder_samples, cylinder_surface,
    descendants_length,
};

use super::error::CaseError;
use super::golden::expect_count;
use super::rounding::Number;
use super::tally::{Quantity, Tallies};
use case::{Case, Expected, Mesh};
use rounded::Rounded;

/// Error of the core's quadrature for the surface of a cylinder, relative to the mean distance.
const LEFT_OUT: f64 = 1.6e-7;

/// Maximum number of joints: the capacity of the core's sets.
const JOINTS: usize = 128;

pub(super) fn check(name: &str, case: &Case, tallies: &mut Tallies) -> Result<(), CaseError> {
    let count = case.parent.len();
    let parents: Vec<_> = case.parent.iter().map(|parent| usize::try_from(*parent).ok()).collect();
    let positions_m: Vec<_> = case.pos.iter().map(|position| position.rounded()).collect();
    let rest_pose = RestPose::<JOINTS>::new(&parents, &positions_m)
        .map_err(|error| CaseError::new("parent, pos", error))?;

    expect_count("descendant_matrix", case.descendant_matrix.len(), count)?;
    for (joint, row) in case.descendant_matrix.iter().enumerate() {
        expect_count(&format!("descendant_matrix[{joint}]"), row.len(), count)?;
        let set = rest_pose.descendants(joint);
        let equal = row.iter().enumerate().all(|(other, bit)| set.contains(other) == (*bit == 1));
        tallies.add_equal("descendants", format_args!("case {name}, joint {joint}"), equal);
    }

    let radii_m: Vec<_> = case.radius.iter().map(|radius| radius.rounded()).collect();
    let rounded = Rounded::new(case, &parents);
    let mut compare =
        |method: &str, rounded: Vec<Number>, got: Result<Importance<JOINTS>, _>, expected| {
            let refused = |error: ImportanceError| CaseError::new(method, error);
            Comparison { name, method, rounded }.add(&got.map_err(refused)?, expected, tallies)
        };
    for lengths in &case.descendants_length {
        let (base, discount) = (lengths.base.rounded(), lengths.discount.rounded());
        let got = descendants_length(&rest_pose, base, discount);
        compare("descendants_length", rounded.by_length(lengths), got, &lengths.expected)?;
    }
    let exact = &case.cylinder_exact;
    let got = cylinder_surface(&rest_pose, &radii_m, exact.base.rounded());
    compare("cylinder_exact", rounded.by_surface(exact.base), got, &exact.expected)?;

    let sampled = &case.cylinder_sampled;
    let points = u16::try_from(sampled.uv.len()).ok().and_then(NonZeroU16::new);
    let points = points.ok_or_else(|| CaseError::new("cylinder_sampled.uv", "none or too many"))?;
    let uv = sampled.uv.iter().map(|[u, v]| (u.rounded(), v.rounded())).cycle();
    let got = cylinder_samples(&rest_pose, &radii_m, sampled.base.rounded(), points, uv);
    compare("cylinder_sampled", rounded.by_surface(sampled.base), got, &sampled.expected)?;

    let got = case.mesh.surface(rest_pose)?.importance();
    compare("mesh", rounded.by_mesh(&case.mesh), got, &case.mesh.expected)
}

impl Mesh {
    fn surface(&self, rest_pose: RestPose<JOINTS>) -> Result<MeshSurface<JOINTS>, CaseError> {
        let count = self.vertices.len();
        expect_count("mesh.vertex_area", self.vertex_area.len(), count)?;
        expect_count("mesh.bind", self.bind.len(), count)?;
        expect_count("mesh.weight", self.weight.len(), count)?;
        let mut surface = MeshSurface::new(rest_pose, self.base.rounded())
            .map_err(|error| CaseError::new("mesh.base", error))?;
        for (vertex, position_m) in self.vertices.iter().enumerate() {
            let (bind, weight) = (&self.bind[vertex], &self.weight[vertex]);
            expect_count(&format!("mesh.weight[{vertex}]"), weight.len(), bind.len())?;
            let weights = weight.iter().map(|weight| weight.rounded());
            let influences: Vec<_> = bind.iter().copied().zip(weights).collect();
            surface
                .add(position_m.rounded(), self.vertex_area[vertex].rounded(), &influences)
                .map_err(|error| CaseError::new(format!("mesh, vertex {vertex}"), error))?;
        }
        Ok(surface)
    }
}

/// A method under comparison, and the raw weights with their rounding.
struct Comparison<'a> {
    /// Name of the case.
    name: &'a str,
    method: &'a str,
    rounded: Vec<Number>,
}

impl Comparison<'_> {
    fn add(
        &self,
        got: &Importance<JOINTS>,
        expected: &Expected,
        tallies: &mut Tallies,
    ) -> Result<(), CaseError> {
        let Self { name, method, rounded } = self;
        let sum = rounded.iter().fold(Number::ZERO, |sum, weight| sum + *weight);
        let normalised: Vec<_> = rounded.iter().map(|weight| *weight / sum).collect();
        let unit = if *method == "descendants_length" { "m" } else { "m³" };
        for (form, unit, rounded, got, expected) in [
            ("raw", unit, rounded, got, &expected.raw),
            ("normalised", "1", &normalised, &got.normalised(), &expected.normalised),
        ] {
            let field = format!("{method} {form}");
            expect_count(&field, expected.len(), got.as_slice().len())?;
            // The quadrature for the exact surface has the same relative error for every weight.
            let left_out = if *method == "cylinder_exact" { LEFT_OUT } else { 0.0 };
            for (joint, (got, expected)) in got.as_slice().iter().zip(expected).enumerate() {
                let limit = rounded[joint].limit() + left_out * expected;
                let quantity = Quantity { name: &field, unit, limit, scale: *expected };
                let at = format_args!("case {name}, joint {joint}");
                tallies.add_error(quantity, at, f64::from(*got) - expected);
            }
        }
        Ok(())
    }
}
