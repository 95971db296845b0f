//! Verifies mass properties of solids (`solids/1`), in the host's f64.

use serde::Deserialize;
use sinew_figure::solids::{ellipsoid, elliptical_solid, stadium_solid, truncated_cone};

use super::error::CaseError;
use super::tally::{Quantity, Tallies};
use super::tolerance as limit;

#[derive(Deserialize)]
pub(super) struct Case {
    #[serde(flatten)]
    shape: Shape,
    volume: f64,
    com_z: f64,
    inertia_over_mass_com: [f64; 3],
}

#[derive(Deserialize)]
#[serde(tag = "solid", rename_all = "snake_case")]
#[expect(non_snake_case, reason = "the length is L in the files")]
enum Shape {
    Ellipsoid { a: f64, b: f64, c: f64 },
    EllipticalSolid { a0: f64, b0: f64, a1: f64, b1: f64, L: f64 },
    TruncatedCone { r0: f64, r1: f64, L: f64 },
    StadiumSolid { t0: f64, r0: f64, t1: f64, r1: f64, L: f64 },
}

#[expect(clippy::unnecessary_wraps, reason = "as the checks of all kinds")]
pub(super) fn check(name: &str, case: &Case, tallies: &mut Tallies) -> Result<(), CaseError> {
    let solid = match case.shape {
        Shape::Ellipsoid { a, b, c } => ellipsoid(a, b, c),
        Shape::EllipticalSolid { a0, b0, a1, b1, L } => elliptical_solid([a0, a1], [b0, b1], L),
        Shape::TruncatedCone { r0, r1, L } => truncated_cone([r0, r1], L),
        Shape::StadiumSolid { t0, r0, t1, r1, L } => stadium_solid([t0, t1], [r0, r1], L),
    };
    let mut add = |name_of, got: f64, expected: f64| {
        let (name_of, unit) = name_of;
        let limit = limit::SOLID * expected.abs();
        let quantity = Quantity { name: name_of, unit, limit, scale: expected };
        tallies.add_error(quantity, format_args!("case {name}"), got - expected);
    };
    add(("volume", "m³"), solid.volume_m3, case.volume);
    add(("com_z", "m"), solid.center_z_m, case.com_z);
    for (got, expected) in
        solid.inertia_over_mass_m2.to_array().into_iter().zip(case.inertia_over_mass_com)
    {
        add(("inertia_over_mass_com", "m²"), got, expected);
    }
    Ok(())
}
