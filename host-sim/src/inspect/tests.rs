use std::fs;

use sinew_retarget::Landmark;

use super::inspected::Kind;
use super::*;

const BVH: &str = "HIERARCHY\nROOT a\n{ OFFSET 0 0 0 CHANNELS 3 Zrotation Xrotation Yrotation JOINT b\n\
    { OFFSET 0 0 20 CHANNELS 3 Zrotation Xrotation Yrotation End Site { OFFSET 0 5 0 } } }\nMOTION\nFrames: 2\n\
    Frame Time: 0.01\n0 0 0 0 0 0\n90 0 0 0 0 0\n";

fn of(name: &str, text: &str, units: UnitOverrides) -> Entry {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(name);
    fs::write(&file, text).unwrap();
    Entry::of(&file, units)
}

fn read(entry: Entry) -> Inspected {
    match entry {
        Entry::Read(inspected) => *inspected,
        Entry::Unread { error, .. } => panic!("{error}"),
    }
}

#[test]
fn a_motion_is_shown_though_nothing_tells_its_unit() {
    let motion = read(of("a.bvh", BVH, UnitOverrides::default()));
    assert_eq!((motion.kind, motion.format, motion.joints), (Kind::Motion, "BVH", 2));
    assert_eq!((motion.frames, motion.metres_per_unit, motion.height_m), (Some(2), None, None));
    assert!((motion.rate_hz.unwrap() - 100.0).abs() < 1e-9);
    assert_eq!(motion.landmarks_missing.len(), Landmark::ALL.len());
    let units = UnitOverrides { metres_per_unit: Some(0.01), up: Some(sinew_mocap::Up::Z) };
    let motion = read(of("a.bvh", BVH, units));
    assert_eq!((motion.up, motion.metres_per_unit), ("z", Some(0.01)));
    assert!((motion.height_m.unwrap() - 0.2).abs() < 1e-9, "{:?}", motion.height_m);
    let text = text::block(&motion);
    assert!(text.contains("  a\n    b  0.200 m\n"), "{text}");
}

#[test]
fn a_rig_shows_its_fixed_joints_too() {
    let urdf = "<robot name='r'><link name='base'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' \
        ixz='0' iyz='0'/></inertial></link><link name='tip'/><link name='arm'><inertial><mass value='1'/>\
        <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>\
        <joint name='weld' type='fixed'><parent link='arm'/><child link='tip'/></joint>\
        <joint name='turn' type='continuous'><parent link='base'/><child link='arm'/><axis xyz='0 0 1'/></joint></robot>";
    let rig = read(of("r.urdf", urdf, UnitOverrides::default()));
    assert_eq!((rig.kind, rig.joints), (Kind::Rig, 2));
    let names: Vec<_> = rig.tree.iter().map(|joint| (joint.name.as_str(), joint.parent)).collect();
    assert_eq!(names, [("turn", None), ("weld", Some(0))]);
}

#[test]
fn what_cannot_be_read_is_an_entry_with_its_reason() {
    let entry = of("a.fbx", "x", UnitOverrides::default());
    assert!(!entry.is_read());
    let json = serde_json::to_value(&entry).unwrap();
    assert!(json["error"].as_str().unwrap().contains("FBX, which is not read"), "{json}");
    assert!(json["file"].as_str().unwrap().ends_with("a.fbx"));
}
