//! Positions of servos in the format of the Blender add-on: exported, and read again.

use super::done;
use crate::common::path;

#[test]
fn servo_positions_come_back_as_the_same_motion() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, map, json, first, second] =
        ["arm.toml", "map.toml", "arm.json", "first.show", "second.show"]
            .map(|name| path(folder.path(), name));
    done(&["rig", "new", "--arm", "3", "-o", &rig]);
    let mechanism = super::mechanism(&rig);
    let joint = &mechanism.bodies[1].joint_name;
    let curve = format!(
        "rig = \"arm\"\nclip = \"punches_01\"\n\n[[curve]]\nclip = \"forearm_l\"\naxis = [0, 0, 1]\nrig = \"{joint}\"\n\
         points_deg = [[-180, -60], [180, 60]]\n"
    );
    std::fs::write(&map, curve).unwrap();
    done(&[
        "clip",
        "export",
        "punches_01",
        "--rig",
        &rig,
        "--mapping",
        &map,
        "--rate-hz",
        "50",
        "-o",
        &json,
    ]);
    let [report, _] = done(&["bake", &json, "--rig", &rig, "-o", &first]);
    assert!(report.contains("arm on"), "{report}");
    // A motion that was read once stays the same when it is written and read again.
    let again = path(folder.path(), "again.json");
    done(&["clip", "export", &json, "--rig", &rig, "--rate-hz", "50", "-o", &again]);
    done(&["bake", &again, "--rig", &rig, "-o", &second]);
    assert_eq!(std::fs::read(first).unwrap(), std::fs::read(second).unwrap());
}
