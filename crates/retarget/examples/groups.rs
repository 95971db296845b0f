//! Prints how the joints of a rig are matched: `cargo run --example groups -- RIG.urdf|.xml`.

use sinew_retarget::rig::{RigMatch, mirror_faults};
use sinew_rig::import::{self, Options};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for path in std::env::args().skip(1) {
        println!("== {path}");
        let text = std::fs::read_to_string(&path)?;
        let options = Options { open_loops: true, repair_inertia: true, ..Options::default() };
        let read = if text.contains("<mujoco") && !text.contains("<robot") {
            import::mjcf
        } else {
            import::urdf
        };
        let mechanism = read(&text, &options)?.description.mechanism()?;
        let rig = match RigMatch::of(&mechanism) {
            Ok(rig) => rig,
            Err(error) => {
                println!("{error}");
                continue;
            }
        };
        println!("{:?} base {:?}", rig.directions, mechanism.bodies[0].joint);
        for group in &rig.groups {
            let names: Vec<_> =
                group.joints.iter().map(|joint| &mechanism.bodies[*joint].joint_name).collect();
            println!(
                "{:11} {:.2} {names:?} {}",
                group.landmark.name(),
                group.confidence,
                group.reason
            );
        }
        for (landmark, point) in rig.points.iter() {
            if let Some(point) = point {
                println!(
                    "  {:11} {} {:.4}",
                    landmark.name(),
                    mechanism.bodies[point.body].name,
                    point.position_m
                );
            }
        }
        for (landmark, hinge) in rig.hinges.iter() {
            if let Some(hinge) = hinge {
                println!(
                    "  {:11} axis {:.2} straight {:.2} sure {}",
                    landmark.name(),
                    hinge.axis,
                    hinge.straight_rad,
                    hinge.is_sure
                );
            }
        }
        for left_out in &rig.left_out {
            println!("  out {} {}", mechanism.bodies[left_out.joint].joint_name, left_out.reason);
        }
        for fault in mirror_faults(&mechanism, &rig) {
            println!("  mirror: {} (turned {})", fault.text, fault.is_axis_turned);
        }
    }
    Ok(())
}
