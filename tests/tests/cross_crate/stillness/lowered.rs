//! Rigs that are lowered from raised poses: their maximum joint speed, the duration, and the torque that is left at
//! the end. `docs/lowering.md` shows the table.

use rayon::prelude::*;
use sinew_firmware::supervisor::{Command, State};
use sinew_performance::play::{Director, Drive, Memory, Options, RigParts, SimulatedRig};
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::plant::RigPlant;
use sinew_servo_sim::variation::Variation;

use super::classes::arm_of;
use super::measure::Poses;
use super::robots::{MIXED, OP3, POPPY, robot};
use super::run::Rig;

/// Maximum speed of a joint, deg/s: the default of the setting `lower_rad_s`.
const MOST_DEG_S: f64 = 30.0;
/// Interval over which speeds are computed, s; and a shorter one, in which a joint falls through the play of its
/// gear.
const SPEED_S: f64 = 0.1;
const BURST_S: f64 = 0.02;
/// Maximum time until torque is off, s.
const MOST_S: f64 = 18.01;
/// Time for which the rig is watched after torque is off, s.
const AFTER_S: f64 = 2.0;
/// Time for which a pose is held before the rig is lowered, maximum time to reach it, s, and number of poses.
const HELD_S: f64 = 1.0;
const REACHED_S: f64 = 40.0;
const POSES: u32 = 10;
/// Ratio of the rig's masses to those of its file.
const MASSES: [f64; 2] = [0.85, 1.15];

/// Measurements of a rig that was lowered.
#[derive(Debug, Clone, Copy, Default)]
struct Lowered {
    most_deg_s: f64,
    /// Maximum speed over the shorter interval.
    burst_deg_s: f64,
    /// Maximum speed after torque went off.
    after_deg_s: f64,
    time_s: f64,
    /// Largest current in the last tick with torque, as a part of the servo's stall current, %.
    left_percent: f64,
    on: usize,
    /// Time of the maximum speed, s, and its dof.
    when: (f64, usize),
    after_when: (f64, usize),
}

impl Lowered {
    fn max(self, other: Self) -> Self {
        Self {
            most_deg_s: self.most_deg_s.max(other.most_deg_s),
            burst_deg_s: self.burst_deg_s.max(other.burst_deg_s),
            after_deg_s: self.after_deg_s.max(other.after_deg_s),
            time_s: self.time_s.max(other.time_s),
            left_percent: self.left_percent.max(other.left_percent),
            on: self.on.max(other.on),
            ..self
        }
    }
}

/// Returns ten poses around home, within the ranges.
fn raised(rig: &Rig, away_rad: f64) -> Vec<Vec<f64>> {
    let (home, links) = (rig.mechanism.home(), &rig.mechanism.bodies);
    let pose = |number: u32| {
        let (mut q, mut at) = (home.clone(), 0);
        for link in links {
            for (axis, q) in q[at..at + link.joint.kind().dof_count()].iter_mut().enumerate() {
                let phase = f64::from(number + 1) * (1.0 + (at + axis) as f64);
                *q += away_rad * (1.7 * phase).sin();
                if let Some([least, most]) = link.ranges.get(axis) {
                    *q = q.clamp(*least, *most);
                }
            }
            at += link.joint.kind().dof_count();
        }
        q
    };
    (0..POSES).map(pose).collect()
}

/// Returns the fastest joint in the last `over_s` seconds: its speed, deg/s, and its index.
fn fastest(poses: &[Vec<f64>], rate_hz: f64, over_s: f64) -> (f64, usize) {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "ticks")]
    let apart = (over_s * rate_hz).round() as usize;
    let Some(before) = poses.len().checked_sub(1 + apart) else { return (0.0, 0) };
    let ways = poses[before].iter().zip(&poses[poses.len() - 1]);
    let ways = ways.map(|(before, after)| (after - before).abs()).enumerate();
    let (dof, way) = ways.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    ((way / over_s).to_degrees(), dof)
}

/// Moves a rig to a pose, and lowers it.
fn lower(rig: &Rig, pose: &[f64], masses: f64) -> Lowered {
    let Rig { description, mechanism, drive } = rig;
    let options = Options { drive: *drive, ..Options::default() };
    let mut parts = RigParts::new(description, mechanism, options).unwrap();
    parts.vary(Variation { masses, ..Variation::default() });
    let show = rig.show_of(&Poses::of(&[pose.to_owned()]).motion)(parts.rig_crc());
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
    let plant = parts.plant(description, mechanism).unwrap();
    let mut sim = SimulatedRig::new(&parts, Some(&show), &mut memories, plant).unwrap();
    let rate_hz = f64::from(parts.rate_hz);
    let mut director = Director::default();
    let mut held = 0.0;
    while held < HELD_S {
        assert_eq!(director.tick(&mut sim, false), None, "{:?}", director.raised());
        assert!(sim.time_s() < REACHED_S, "{:?}", sim.report());
        held += if sim.runs() { 1.0 / rate_hz } else { 0.0 };
    }
    let mut poses = vec![sim.q()];
    let mut seen = Lowered::default();
    let left = |sim: &SimulatedRig<'_, RigPlant>| {
        let servos = (0..parts.servos.len()).map(|servo| {
            let stall_a = rig.model(servo).stall_current_a.value;
            100.0 * f64::from(sim.current_a(servo).unwrap_or(0.0)).abs() / stall_a
        });
        servos.fold(0.0, f64::max)
    };
    sim.tick(Some(Command::Disarm));
    assert_eq!(sim.report().state, State::Lowering);
    let began_s = sim.time_s();
    while sim.permission().torque {
        poses.push(sim.q());
        let (deg_s, dof) = fastest(&poses, rate_hz, SPEED_S);
        if deg_s > seen.most_deg_s {
            (seen.most_deg_s, seen.when) = (deg_s, (sim.time_s() - began_s, dof));
        }
        seen.burst_deg_s = seen.burst_deg_s.max(fastest(&poses, rate_hz, BURST_S).0);
        (seen.time_s, seen.left_percent) = (sim.time_s() - began_s, left(&sim));
        sim.tick(None);
    }
    let off_s = sim.time_s();
    poses.drain(..poses.len() - 1);
    while sim.time_s() < off_s + AFTER_S {
        sim.tick(None);
        poses.push(sim.q());
        let (deg_s, dof) = fastest(&poses, rate_hz, SPEED_S);
        if deg_s > seen.after_deg_s {
            (seen.after_deg_s, seen.after_when) = (deg_s, (sim.time_s() - off_s, dof));
        }
    }
    Lowered { on: sim.servos_on(), ..seen }
}

/// Lowers a rig from ten poses, alternately with smaller and larger masses, and returns each run.
fn lowered(rig: &Rig, away_rad: f64) -> Vec<Lowered> {
    let poses = raised(rig, away_rad);
    let runs: Vec<_> = poses.iter().zip(MASSES.into_iter().cycle()).collect();
    runs.into_par_iter().map(|(pose, masses)| lower(rig, pose, masses)).collect()
}

/// Prints the row of a rig, and returns the values that exceed their bounds.
fn row(name: &str, rig: &Rig, away_rad: f64) -> Vec<String> {
    let runs = lowered(rig, away_rad);
    let most = runs.iter().copied().fold(Lowered::default(), Lowered::max);
    let least_s = runs.iter().map(|run| run.time_s).fold(f64::INFINITY, f64::min);
    println!(
        "| {name} | {:.0} | {:.0} | {least_s:.1} to {:.1} | {:.1} | {} | {:.0} |",
        most.most_deg_s,
        most.burst_deg_s,
        most.time_s,
        most.left_percent,
        most.on,
        most.after_deg_s
    );
    // In addition, a joint may fall through the play of its gear.
    let plays = (0..rig.description.servos.len()).map(|servo| rig.model(servo).half_play_rad());
    let play_deg = 2.0 * plays.fold(0.0, f64::max).to_degrees();
    let allowed_deg_s = MOST_DEG_S + play_deg / SPEED_S;
    let bad = |run: &&Lowered| {
        // When the time is over, joints that are still being lowered fall: see `docs/lowering.md`.
        let is_late = run.time_s > MOST_S - 0.02;
        let is_fast = run.most_deg_s.max(run.after_deg_s) > allowed_deg_s;
        is_fast && !is_late || run.time_s > MOST_S || run.on > 0
    };
    runs.iter().filter(bad).map(|run| format!("{name}: {run:.2?}")).collect()
}

#[test]
fn an_arm_goes_down_slowly() {
    let bad = row("starter arm", &Rig::new_arm(), 1.0);
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

#[test]
fn an_arm_by_position_goes_down_slowly() {
    let arm = Rig { drive: Some(Drive::Position), ..arm_of("STS3215-7.4V") };
    let bad = row("STS3215 arm, by position", &arm, 1.0);
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn robots_go_down_slowly() {
    let turned = Some("l_knee_y");
    let bad = [
        row("old arm", &Rig::old_arm(), 1.0),
        row("Poppy, MX-64", &robot(POPPY, turned, &["mx-64"]), 0.5),
        row("OP3, XM430", &robot(OP3, None, &["xm430"]), 0.5),
        row("OP3, mixed", &robot(OP3, None, MIXED), 0.5),
    ]
    .concat();
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}
