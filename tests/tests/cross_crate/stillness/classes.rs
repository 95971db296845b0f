//! Each kind of servo by each class of drive: how still it stands, how it follows, what it heats. `docs/drives.md` has
//! the table.

use rayon::prelude::*;
use sinew_performance::play::Drive;
use sinew_rig::description::ServoModel;
use sinew_servo_sim::variation::Variation;

use super::follow::clip_show;
use super::measure::{Poses, Stillness};
use super::robots::{self, robot};
use super::run::{Rig, Run};

/// The clip that a rig follows.
const CLIP: &str = "kicks_01";
/// The servo of the starter arm, for which its masses are.
const STARTER: &str = "XL330-M288-T";

/// What a run came to.
struct Row {
    name: String,
    /// As the rig's file has it, and on a worse gear.
    still: [Stillness; 2],
    mean_deg: f64,
    largest_deg: f64,
    /// In the winding that loses most, a mean of the time.
    held_w: f64,
    moved_w: f64,
}

/// A gear with twice the play, half the stiffness, a third of the damping, and all friction on the rotor.
fn worse() -> Variation {
    let own = Variation::default();
    Variation { play: 2.0, stiffness: 0.5, damping: 0.33, output_friction: Some(0.0), ..own }
}

/// The starter arm with servos of a kind, its masses in proportion to their torque.
fn arm_of(model: &str) -> Rig {
    let mut arm = sinew_rig::new::arm(6).unwrap();
    let [own, starter] = [model, STARTER].map(|name| ServoModel::built_in(name).unwrap());
    let factor = own.stall_torque_nm.value / starter.stall_torque_nm.value;
    arm.bodies.iter_mut().for_each(|body| body.mass_kg *= factor);
    arm.servos.iter_mut().for_each(|servo| model.clone_into(&mut servo.model));
    arm.supply = None;
    Rig::new(arm)
}

/// Mean power of the winding that loses most, W, and the run.
fn heated(servos: usize, run: impl FnOnce(&mut dyn FnMut(usize, f64)) -> Run) -> (f64, Run) {
    let mut sums = vec![(0.0, 0.0); servos];
    let run = run(&mut |servo: usize, winding_w: f64| {
        sums[servo].0 += winding_w;
        sums[servo].1 += 1.0;
    });
    (sums.iter().map(|(sum, count)| sum / count).fold(0.0, f64::max), run)
}

fn row(name: String, mut rig: Rig, drive: Drive, poses: &Poses) -> Row {
    rig.drive = Some(drive);
    let servos = rig.description.servos.len();
    let hold = |variation| {
        heated(servos, |note| {
            rig.play(&poses.motion, variation, |sim, _| {
                (0..servos).for_each(|servo| note(servo, sim.winding_w(servo)));
            })
        })
    };
    let worst = |run: &Run| {
        run.stillness(&poses.windows_s)
            .into_iter()
            .flatten()
            .fold(Stillness::default(), Stillness::max)
    };
    let (held_w, held) = hold(Variation::default());
    let (_, held_worse) = hold(worse());
    let (moved_w, moved) = heated(servos, |note| {
        rig.perform(clip_show(&rig, CLIP), Variation::default(), |sim, _| {
            (0..servos).for_each(|servo| note(servo, sim.winding_w(servo)));
        })
    });
    let errors = || moved.samples.iter().flatten().map(|s| s.error_rad.abs().to_degrees());
    Row {
        name,
        still: [worst(&held), worst(&held_worse)],
        mean_deg: errors().sum::<f64>() / errors().count() as f64,
        largest_deg: errors().fold(0.0, f64::max),
        held_w,
        moved_w,
    }
}

fn print(rows: &[Row]) {
    println!(
        "| servo, drive | swing | on a worse gear | offset | on a worse gear | mean error | largest | held W | moved W |"
    );
    println!("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |");
    for row in rows {
        let [own, worse] = row.still;
        println!(
            "| {} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.1} | {:.2} | {:.2} |",
            row.name,
            own.peak_to_peak_deg,
            worse.peak_to_peak_deg,
            own.offset_deg,
            worse.offset_deg,
            row.mean_deg,
            row.largest_deg,
            row.held_w,
            row.moved_w
        );
    }
}

#[test]
#[ignore = "prints a table"]
fn classes_of_an_arm() {
    let all = [Drive::Current, Drive::Voltage, Drive::Position];
    let kinds = [
        (STARTER, &all[..]),
        ("XM430-W350-T", &all),
        ("MX-64", &all),
        ("MX-28", &all[1..]),
        ("XL430-W250-T", &all[1..]),
        ("STS3215-7.4V", &all[2..]),
    ];
    let runs: Vec<_> = kinds
        .iter()
        .flat_map(|(kind, drives)| drives.iter().map(move |drive| (*kind, *drive)))
        .collect();
    let rows: Vec<_> = runs
        .par_iter()
        .map(|(kind, drive)| {
            row(format!("{kind}, {}", drive.name()), arm_of(kind), *drive, &Poses::of_arm())
        })
        .collect();
    print(&rows);
}

#[test]
#[ignore = "needs SINEW_DATA, prints a table"]
fn classes_of_robots() {
    let all = [Drive::Current, Drive::Voltage, Drive::Position];
    let (op3, poppy) = ("robotis-op3/robotis_op3.urdf", "poppy-humanoid/Poppy_Humanoid.urdf");
    let turned = Some("l_knee_y");
    let built: &[&str] = &["mx-28", "l_hip_y=mx-64", "r_hip_y=mx-64", "abs_x=mx-64", "abs_y=mx-64"];
    let robots: [(&str, &str, Option<&str>, &[&str], &[Drive]); 4] = [
        ("OP3, XM430", op3, None, &["xm430"], &all),
        ("OP3, XL430", op3, None, &["xl430"], &all[1..]),
        ("Poppy, MX-64", poppy, turned, &["mx-64"], &all),
        ("Poppy as built", poppy, turned, built, &all[1..]),
    ];
    let runs: Vec<_> =
        robots.iter().flat_map(|robot| robot.4.iter().map(move |drive| (robot, *drive))).collect();
    let rows: Vec<_> = runs
        .par_iter()
        .map(|((name, file, turned, servos, _), drive)| {
            let rig = robot(file, *turned, servos);
            let poses = robots::poses(&rig);
            row(format!("{name}, {}", drive.name()), rig, *drive, &poses)
        })
        .collect();
    print(&rows);
}
