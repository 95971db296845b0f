//! Measures the speed of evaluation: `cargo bench -p sinew-host-bench --bench evaluation`.
//!
//! It prints three tables: controlled steps per second on one core for every plant, beside runs that are not tracked
//! together, and the time of the plant alone; by how much a second thread speeds up the evaluation of all built-in
//! clips; and time and memory of runs of 10³ to 10⁶ frames. Names of plants as arguments (`-- articulated`) select the
//! plants. Machines are noisy: every number is the best of several rounds, and compared functions take turns.

use std::hint::black_box;
use std::time::{Duration, Instant};

use clap::ValueEnum as _;
use cpu_time::ProcessTime;
use glam::{DMat3, DVec3};
use peak_alloc::PeakAlloc;
use sinew_evaluation::{MethodName, Protocol, Run, count_all_steps, evaluate};
use sinew_figure::builtin;
use sinew_figure::pipeline::{self, Settings};
use sinew_figure::plant::MassProperties;
use sinew_figure::plant::{
    Drive, JointModel, Mechanism, MovingPose, PlantKind, PlantSettings, Pose, link,
};
use sinew_figure::{BODIES, Body, FigureMotion};

const ROUNDS: usize = 5;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

fn main() {
    let motions: Vec<FigureMotion> = builtin::clips()
        .into_iter()
        .map(|clip| pipeline::prepare(clip, &Settings::default()).expect("a built-in clip").0)
        .collect();
    plants(&motions);
    threads(&motions);
    lengths(&motions[0]);
}

fn protocol(kind: PlantKind) -> Protocol {
    let mut protocol = Protocol::default();
    protocol.setup.plant = PlantSettings { kind, ..PlantSettings::default() };
    protocol
}

fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads").install(work)
}

/// Measures wall time, for work on several threads.
fn on_the_wall(work: &mut dyn FnMut()) -> Duration {
    let start = Instant::now();
    work();
    start.elapsed()
}

/// Measures processor time, which other programs do not affect.
fn of_the_processor(work: &mut dyn FnMut()) -> Duration {
    let start = ProcessTime::now();
    work();
    start.elapsed()
}

/// Returns the best time of each function; the functions take turns.
fn best<const K: usize>(
    rounds: usize,
    clock: fn(&mut dyn FnMut()) -> Duration,
    mut work: [Box<dyn FnMut() + '_>; K],
) -> [Duration; K] {
    let mut best = [Duration::MAX; K];
    for _ in 0..rounds {
        for (best, work) in best.iter_mut().zip(&mut work) {
            *best = (*best).min(clock(work));
        }
    }
    best
}

fn plants(motions: &[FigureMotion]) {
    println!("One core, the paper's protocol on all built-in clips (3 methods, 2 sizes)\n");
    println!(
        "{:<20} {:>16} {:>12} {:>20} {:>16}",
        "plant", "steps per second", "us per step", "each run alone, us", "plant alone, us"
    );
    for kind in kinds() {
        let protocol = protocol(kind);
        let steps = count_all_steps(motions, &protocol);
        let name = protocol.setup.plant.description().name;
        if on_threads(1, || evaluate(motions, &protocol, |_| ())).is_err() {
            println!("{name:<20} {:>16}", "diverges");
            continue;
        }
        let times = best(
            ROUNDS,
            of_the_processor,
            [
                Box::new(|| {
                    on_threads(1, || black_box(evaluate(motions, &protocol, |_| ()).is_ok()));
                }),
                Box::new(|| on_threads(1, || each_alone(motions, &protocol))),
                Box::new(|| fall(protocol.setup.plant, steps)),
            ],
        );
        let [all, alone, plant] = times.map(|time| time.as_secs_f64() / steps as f64);
        println!(
            "{name:<20} {:>16.0} {:>12.2} {:>20.2} {:>16.2}",
            1.0 / all,
            all * 1e6,
            alone * 1e6,
            plant * 1e6
        );
    }
}

/// Returns the plants whose names are arguments of the program; without arguments, all.
fn kinds() -> Vec<PlantKind> {
    let named: Vec<String> =
        std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let is_named = |kind: &PlantKind| {
        let name = PlantSettings { kind: *kind, ..PlantSettings::default() }.description().name;
        named.is_empty() || named.iter().any(|one| one == name)
    };
    PlantKind::value_variants().iter().copied().filter(is_named).collect()
}

/// Evaluates each motion, size and method alone, so that no runs are tracked together.
fn each_alone(motions: &[FigureMotion], protocol: &Protocol) {
    for motion in motions {
        for scale in &protocol.scales {
            for method in &protocol.methods {
                let (scales, methods) = (vec![*scale], vec![*method]);
                let one = Protocol { scales, methods, ..protocol.clone() };
                black_box(evaluate(std::slice::from_ref(motion), &one, |_| ()).is_ok());
            }
        }
    }
}

/// Steps a plant of the figure's tree without a controller. The plant is restarted now and then, so that it does
/// not fall far.
fn fall(settings: PlantSettings, steps: usize) {
    let mass = MassProperties {
        mass_kg: 4.0,
        center_of_mass_m: DVec3::new(0.0, 0.1, 0.0),
        rotational_kg_m2: DMat3::from_diagonal(DVec3::new(0.03, 0.02, 0.03)),
    };
    let body = |body: &Body| match body.parent {
        None => link(None, JointModel::Free, DVec3::ZERO, &mass),
        Some(parent) => {
            link(Some(parent), JointModel::Spherical, DVec3::new(0.0, 0.25, 0.0), &mass)
        }
    };
    let bodies: Vec<_> = BODIES.iter().map(body).collect();
    let mut start: Vec<MovingPose> = Vec::new();
    for body in &bodies {
        let pose = body
            .parent
            .map_or(Pose { rotation: glam::DQuat::IDENTITY, position_m: DVec3::Y }, |parent| {
                start[parent].pose.child(body.position_m, glam::DQuat::from_rotation_x(0.3))
            });
        start.push(MovingPose { pose, angular_rad_s: DVec3::ZERO, linear_m_s: DVec3::ZERO });
    }
    let mut drive = Drive::none(bodies.len());
    drive.torque_nm.fill(DVec3::X * 0.01);
    drive.force_n[0] = DVec3::Y * 700.0;
    let mechanism = Mechanism { bodies, linked: Vec::new() };
    let mut left = steps;
    while left > 0 {
        let mut plant = settings.build(&mechanism, &start, 0.01).expect("a mechanism");
        let now = left.min(50);
        for _ in 0..now {
            plant.step(&drive);
        }
        black_box(plant.poses());
        left -= now;
    }
}

fn threads(motions: &[FigureMotion]) {
    println!("\nThe same on one and on two threads\n");
    println!("{:<20} {:>12} {:>12} {:>8}", "plant", "1 thread, s", "2 threads, s", "gain");
    for kind in kinds() {
        let protocol = protocol(kind);
        if evaluate(motions, &protocol, |_| ()).is_err() {
            continue;
        }
        let with = |threads: usize| {
            let protocol = &protocol;
            Box::new(move || {
                on_threads(threads, || black_box(evaluate(motions, protocol, |_| ()).is_ok()));
            })
        };
        let [one, two] = best(ROUNDS, on_the_wall, [with(1), with(2)]);
        println!(
            "{:<20} {:>12.3} {:>12.3} {:>8.2}",
            protocol.setup.plant.description().name,
            one.as_secs_f64(),
            two.as_secs_f64(),
            one.as_secs_f64() / two.as_secs_f64()
        );
    }
}

/// Returns the clip played forwards and backwards until it has enough frames.
fn repeated(motion: &FigureMotion, frames: usize) -> FigureMotion {
    let last = motion.rotation.len() - 1;
    let there_and_back = (0..=last).chain((1..last).rev()).cycle().take(frames);
    let (mut rotation, mut root) = (Vec::with_capacity(frames), Vec::with_capacity(frames));
    for frame in there_and_back {
        rotation.push(motion.rotation[frame].clone());
        root.push(motion.root_position_m[frame]);
    }
    FigureMotion { rotation, root_position_m: root, ..motion.clone() }
}

fn lengths(motion: &FigureMotion) {
    println!(
        "\nRuns of growing length, Linear Compensation, one thread; memory beside the clip's\n"
    );
    println!(
        "{:<20} {:>9} {:>10} {:>12} {:>14}",
        "plant", "frames", "s", "us per frame", "memory, bytes"
    );
    for kind in kinds() {
        let setup = protocol(kind).setup_of(1.0, MethodName::LinearCompensation);
        for frames in [1_000, 10_000, 100_000, 1_000_000] {
            let motion = repeated(motion, frames);
            let rounds = if frames > 100_000 { 1 } else { 3 };
            let mut memory = 0;
            let mut failed = false;
            let [time] = best(
                rounds,
                of_the_processor,
                [Box::new(|| {
                    let before = MEMORY.current_usage();
                    MEMORY.reset_peak_usage();
                    failed |= Run::new(&motion, &setup, None, 0).and_then(Run::measure).is_err();
                    memory = MEMORY.peak_usage() - before;
                })],
            );
            let name = setup.plant.description().name;
            if failed {
                println!("{name:<20} {frames:>9} {:>10}", "diverges");
                break;
            }
            let seconds = time.as_secs_f64();
            println!(
                "{name:<20} {frames:>9} {seconds:>10.3} {:>12.2} {memory:>14}",
                seconds * 1e6 / frames as f64
            );
        }
    }
}
