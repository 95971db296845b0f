//! Robots of `SINEW_DATA` stand still.

use std::path::PathBuf;

use rayon::prelude::*;
use sinew_performance::play::{ServoChoice, put_servos};
use sinew_rig::Description;
use sinew_rig::import::{Options, urdf};
use sinew_servo_sim::variation::Variation;

use super::limits::{ON_ROTOR, SPLIT};
use super::measure::Poses;
use super::run::Rig;

pub(crate) const OP3: &str = "robotis-op3/robotis_op3.urdf";
pub(crate) const POPPY: &str = "poppy-humanoid/Poppy_Humanoid.urdf";
/// An OP3 with weaker servos in its head and arms.
pub(super) const MIXED: &[&str] =
    &["xm430", "head_*=xl430", "l_sho_*=xl430", "r_sho_*=xl430", "l_el=xl430", "r_el=xl430"];
/// Distance of joints from home in the poses, rad, within the ranges.
const AWAY_RAD: f64 = 0.25;

/// Returns a robot with servos on it; the axis of the joint `turned` is reversed.
pub(crate) fn robot(file: &str, turned: Option<&str>, servos: &[&str]) -> Rig {
    let data: PathBuf = std::env::var_os("SINEW_DATA").expect("SINEW_DATA").into();
    let text = std::fs::read_to_string(data.join("urdf").join(file)).unwrap();
    let options = Options { repair_inertia: true, ..Options::default() };
    let mut rig: Description = urdf(&text, &options).unwrap().description;
    for joint in rig.joints.iter_mut().filter(|joint| Some(joint.name.as_str()) == turned) {
        joint.axis = joint.axis.map(|axis| axis.map(|x| 0.0 - x));
    }
    let servos: Vec<ServoChoice> = servos.iter().map(|servo| servo.parse().unwrap()).collect();
    put_servos(&mut rig, &servos).unwrap();
    Rig::new(rig)
}

/// Returns home, and poses around it.
pub(super) fn poses(rig: &Rig) -> Poses {
    let home = rig.mechanism.home();
    let links = &rig.mechanism.bodies;
    let poses: Vec<Vec<f64>> = (0..6_u32)
        .map(|pose| {
            let mut q = home.clone();
            let mut at = 0;
            for link in links {
                for (axis, q) in q[at..at + link.joint.kind().dof_count()].iter_mut().enumerate() {
                    let number = f64::from(pose) * (1.0 + (at + axis) as f64);
                    *q += AWAY_RAD * (1.7 * number).sin();
                    if let Some([least, most]) = link.ranges.get(axis) {
                        *q = q.clamp(*least, *most);
                    }
                }
                at += link.joint.kind().dof_count();
            }
            q
        })
        .collect();
    Poses::of(&poses)
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn robots_stand_still() {
    let turned = Some("l_knee_y");
    let built: &[&str] = &["mx-28", "l_hip_y=mx-64", "r_hip_y=mx-64", "abs_x=mx-64", "abs_y=mx-64"];
    let robots: [(&str, &str, Option<&str>, &[&str]); 4] = [
        ("OP3, XM430", OP3, None, &["xm430"]),
        ("OP3, mixed", OP3, None, MIXED),
        ("Poppy, MX-64", POPPY, turned, &["mx-64"]),
        ("Poppy as built", POPPY, turned, built),
    ];
    let plants = [
        ("split friction", Variation::default(), SPLIT),
        (
            "friction on the rotor",
            Variation { output_friction: Some(0.0), ..Variation::default() },
            ON_ROTOR,
        ),
    ];
    let runs: Vec<_> = robots
        .par_iter()
        .flat_map(|robot| plants.par_iter().map(move |plant| (robot, plant)))
        .map(|((name, file, turned, servos), (plant, variation, limits))| {
            let rig = robot(file, *turned, servos);
            let poses = poses(&rig);
            let run = rig.play(&poses.motion, *variation, |_, _| {});
            (format!("{name}, {plant}"), run.beyond(&poses.windows_s, *limits))
        })
        .collect();
    for (name, (beyond, worst)) in &runs {
        println!("{name}: {worst:.3?}; {} beyond", beyond.len());
    }
    for (name, (beyond, _)) in &runs {
        assert!(beyond.is_empty(), "{name}:\n{}", beyond.join("\n"));
    }
}
