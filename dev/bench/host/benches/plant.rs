//! Measures the time of one step of each plant, without a controller: `cargo bench -p sinew-host-bench --bench
//! plant`.
//!
//! The time is that of 100 steps of the figure of 18 bodies under small constant torques, from the start pose of a
//! built-in clip; the rate counts single steps.

use std::hint::black_box;

use clap::ValueEnum as _;
use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use sinew_figure::builtin;
use sinew_figure::pipeline::{self, Settings};
use sinew_figure::plant::{Drive, Mechanism, MovingPose, PlantKind, PlantSettings, Pose};
use sinew_figure::{BODY_COUNT, BodyModel, FigureMotion, Root};

const STEPS: u32 = 100;

fn steps(criterion: &mut Criterion) {
    let clip = builtin::clips().swap_remove(0);
    let (motion, _) = pipeline::prepare(clip, &Settings::default()).expect("a built-in clip");
    let (mechanism, start) = at_rest(&motion);
    let torque = DVec3::new(0.01, 0.02, -0.01);
    let mut drive = Drive { torque_nm: vec![torque; BODY_COUNT], ..Drive::none(BODY_COUNT) };
    drive.force_n[0] = DVec3::Y * 700.0;

    let mut group = criterion.benchmark_group("100 steps");
    group.throughput(Throughput::Elements(u64::from(STEPS)));
    for kind in PlantKind::value_variants() {
        let settings = PlantSettings { kind: *kind, ..PlantSettings::default() };
        let start = || settings.build(&mechanism, &start, motion.dt_s).expect("a figure");
        group.bench_function(settings.description().name, |bencher| {
            bencher.iter_batched_ref(
                start,
                |plant| {
                    for _ in 0..STEPS {
                        plant.step(black_box(&drive));
                    }
                },
                BatchSize::SmallInput,
            );
        });
    }
    group.finish();
}

/// Returns the figure in the first pose of a clip.
fn at_rest(motion: &FigureMotion) -> (Mechanism, Vec<MovingPose>) {
    let model = BodyModel::from_motion(motion).expect("a figure of the clip's dimensions");
    let mechanism = model.mechanism(Root::Driven);
    let mut start: Vec<MovingPose> = Vec::new();
    for (body, rotation) in mechanism.bodies.iter().zip(&motion.rotation[0]) {
        let pose = match body.parent {
            Some(parent) => start[parent].pose.child(body.position_m, *rotation),
            None => Pose { rotation: *rotation, position_m: motion.root_position_m[0] },
        };
        start.push(MovingPose { pose, angular_rad_s: DVec3::ZERO, linear_m_s: DVec3::ZERO });
    }
    (mechanism, start)
}

criterion_group!(plants, steps);
criterion_main!(plants);
