//! Checks for equal bits on every machine: all numbers of the built-in evaluation, with each method at both sizes.
//!
//! The evaluation records the inputs and results of its own tracker. Its runs are repeated here and on each other
//! machine, tick by tick as on boards. `cargo xtask test` and `cargo xtask parity` build the other machines'
//! programs. Emulators are slow: the first command gives the emulator with an FPU a sixth of the runs, the second one
//! all.
//!
//! Other tests compare a show of the figure, played with simulated servos, and ten minutes of decoded shows.

#[path = "../../../crates/show/examples/size/performance.rs"]
mod performance;

use std::env;
use std::path::Path;
use std::process::Command;

use rayon::prelude::*;
use sinew_bit_parity::DECODE;
use sinew_bit_parity::replay::METHODS;
use sinew_bit_parity::run::NUMBERS;
use sinew_evaluation::MethodName;
use sinew_figure::builtin;
use sinew_figure::pipeline::{Settings, prepare};
use sinew_figure::{BODIES, FigureMotion};
use sinew_show::write::{Settings as ShowSettings, write};
use sinew_test_support::figure::figure_show;
use sinew_test_support::parity::{Difference, Machine, Run, here, to_play};

const SCALES: [f64; 2] = [1.0, 1.1];

/// Frames of the paper's evaluation.
const PAPER_FRAMES: usize = 22_560;

/// Emulated machines get one run in this many, unless [`ALL`] is set: one in six of the clips for each figure and
/// method, and one in six of the figures and methods for each clip.
const SHARE: usize = 6;

/// The environment variable that gives all runs to all machines with an FPU, and twice as many to the machine
/// without.
const ALL: &str = "SINEW_PARITY_ALL";

/// Tick rate at which recorded shows are decoded, Hz: not their sample rate, so that all phases of a span occur.
const DECODE_HZ: u32 = 125;

/// Duration of a played show, s, and its number of ticks. Emulated machines, one of which has no FPU, play fewer
/// ticks.
const PLAYED_S: f64 = 21.0;
const TICKS: u32 = 2_100;
const EMULATED_TICKS: u32 = 200;

/// Largest number of differences that are printed.
const MESSAGES: usize = 12;

/// Returns a machine whose program is named by an environment variable; `None` if the variable is empty.
fn machine(name: &'static str, variable: &str, emulated: bool) -> Option<Machine> {
    let program = env::var_os(variable).unwrap_or_else(|| {
        panic!("{variable} is not set: run this test with `cargo xtask parity`")
    });
    (!program.is_empty()).then(|| Machine { name, program: program.into(), emulated })
}

/// Returns all machines except the slowest.
fn machines() -> Vec<Machine> {
    let machines = [
        machine("this host, release", "SINEW_PARITY_RELEASE", false),
        machine("32-bit x86", "SINEW_PARITY_I686", false),
        machine("Cortex-M4F", "SINEW_PARITY_M4F", true),
    ];
    machines.into_iter().flatten().collect()
}

fn motions() -> Vec<FigureMotion> {
    let prepared = |clip| prepare(clip, &Settings::default()).unwrap().0;
    builtin::clips().into_iter().map(prepared).collect()
}

#[test]
#[ignore = "needs programs that `cargo xtask parity` builds"]
fn every_machine_computes_the_same_bits() {
    let machines = machines();
    // This machine is slow: it gets a clip for each method, alternating between the two sizes; with `ALL`, a clip
    // for each method and size.
    let soft_float = machine("Cortex-M4 without FPU", "SINEW_PARITY_M4", true);
    let soft_float = soft_float.as_slice();

    let is_all = env::var_os(ALL).is_some();
    let share = if is_all { 1 } else { SHARE };
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
        .map(|(clip, motion, (figure, (scale, name)))| {
            let run = Run::record(motion, *scale, *name);
            let is_shared = (clip + figure).is_multiple_of(share);
            let (size, method) = (figure / MethodName::ALL.len(), figure % MethodName::ALL.len());
            let is_in_turn = is_all || (size + method / 2).is_multiple_of(2);
            let is_soft = is_in_turn && *clip == figure % motions.len();
            let also = if is_soft { soft_float } else { &[] };
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
         FPU one run in {share}, of each {} one on {}",
        runs.len(),
        NUMBERS * BODIES.len(),
        names(&machines),
        if is_all { "figure and method" } else { "method" },
        names(soft_float)
    );
}

/// The show of the image for QEMU's board, from its compact rig and its splines to torques. Emulated machines play a
/// part of it; with `cargo xtask firmware mps2_an386` a board plays all of it.
#[test]
#[ignore = "needs programs that `cargo xtask parity` builds"]
fn every_machine_plays_a_show_with_the_same_torques() {
    let show = figure_show(PLAYED_S);
    let soft_float = machine("Cortex-M4 without FPU", "SINEW_PARITY_M4", true);
    machines().into_par_iter().chain(soft_float).for_each(|machine| {
        let ticks = if machine.emulated { EMULATED_TICKS } else { TICKS };
        let request = to_play(&show, ticks);
        let found = machine.answer(&request);
        let found = found.unwrap_or_else(|problem| panic!("{machine}: {problem}"));
        assert_eq!(found, here(&request), "{machine}: hashes of {METHODS:?}");
    });
}

/// 10 minutes of the 20 joint angles that move most in recorded fights, and in walks: bytes and largest error equal
/// those in `docs/show-format.md`, and every bit that a machine decodes is the same.
#[test]
#[ignore = "needs SINEW_DATA, and programs that `cargo xtask parity` builds"]
fn recorded_shows_are_decoded_to_the_same_bits() {
    let cmu = Path::new(&env::var_os("SINEW_DATA").expect("SINEW_DATA")).join("cmu");
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/show-format.md");
    let page = std::fs::read_to_string(page).unwrap();
    let machines = machines();
    ["fight", "walk"].into_par_iter().for_each(|class| {
        let q = performance::performance(&cmu, class).unwrap();
        let written = write(&performance::motion(&q), &ShowSettings::default()).unwrap();
        let (len, largest_deg) = (written.bytes.len(), written.angles.largest.to_degrees());
        let row = format!("| {class} | 0.25° | {len} | {largest_deg:.4}° |");
        assert!(page.contains(&row), "docs/show-format.md has not: {row}");
        let mut request = DECODE.to_le_bytes().to_vec();
        request.extend(DECODE_HZ.to_le_bytes());
        request.extend(u32::try_from(len).unwrap().to_le_bytes());
        request.extend(&written.bytes);
        let wanted = here(&request);
        let (seconds, rest) = wanted.as_chunks::<8>();
        assert!(seconds.len() >= 600 && rest.is_empty(), "{class}: {} seconds", seconds.len());
        machines.par_iter().for_each(|machine| {
            let found = machine.answer(&request);
            let found = found.unwrap_or_else(|problem| panic!("{machine}, {class}: {problem}"));
            assert_eq!(found.len(), wanted.len(), "{machine}, {class}: bytes of the answer");
            let second = seconds.iter().zip(found.as_chunks().0).position(|(a, b)| a != b);
            assert_eq!(second, None, "{machine}, {class}: the first second with other bits");
        });
    });
}

#[test]
fn a_show_is_played_the_same_every_time_and_differs_by_method() {
    let request = to_play(&figure_show(2.0), 100);
    let answer = here(&request);
    assert_eq!(answer, here(&request));
    let hashes = answer.as_chunks::<8>().0;
    assert_eq!(hashes.len(), METHODS.len());
    assert!(hashes.iter().enumerate().all(|(method, hash)| !hashes[..method].contains(hash)));
}

#[test]
fn a_flipped_bit_is_found_and_named() {
    let mut motion = motions().swap_remove(0);
    motion.rotation.truncate(12);
    let run = Run::record(&motion, 1.1, MethodName::World);
    let here = run.evaluation().to_vec();
    assert_eq!(Difference::first([&here, &run.here()]), None);

    let body = BODIES.iter().position(|body| body.name == "forearm_l").unwrap();
    // The torques are the last numbers of a tick: six numbers per body.
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

    // With two differences, the one that is computed first is reported.
    there[7 * tick] ^= 0x80;
    let difference = Difference::first([&here, &there]).unwrap();
    assert_eq!(
        (difference.frame, difference.body, difference.quantity, difference.component),
        (7, "pelvis", "desired pose", "rotation x")
    );
}

#[test]
#[ignore = "needs the image that `cargo xtask firmware` builds"]
fn the_emulated_board_is_the_host() {
    let image = env::var_os("SINEW_BOARD_IMAGE").expect("`cargo xtask test` sets it");
    let lines = |command: &mut Command| -> Vec<String> {
        let output = command.output().expect("`cargo xtask setup` installs QEMU");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
        text.lines().map(str::to_owned).collect()
    };
    let mut qemu = Command::new("qemu-system-arm");
    qemu.args(["-machine", "mps2-an386", "-nographic"]);
    qemu.args(["-semihosting-config", "enable=on,target=native", "-kernel"]).arg(image);
    // The board also prints instruction counts.
    let is_count = |word: &&str| word.starts_with("tick=") || word.starts_with("worst=");
    let torques = |line: &String| {
        line.split(' ').filter(|word| !is_count(word)).collect::<Vec<_>>().join(" ")
    };
    let on_board: Vec<_> = lines(&mut qemu).iter().map(torques).collect();
    let folder = tempfile::tempdir().unwrap();
    let mut host = Command::new(env!("CARGO_BIN_EXE_figure_show"));
    host.args([folder.path().join("figure.snwr"), folder.path().join("figure.show")]);
    assert_eq!(on_board, lines(&mut host));
    assert_eq!(on_board.len(), METHODS.len());
}
