//! Checks, on real mocap, the claims about the manifold projection, aligned differences and the recommended setting.

use std::path::PathBuf;

use sinew_core::tracker::Differences;
use sinew_evaluation::robustness::{as_built, median};
use sinew_evaluation::{Errors, MethodName, Protocol, Setup, evaluate, run_trial};
use sinew_figure::pipeline::{self, Settings, prepare};
use sinew_figure::plant::PlantKind;
use sinew_figure::{Dimensions, FigureMotion};

fn fight(settings: &Settings) -> Vec<FigureMotion> {
    let data = std::env::var_os("SINEW_DATA").expect("SINEW_DATA is set");
    let files = sinew_mocap::files::expand(&[PathBuf::from(data).join("cmu/fight")]).unwrap();
    let motion = |file| prepare(pipeline::load(file, settings).unwrap(), settings).unwrap().0;
    files.iter().map(motion).collect()
}

fn exact() -> Setup {
    let mut setup = Setup::default();
    setup.plant.kind = PlantKind::Articulated;
    setup
}

/// Returns angular and linear means over all bodies, then over the leaves.
fn means(errors: &Errors) -> [f64; 4] {
    [
        errors.all.angular_mean_deg(),
        errors.all.linear_mean_cm(),
        errors.leaf.angular_mean_deg(),
        errors.leaf.linear_mean_cm(),
    ]
}

fn of(setup: Setup, motions: &[FigureMotion], methods: &[MethodName]) -> Vec<Vec<[f64; 4]>> {
    let protocol =
        Protocol { setup, methods: methods.to_vec(), seconds: Some(6.0), ..Protocol::default() };
    let evaluation = evaluate(motions, &protocol, |_| {}).unwrap();
    let figures = evaluation.figures.iter();
    figures
        .map(|figure| figure.methods.iter().map(|method| means(&method.total)).collect())
        .collect()
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn the_projection_is_world_at_equal_lengths_and_below_linear_compensation_beyond() {
    let motions = fight(&Settings::default());
    let methods = [
        MethodName::Local,
        MethodName::World,
        MethodName::LinearCompensation,
        MethodName::ManifoldProjection,
    ];
    let figures = of(exact(), &motions, &methods);
    let [_, world, _, projection] = figures[0][..] else { panic!("four methods") };
    for (world, projection) in world.iter().zip(projection) {
        assert!((projection / world - 1.0).abs() < 0.01, "{world} {projection}");
    }
    let [local, _, compensation, projection] = figures[1][..] else { panic!("four methods") };
    for (compensation, projection) in compensation.iter().zip(projection) {
        assert!(projection < *compensation, "{compensation} {projection}");
    }
    assert!(projection[3] <= 0.75 * local[3], "{} {}", projection[3], local[3]);
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn aligned_differences_leave_local_a_twentieth_of_its_error() {
    let motions = fight(&Settings::default());
    let forward = of(exact(), &motions, &[MethodName::Local]);
    let mut setup = exact();
    setup.controller.differences = Differences::Aligned;
    let aligned = of(setup, &motions, &[MethodName::Local]);
    for (forward, aligned) in forward[0][0].iter().zip(aligned[0][0]) {
        assert!(aligned <= 0.05 * forward, "{forward} {aligned}");
    }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn recommended_is_below_world_and_linear_compensation_on_the_median_rig() {
    let settings = Settings { rate_hz: 500.0, frame_rate_hz: Some(100.0), ..Settings::default() };
    let motions = fight(&settings);
    let setup = Setup { dimensions: Dimensions::uniform(1.1), ..exact() };
    let median_of = |method| {
        let rigs: Vec<[f64; 4]> = (1..=10)
            .map(|seed| {
                means(&run_trial(&motions, &as_built(&setup, method, seed), Some(3.0)).unwrap())
            })
            .collect();
        [0, 1].map(|mean| median(rigs.iter().map(|rig| rig[mean]).collect()).unwrap())
    };
    let recommended = median_of(MethodName::Recommended);
    for method in [MethodName::World, MethodName::LinearCompensation] {
        let other = median_of(method);
        assert!(
            recommended[0] < other[0] && recommended[1] < other[1],
            "{method}: {other:?}, recommended {recommended:?}"
        );
    }
}
