//! The same bits on every machine: all numbers of the built-in evaluation, with each method at both sizes.
//!
//! The evaluation writes down what its own tracker gets and computes; its runs are made again here and on each other
//! machine, tick by tick as the boards make them. `cargo xtask test` and `cargo xtask parity` build the other
//! machines' programs. Emulators are slow: the former gives them a third of the runs, the latter all.

use std::env;

use rayon::prelude::*;
use sinew_parity::run::NUMBERS;
use sinew_sim::builtin;
use sinew_sim::evaluate::MethodName;
use sinew_sim::figure::{BODIES, FigureMotion};
use sinew_sim::pipeline::{Settings, prepare};
use sinew_tests::parity::{Difference, Machine, Run};

const SCALES: [f64; 2] = [1.0, 1.1];

/// Frames of the paper's evaluation.
const PAPER_FRAMES: usize = 22_560;

/// Emulated machines get one run in so many, unless [`ALL`] is set: of each figure and method that share of the clips,
/// of each clip that share of figures and methods.
const SHARE: usize = 3;

/// The environment variable that gives all runs to all machines with an FPU.
const ALL: &str = "SINEW_PARITY_ALL";

/// The most differences that are shown.
const MESSAGES: usize = 12;

/// A machine whose program is named by an environment variable; none if the variable is empty.
fn machine(name: &'static str, variable: &str, emulated: bool) -> Option<Machine> {
    let program = env::var_os(variable).unwrap_or_else(|| {
        panic!("{variable} is not set: run this test with `cargo xtask parity`")
    });
    (!program.is_empty()).then(|| Machine { name, program: program.into(), emulated })
}

fn motions() -> Vec<FigureMotion> {
    let prepared = |clip| prepare(clip, &Settings::default()).unwrap().0;
    builtin::clips().into_iter().map(prepared).collect()
}

#[test]
#[ignore = "needs programs that `cargo xtask parity` builds"]
fn every_machine_computes_the_same_bits() {
    let machines: Vec<_> = [
        machine("this host, release", "SINEW_PARITY_RELEASE", false),
        machine("32-bit x86", "SINEW_PARITY_I686", false),
        machine("Cortex-M4F", "SINEW_PARITY_M4F", true),
    ]
    .into_iter()
    .flatten()
    .collect();
    // Slow: each figure and method once, and so each clip at least once.
    let soft_float = machine("Cortex-M4 without FPU", "SINEW_PARITY_M4", true);
    let soft_float = soft_float.as_slice();

    let share = if env::var_os(ALL).is_some() { 1 } else { SHARE };
    let motions = motions();
    let figures: Vec<_> = SCALES
        .into_iter()
        .flat_map(|scale| MethodName::ALL.map(|method| (scale, method)))
        .collect();
    assert!(motions.len() <= figures.len());
    let runs: Vec<_> = motions
        .iter()
        .enumerate()
        .flat_map(|(clip, motion)| {
            figures.iter().enumerate().map(move |figure| (clip, motion, figure))
        })
        .collect();
    let results: Vec<_> = runs
        .par_iter()
        .map(|(clip, motion, (figure, (scale, method)))| {
            let run = Run::record(motion, *scale, *method);
            let is_shared = (clip + figure).is_multiple_of(share);
            let also = if *clip == figure % motions.len() { soft_float } else { &[] };
            let answers = machines
                .iter()
                .filter(|machine| is_shared || !machine.emulated)
                .chain(also)
                .map(|machine| (machine.name, run.on(machine)));
            let differences: Vec<_> = std::iter::once(("this host, debug", run.here()))
                .chain(answers)
                .filter_map(|(machine, answer)| {
                    let difference = Difference::first([run.evaluation(), &answer])?;
                    Some(format!("{machine}: {run}, {difference}"))
                })
                .collect();
            (run.ticks(), differences)
        })
        .collect();

    let ticks: usize = results.iter().map(|(ticks, _)| ticks).sum();
    assert!(ticks >= PAPER_FRAMES * figures.len(), "only {ticks} ticks");
    let differences: Vec<_> =
        results.into_iter().flat_map(|(_, differences)| differences).collect();
    assert!(
        differences.is_empty(),
        "{} answers differ, first:\n{}",
        differences.len(),
        differences[..differences.len().min(MESSAGES)].join("\n")
    );
    let names = |machines: &[Machine]| {
        machines.iter().map(|machine| machine.name).collect::<Vec<_>>().join(", ")
    };
    println!(
        "{ticks} ticks in {} runs, {} numbers each: the evaluation's own bits here and on {}; on emulated ones with an \
         FPU one run in {share}, of each figure and method one on {}",
        runs.len(),
        NUMBERS * BODIES.len(),
        names(&machines),
        names(soft_float)
    );
}

#[test]
fn a_flipped_bit_is_found_and_named() {
    let mut motion = motions().swap_remove(0);
    motion.rotation.truncate(12);
    let run = Run::record(&motion, 1.1, MethodName::World);
    let here = run.evaluation().to_vec();
    assert_eq!(Difference::first([&here, &run.here()]), None);

    let body = BODIES.iter().position(|body| body.name == "forearm_l").unwrap();
    // The torques are the last of a tick: six numbers a body.
    let tick = here.len() / run.ticks();
    let forward = 8 * tick - (BODIES.len() - body) * 6 * 4 + 5 * 4;
    let mut there = here.clone();
    there[forward] ^= 1;
    let difference = Difference::first([&here, &there]).unwrap();
    let bits = u32::from_le_bytes(*here[forward..].first_chunk().unwrap());
    let [number, flipped] = [bits, bits ^ 1].map(f32::from_bits);
    assert_eq!(
        difference.to_string(),
        format!(
            "frame 7, forearm_l, torque, force z: {bits:08x} ({number:e}) in the evaluation, \
             {:08x} ({flipped:e}) there",
            bits ^ 1
        )
    );

    // Of two, the one that is computed first.
    there[7 * tick] ^= 0x80;
    let difference = Difference::first([&here, &there]).unwrap();
    assert_eq!(
        (difference.frame, difference.body, difference.quantity, difference.component),
        (7, "pelvis", "desired pose", "rotation x")
    );
}
