//! `sinew play --qemu`: the node of boards, as an Arm image, says on the wire what is said in process.

use std::path::{Path, PathBuf};

use super::done;
use crate::common::{command, path};

/// Plays in process, then in QEMU: the same table, hash and states. Returns the table, and how much was compared.
#[track_caller]
fn same_in_qemu(play: &[&str]) -> [String; 2] {
    assert!(
        std::env::var_os("SINEW_NODE_IMAGE").is_some(),
        "SINEW_NODE_IMAGE: `cargo xtask node` sets it"
    );
    let [own, own_notes] = done(play);
    let [table, notes] = done(&[play, &["--qemu"]].concat());
    assert!(own.contains("faults: none") && own.contains(" 0 not whole"), "{own}");
    assert_eq!(table, own, "{play:?}");
    let (compared, others): (Vec<&str>, Vec<&str>) =
        notes.lines().partition(|line| line.starts_with("QEMU: "));
    assert_eq!(others, own_notes.lines().collect::<Vec<_>>(), "{play:?}");
    [table, compared.concat()]
}

#[test]
#[ignore = "needs the image that `cargo xtask node` builds"]
fn an_arm_says_in_qemu_what_it_says_in_process() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, map] = ["arm.toml", "map.toml"].map(|name| path(folder.path(), name));
    done(&["rig", "new", "--arm", "3", "-o", &rig]);
    let joint = &super::mechanism(&rig).bodies[2].joint_name;
    let curve = format!(
        "rig = \"arm\"\nclip = \"punches_01\"\n\n[[curve]]\nclip = \"forearm_l\"\naxis = [0, 0, 1]\nrig = \"{joint}\"\n\
         points_deg = [[-180, -60], [180, 60]]\n"
    );
    std::fs::write(&map, curve).unwrap();
    for drive in ["current", "position"] {
        let play = ["play", "punches_01", "--rig", &rig, "--mapping", &map, "--seconds", "2"];
        let [_, compared] = same_in_qemu(&[&play[..], &["--drive", drive]].concat());
        println!("an arm by {drive}: {compared}");
    }
}

/// A walk and a fight on two robots. With `SINEW_NODE_ALL`, which `cargo xtask node` sets, whole, and rows of
/// docs/play.md are printed. Else, since emulators are slow, each robot and clip once, for some seconds: more than the
/// 4 s of a show's block.
#[test]
#[ignore = "needs SINEW_DATA, and the image that `cargo xtask node` builds"]
fn robots_say_in_qemu_what_they_say_in_process() {
    let data: PathBuf = std::env::var_os("SINEW_DATA").expect("SINEW_DATA").into();
    let folder = tempfile::tempdir().unwrap();
    let import = |file: &str, more: &[&str], name: &str| {
        let (file, rig) = (data.join("urdf").join(file), path(folder.path(), name));
        let import = ["rig", "import", file.to_str().unwrap(), "--repair-inertia", "-o", &rig];
        done(&[&import[..], more].concat());
        rig
    };
    let op3 = import("robotis-op3/robotis_op3.urdf", &[], "op3.toml");
    let poppy = "poppy-humanoid/Poppy_Humanoid.urdf";
    let poppy = import(poppy, &["--turn-axis", "l_knee_y"], "poppy.toml");
    let whole = std::env::var_os("SINEW_NODE_ALL").is_some();
    let shortened: &[&str] = if whole { &[] } else { &["--seconds", "5"] };
    for (is_shared, name, rig, servo, drive, clip) in [
        (true, "OP3", &op3, "xm430", "current", "walk/07_01.bvh"),
        (false, "OP3", &op3, "xm430", "current", "fight/02_05.bvh"),
        (false, "Poppy", &poppy, "mx-64", "position", "walk/07_01.bvh"),
        (true, "Poppy", &poppy, "mx-64", "position", "fight/02_05.bvh"),
    ] {
        if !(whole || is_shared) {
            continue;
        }
        let file = data.join("cmu").join(clip);
        let play = ["play", file.to_str().unwrap(), "--rig", rig, "--servo", servo];
        let more = [&["--drive", drive][..], shortened].concat();
        let [table, compared] = same_in_qemu(&[&play[..], &more].concat());
        if whole {
            let hash = table.split("hash ").nth(1).expect(&table).trim();
            println!("| {name} | {clip} | {drive} | `{hash}` | {compared} |");
        }
    }
}

#[test]
fn what_is_missing_for_qemu_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let rig = path(folder.path(), "arm.toml");
    done(&["rig", "new", "--arm", "3", "-o", &rig]);
    let none = Path::new("no/such/image");
    let output = command()
        .args(["play", "punches_01", "--rig", &rig, "--seconds", "1", "--qemu"])
        .env("SINEW_NODE_IMAGE", none)
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{told}");
    let command = "no/such/image: there is no image of the node. `cargo xtask node` builds it";
    assert!(told.contains(command), "{told}");
}
