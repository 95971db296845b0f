//! Each kind of servo with each class of drive: stillness, tracking errors and heat. `docs/drives.md` has a summary.

use std::panic::{AssertUnwindSafe, catch_unwind};

use rayon::prelude::*;
use sinew_performance::play::Drive;
use sinew_rig::description::ServoModel;
use sinew_servo_sim::variation::Variation;

use super::follow::clip_show;
use super::measure::{Poses, Stillness};
use super::robots;
use super::run::{Rig, Run};

/// The clip that a rig follows.
const CLIP: &str = "kicks_01";
/// The servo of the starter arm, for which its masses are chosen.
const STARTER: &str = "XL330-M288-T";

/// Results of a rig's runs.
struct Row {
    name: String,
    /// Stillness on each of [`plants`].
    still: [Stillness; 4],
    mean_deg: f64,
    largest_deg: f64,
    /// Mean power of the winding with the largest loss, W; and the final rise of its case temperature, K.
    held: [f64; 2],
    moved: [f64; 2],
}

/// Returns variations of the plant: as in the rig's file; a gear with twice the play, half the stiffness, a third of
/// the damping, and all friction on the rotor; motors with other constants.
fn plants() -> [Variation; 4] {
    let own = Variation::default();
    let worse = Variation { play: 2.0, stiffness: 0.5, damping: 0.33, ..own };
    [
        own,
        Variation { output_friction: Some(0.0), ..worse },
        Variation { torque: 0.8, ..own },
        Variation { torque: 1.2, ..own },
    ]
}

/// Returns the starter arm with servos of a kind, and masses in proportion to their torque.
pub(super) fn arm_of(model: &str) -> Rig {
    let mut arm = sinew_rig::new::arm(6).unwrap();
    let [own, starter] = [model, STARTER].map(|name| ServoModel::built_in(name).unwrap());
    let factor = own.stall_torque_nm.value / starter.stall_torque_nm.value;
    arm.bodies.iter_mut().for_each(|body| body.mass_kg *= factor);
    arm.servos.iter_mut().for_each(|servo| model.clone_into(&mut servo.model));
    arm.supply = None;
    Rig::new(arm)
}

/// Runs a show. Also returns the mean power of the winding with the largest loss, W, and the final rise of its case
/// temperature, K.
fn heated(rig: &Rig, show: impl FnOnce(u32) -> Vec<u8>, variation: Variation) -> (Run, [f64; 2]) {
    let servos = rig.description.servos.len();
    let (mut sums, mut ticks) = (vec![0.0; servos], 0.0);
    let run = rig.perform(show, variation, |sim, _| {
        ticks += 1.0;
        for (servo, sum) in sums.iter_mut().enumerate() {
            *sum += sim.winding_w(servo);
        }
    });
    let (most, sum) = sums.into_iter().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    let winding_w = sum / ticks;
    (run, [winding_w, winding_w * rig.model(most).thermal_resistance_k_w.value])
}

fn row(name: String, mut rig: Rig, drive: Drive, poses: &Poses) -> Row {
    rig.drive = Some(drive);
    let mut held = [0.0; 2];
    let still = plants().map(|variation| {
        // A run that ends in a fault is listed in the table as one that swings without end.
        let run = AssertUnwindSafe(|| heated(&rig, rig.show_of(&poses.motion), variation));
        let Ok((run, heat)) = catch_unwind(run) else {
            let (peak_to_peak_deg, offset_deg) = (f64::INFINITY, f64::INFINITY);
            return Stillness { peak_to_peak_deg, offset_deg, ..Stillness::default() };
        };
        if variation == Variation::default() {
            held = heat;
        }
        let all = run.stillness(&poses.windows_s).into_iter().flatten();
        all.fold(Stillness::default(), Stillness::max)
    });
    let (run, moved) = heated(&rig, clip_show(&rig, CLIP), Variation::default());
    let errors = || run.samples.iter().flatten().map(|s| s.error_rad.abs().to_degrees());
    Row {
        name,
        still,
        mean_deg: errors().sum::<f64>() / errors().count() as f64,
        largest_deg: errors().fold(0.0, f64::max),
        held,
        moved,
    }
}

fn print(rows: &[Row]) {
    println!(
        "| servos, drive | swing | worse gear | other motor | offset | worse gear | other motor | error | largest | \
         held W | K | moved W | K |\n\
         | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"
    );
    for row in rows {
        let [own, worse, weak, strong] = row.still;
        let other = weak.max(strong);
        let stills = [own, worse, other];
        let all = stills.map(|still| format!("{:.2}", still.peak_to_peak_deg));
        let offsets = stills.map(|still| format!("{:.2}", still.offset_deg));
        println!(
            "| {} | {} | {} | {:.2} | {:.1} | {:.2} | {:.1} | {:.2} | {:.1} |",
            row.name,
            all.join(" | "),
            offsets.join(" | "),
            row.mean_deg,
            row.largest_deg,
            row.held[0],
            row.held[1],
            row.moved[0],
            row.moved[1]
        );
    }
}

#[test]
#[ignore = "prints a table"]
fn classes_of_an_arm() {
    let kinds: [(&str, &[Drive]); 6] = [
        (STARTER, &ALL),
        ("XM430-W350-T", &ALL),
        ("MX-64", &ALL),
        ("MX-28", &WITHOUT_SENSOR),
        ("XL430-W250-T", &WITHOUT_SENSOR),
        ("STS3215-7.4V", &[Drive::Position]),
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

/// A robot, and the servos on it.
struct Robot {
    name: &'static str,
    file: &'static str,
    /// A knee whose axis is reversed.
    turned: Option<&'static str>,
    servos: &'static [&'static str],
    drives: &'static [Drive],
}

const OP3: &str = "robotis-op3/robotis_op3.urdf";
const POPPY: &str = "poppy-humanoid/Poppy_Humanoid.urdf";
const ALL: [Drive; 3] = [Drive::Current, Drive::Voltage, Drive::Position];
const WITHOUT_SENSOR: [Drive; 2] = [Drive::Voltage, Drive::Position];

const ROBOTS: [Robot; 4] = [
    Robot { name: "OP3, XM430", file: OP3, turned: None, servos: &["xm430"], drives: &ALL },
    Robot {
        name: "OP3, XL430",
        file: OP3,
        turned: None,
        servos: &["xl430"],
        drives: &WITHOUT_SENSOR,
    },
    Robot {
        name: "Poppy, MX-64",
        file: POPPY,
        turned: Some("l_knee_y"),
        servos: &["mx-64"],
        drives: &ALL,
    },
    Robot {
        name: "Poppy, MX-28",
        file: POPPY,
        turned: Some("l_knee_y"),
        servos: &["mx-28"],
        drives: &WITHOUT_SENSOR,
    },
];

#[test]
#[ignore = "needs SINEW_DATA, prints a table"]
fn classes_of_robots() {
    let runs: Vec<_> = ROBOTS
        .iter()
        .flat_map(|robot| robot.drives.iter().map(move |drive| (robot, *drive)))
        .collect();
    let rows: Vec<_> = runs
        .par_iter()
        .map(|(robot, drive)| {
            let rig = robots::robot(robot.file, robot.turned, robot.servos);
            let poses = robots::poses(&rig);
            row(format!("{}, {}", robot.name, drive.name()), rig, *drive, &poses)
        })
        .collect();
    print(&rows);
}
