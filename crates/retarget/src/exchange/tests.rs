use sinew_mocap::forward_kinematics;
use sinew_rig::mechanism::JointModel;
use sinew_rig::new::{arm, face};

use super::*;
use crate::feasibility::RigMotion;

fn swing(mechanism: &sinew_rig::Mechanism) -> RigMotion {
    let ranges = mechanism.coordinate_ranges();
    let rows = (0..50)
        .map(|row| {
            let mut q = mechanism.home();
            for (link, range) in mechanism.bodies.iter().zip(&ranges) {
                if let (JointModel::Revolute(_), Some([least, most])) =
                    (link.joint, link.ranges.first())
                {
                    let share = 0.5 + 0.4 * libm::sin(0.1 * f64::from(row) + range.start as f64);
                    q[range.start] = least + share * (most - least);
                }
            }
            q
        })
        .collect();
    RigMotion { dt_s: 0.02, rows }
}

#[test]
fn servos_and_joints_are_each_others_way_back() {
    for rig in [arm(6).unwrap(), face()] {
        let mechanism = rig.mechanism().unwrap();
        let motion = swing(&mechanism);
        let tracks = servos::tracks(&rig, &mechanism, &motion).unwrap();
        assert_eq!(tracks.len(), rig.servos.len());
        assert!(tracks.iter().all(|track| track.limited == 0));
        // Half a step of each servo, through its drive: less than 0.1 deg for all of them.
        let back = servos::motion(&rig, &mechanism, &tracks, motion.dt_s).unwrap();
        for (before, after) in motion.rows.iter().zip(&back.rows) {
            for (before, after) in before.iter().zip(after) {
                assert!((before - after).abs() < 0.1_f64.to_radians(), "{before} {after}");
            }
        }
    }
}

#[test]
fn servos_of_one_number_are_refused() {
    let mut rig = arm(2).unwrap();
    // Servos on two buses are different, but a table has one number for both.
    rig.servos[1].address = rig.servos[0].address;
    rig.servos[1].bus = "second".to_owned();
    let mechanism = rig.mechanism().unwrap();
    let told = servos::tracks(&rig, &mechanism, &swing(&mechanism)).unwrap_err().to_string();
    assert!(
        told.contains(&rig.servos[0].name) && told.contains("a number for each servo"),
        "{told}"
    );
}

#[test]
fn hobby_servos_have_pulses_and_bus_servos_steps() {
    let (rig, arm) = (face(), arm(2).unwrap());
    let pulses = |rig: &sinew_rig::Description| {
        let mechanism = rig.mechanism().unwrap();
        let home = RigMotion { dt_s: 0.02, rows: vec![mechanism.home(); 2] };
        servos::tracks(rig, &mechanism, &home).unwrap()
    };
    assert!(
        pulses(&rig).iter().flat_map(|track| &track.positions).all(|us| (500..=2500).contains(us))
    );
    assert!(
        pulses(&arm)
            .iter()
            .flat_map(|track| &track.positions)
            .all(|step| (0..=4095).contains(step))
    );
}

#[test]
fn numbers_that_are_no_pulses_are_refused_with_their_unit() {
    let rig = face();
    let servo = &rig.servos[0];
    let number = servos::number_of(servo.address);
    let read = |positions: [i32; 4]| {
        let frames = positions.map(|position| format!(r#"{{"{number}": {position}}}"#)).join(", ");
        blender::read(&format!(r#"{{"fps": 20, "positions": [{frames}]}}"#), &rig)
            .map_err(|error| error.to_string())
    };
    let name = &servo.name;
    let refused = |unit: &str, found: i32| {
        Err(format!("servo `{name}`: {found} is no pulse of this servo (500 to 2500 us): {unit}"))
    };
    assert_eq!(
        read([375, 380, 390, 400]).map(|_| ()),
        refused("12-bit steps of a PCA9685? At 50 Hz 375 of them are 1831 us", 375)
    );
    for (positions, found) in [([90, 91, 92, 180], 90), ([-45, 0, 10, 45], -45)] {
        assert_eq!(read(positions).map(|_| ()), refused("degrees? 1500 us is the middle", found));
    }
    assert_eq!(read([6144; 4]).map(|_| ()), refused("1500 us is the middle", 6144));
    // A motion that goes beyond an end for a while exceeds a limit, which `bake` reports.
    for positions in [[480, 490, 600, 700], [1500, 2600, 1500, 1500], [500, 2500, 1500, 1500]] {
        assert_eq!(read(positions).unwrap().0[0].positions, positions);
    }
}

#[test]
fn the_add_ons_json_comes_back() {
    let rig = arm(3).unwrap();
    let mechanism = rig.mechanism().unwrap();
    let tracks = servos::tracks(&rig, &mechanism, &swing(&mechanism)).unwrap();
    let text = blender::write("arm", &tracks, 50.0).unwrap();
    let (back, fps) = blender::read(&text, &rig).unwrap();
    assert!((fps - 50.0).abs() < 1e-12);
    assert_eq!(back, tracks);
    // Only changes, and the later format.
    let number = servos::number_of(tracks[0].address);
    let few = format!(
        r#"{{"fps": 30, "positions": [{{"{number}": 2000}}, {{}}, {{"{number}": 2010}}]}}"#
    );
    assert_eq!(blender::read(&few, &rig).unwrap().0[0].positions, [2000, 2000, 2010]);
    let later =
        format!(r#"{{"fps": 30, "servos": {{"{number}": {{"name": "a", "positions": [1, 2]}}}}}}"#);
    assert_eq!(blender::read(&later, &rig).unwrap().0[0].positions, [1, 2]);
    for (bad, part) in [
        (r#"{"fps": 0, "positions": []}"#, "from 1 to 1000"),
        (r#"{"fps": 30, "positions": []}"#, "found 0 frames"),
        (r#"{"fps": 30}"#, "expected `positions`"),
        (r#"{"fps": 30, "positions": [{"200": 1}, {}]}"#, "servo 200: expected the ids"),
        ("[", "expected the JSON"),
    ] {
        let told = blender::read(bad, &rig).unwrap_err().to_string();
        assert!(told.contains(part), "{told}");
    }
}

#[test]
fn a_clip_has_the_bodies_where_the_rig_has_them() {
    let mut rig = arm(6).unwrap();
    rig.mount.base = sinew_rig::description::Base::Driven;
    let mechanism = rig.mechanism().unwrap();
    let motion = swing(&mechanism);
    let clip = clip::clip("swing", &mechanism, &motion);
    for (q, frame) in motion.rows.iter().zip(&clip.frames) {
        let (poses, joints) = (mechanism.poses(q), forward_kinematics(&clip.skeleton, frame));
        for (pose, joint) in poses.iter().zip(&joints) {
            assert!((pose.position_m - joint.position_m).length() < 1e-12);
        }
    }
    assert!(sinew_mocap::bvh::text(&clip, 0.01).is_ok());
}

#[test]
fn a_table_names_its_columns_and_turns_the_root_to_z_up() {
    let mut rig = arm(2).unwrap();
    rig.mount.base = sinew_rig::description::Base::Driven;
    rig.mount.position_m = [1.0, 2.0, 3.0];
    let mechanism = rig.mechanism().unwrap();
    let motion = RigMotion { dt_s: 0.5, rows: vec![mechanism.home(); 2] };
    let text = table::csv(&mechanism, &motion, 0.0);
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!(
        names[..8],
        ["time", "root_x", "root_y", "root_z", "root_qw", "root_qx", "root_qy", "root_qz"]
    );
    assert_eq!(
        names[8..],
        mechanism.bodies[1..]
            .iter()
            .map(|link| format!("{}_deg", link.joint_name))
            .collect::<Vec<_>>()
    );
    let row: Vec<f64> = lines.nth(1).unwrap().split(',').map(|x| x.parse().unwrap()).collect();
    assert_eq!(row[..4], [0.5, 1.0, -3.0, 2.0]);
}
