//! Verifies state errors of every method (`errors/1`).

mod case;
mod compensation;
mod difference;
mod rounded;

use sinew_core::state_error::{References, StateError, accumulated, local, world};
use sinew_core::{Body, BodyState, Inertia, JointKind, JointState, Transform, kinematics};

use super::error::CaseError;
use super::figure::{self, Tree};
use super::golden::{Scalar, expect_count};
use super::rounding;
use super::tally::{Quantity, Tallies};
use case::Case;
use compensation::check_compensation;
use difference::{Limits, add_difference};
use rounded::Rounded;

pub(super) fn check(name: &str, case: &Case, tallies: &mut Tallies) -> Result<(), CaseError> {
    let at = format!("case {name}");
    let tree = tree(case)?;
    let desired = case.desired.rounded("desired", case.n)?;
    let measured = case.measured.rounded("measured", case.n)?;
    for (field, count) in [("leaf", case.leaf.len()), ("aim", case.aim.len())] {
        expect_count(field, count, case.n)?;
    }
    for (body, leaf) in case.leaf.iter().enumerate() {
        tallies.add_equal("leaf", format_args!("{at}, body {body}"), tree.is_leaf(body) == *leaf);
    }

    let joints = |world: &[BodyState]| {
        let mut joints = vec![JointState::default(); case.n];
        kinematics::joint_states(tree.bodies(), world, &mut joints);
        joints
    };
    let errors = |compute: &dyn Fn(&mut [StateError])| {
        let mut out = vec![StateError::ZERO; case.n];
        compute(&mut out);
        out
    };
    let seen_from = |references: &References<128>| {
        errors(&|out| accumulated(references.as_slice(), &desired, &measured, out))
    };
    let references = |field: &str, frames: &[i64]| {
        let bodies: Result<Vec<_>, _> =
            frames.iter().map(|frame| figure::parent(*frame, field)).collect();
        References::new(&tree, &bodies?).map_err(|error| CaseError::new(field, error))
    };

    let expected = &case.expected;
    let parents = references("parent", &case.parent)?;
    let grandparents = references("expected.grandparent.frame", &expected.grandparent.frame)?;
    let world_errors = errors(&|out| world(&desired, &measured, out));
    let by_joints = errors(&|out| local(&joints(&desired), &joints(&measured), out));
    let rounded = Rounded::new(case);
    let egocentric = References::egocentric(&tree);
    let rounded_world = rounded.world();
    for (method, got, rounded, expected) in [
        ("local", &by_joints, rounded.through_joints(&parents), &expected.local),
        ("local, accumulated", &seen_from(&parents), rounded.seen_from(&parents), &expected.local),
        ("world", &world_errors, rounded_world.clone(), &expected.world),
        (
            "egocentric",
            &seen_from(&egocentric),
            rounded.seen_from(&egocentric),
            &expected.egocentric,
        ),
        (
            "grandparent",
            &seen_from(&grandparents),
            rounded.seen_from(&grandparents),
            &expected.grandparent.error,
        ),
    ] {
        expect_count(&format!("expected.{method}"), expected.len(), case.n)?;
        for (body, ((got, expected), rounded)) in got.iter().zip(expected).zip(&rounded).enumerate()
        {
            let at = format!("{at}, body {body}");
            let limits = Limits::new(case, rounded);
            add_difference(method, &at, got, expected, &limits, tallies);
        }
    }
    check_metrics(case, &at, &world_errors, &rounded_world, tallies);
    if expected.linear_compensation.is_empty() {
        return Err(CaseError::new(
            "expected.linear_compensation",
            "none; expected one for each β",
        ));
    }
    for compensated in &expected.linear_compensation {
        let states = [&desired[..], &measured];
        check_compensation(case, &tree, &at, compensated, states, &rounded, tallies)?;
    }
    Ok(())
}

/// Returns a tree without masses, since state errors need none.
fn tree(case: &Case) -> Result<Tree, CaseError> {
    expect_count("parent", case.parent.len(), case.n)?;
    figure::expect_bodies(case.n)?;
    let mut tree = Tree::new();
    for (index, parent) in case.parent.iter().enumerate() {
        let field = format!("parent[{index}]");
        tree.push(Body {
            parent: figure::parent(*parent, &field)?,
            joint: if index == 0 { JointKind::Free } else { JointKind::Spherical },
            placement: Transform::IDENTITY,
            inertia: Inertia::default(),
            rotor_inertia: 0.0,
        })
        .map_err(|error| CaseError::new(field, error))?;
    }
    Ok(tree)
}

fn check_metrics(
    case: &Case,
    at: &str,
    errors: &[StateError],
    rounded: &[rounding::Difference],
    tallies: &mut Tallies,
) {
    let leaves = |of: &dyn Fn(usize) -> f64| {
        let all: Vec<f64> = (0..case.n).map(of).collect();
        let leaf: Vec<f64> =
            all.iter().zip(&case.leaf).filter(|(_, leaf)| **leaf).map(|(x, _)| *x).collect();
        [all, leaf]
    };
    let degrees = leaves(&|body| errors[body].angular_rad.as_dvec3().length().to_degrees());
    let centimetres = leaves(&|body| errors[body].linear_m.as_dvec3().length() * 100.0);
    // The limit of a mean, and of a maximum, is at most the mean or maximum of the values' limits.
    let degrees_off = leaves(&|body| rounded[body].angular.limit().to_degrees());
    let centimetres_off = leaves(&|body| rounded[body].linear.limit() * 100.0);
    let metrics = &case.expected.metrics;
    for (name, unit, [all, leaf], [all_off, leaf_off], expected) in [
        ("metric, angle", "deg", degrees, degrees_off, &metrics.angular_deg),
        ("metric, distance", "cm", centimetres, centimetres_off, &metrics.linear_cm),
    ] {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let max = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        for (got, limit, Scalar(expected)) in [
            (mean(&all), mean(&all_off), expected.mean_all),
            (max(&all), max(&all_off), expected.max_all),
            (mean(&leaf), mean(&leaf_off), expected.mean_leaf),
            (max(&leaf), max(&leaf_off), expected.max_leaf),
        ] {
            let quantity = Quantity { name, unit, limit, scale: expected };
            tallies.add_error(quantity, format_args!("{at}"), got - expected);
        }
    }
}
