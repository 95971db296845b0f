use super::*;

/// A base with an arm, the outer joint first in the file: its fixed elbow is 1 m above a shoulder that is rotated
/// forwards by a quarter turn.
const ROBOT: &str = r#"<?xml version="1.0"?>
<robot name="arm">
  <link name="base"/><link name="upper"/><link name="lower"><inertial><mass value="1"/></inertial></link>
  <joint name="elbow" type="fixed">
    <origin xyz="0 0 1"/><parent link="upper"/><child link="lower"/>
  </joint>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/>
    <origin xyz="0.1 0.2 0.3" rpy="0 1.5707963267948966 0"/>
  </joint>
</robot>
"#;

fn robot(text: &str) -> Result<Character, Refusal> {
    urdf::parse(text.as_bytes(), "arm".into())
}

#[test]
fn name_spaces_that_would_take_minutes_are_refused_at_once() {
    let spaces = " xmlns:a='a'".repeat(10_000);
    let refusal = urdf::parse(format!("<robot{spaces}/>").as_bytes(), "x".into()).unwrap_err();
    assert!(refusal.to_string().contains("name spaces"), "{refusal}");
}

#[test]
fn joints_of_a_rig_come_from_the_root_outwards() {
    let character = robot(ROBOT).unwrap();
    let names: Vec<_> = character.joints().iter().map(|j| (j.name.as_str(), j.parent)).collect();
    assert_eq!(names, [("base", None), ("shoulder", Some(0)), ("elbow", Some(1))]);
    // x left, y up, z ahead; the file's offset is 0.1 ahead, 0.2 left, 0.3 up.
    let place = |joint: usize| character.joints()[joint].position_m;
    assert!(place(1).distance(DVec3::new(0.2, 0.3, 0.1)) < 1e-12, "{}", place(1));
    assert!(place(2).distance(DVec3::new(0.2, 0.3, 1.1)) < 1e-12, "{}", place(2));
}

#[test]
fn the_root_and_a_joint_may_have_one_name() {
    let names = |text: &str| -> Vec<String> {
        robot(text).unwrap().joints().iter().map(|joint| joint.name.clone()).collect()
    };
    let shared = ROBOT.replace("joint name=\"elbow\"", "joint name=\"base\"");
    assert_eq!(names(&shared), ["base (link)", "shoulder", "base"]);
    let both = shared.replace("joint name=\"shoulder\"", "joint name=\"base (link)\"");
    assert_eq!(names(&both), ["base (link) (link)", "base (link)", "base"]);
}

#[test]
fn what_is_no_rig_is_refused_with_its_line() {
    let message = |old: &str, new: &str| {
        assert!(ROBOT.contains(old), "{old}");
        robot(&ROBOT.replace(old, new)).unwrap_err().to_string()
    };
    assert_eq!(
        message("<origin xyz=\"0 0 1\"/>", "<origin xyz=\"0 0 nan\"/>"),
        "5:5: joint `elbow`: xyz: expected three finite numbers, found `0 0 nan`"
    );
    assert!(
        message("xyz=\"0 0 1\"", "xyz=\"0 1\"")
            .contains("expected three finite numbers, found `0 1`")
    );
    assert_eq!(
        message("<child link=\"lower\"/>", "<child link=\"hand\"/>"),
        "5:48: joint `elbow`: child: expected a link of the robot, found `hand`"
    );
    assert_eq!(
        message("<child link=\"lower\"/>", ""),
        "4:3: joint `elbow`: child: expected an element of this name, found none"
    );
    assert!(
        message("<child link=\"lower\"/>", "<child/>")
            .contains("`child`: expected the attribute `link`")
    );
    assert_eq!(
        message("<child link=\"lower\"/>", "<child link=\"upper\"/>"),
        "7:3: link `upper`: expected one joint that moves it, found `elbow` and `shoulder`"
    );
    assert_eq!(
        message("type=\"fixed\"", "type=\"hinge\""),
        "4:3: joint `elbow`: type: expected one of revolute, continuous, prismatic, fixed, floating, planar, found `hinge`"
    );
    assert!(
        message(" type=\"fixed\"", "")
            .starts_with("4:3: joint `elbow`: `joint`: expected the attribute `type`, found none")
    );
    assert_eq!(
        message("<origin xyz=\"0 0 1\"/>", "<origin/><origin xyz=\"0 0 1\"/>"),
        "5:14: joint `elbow`: origin: expected one element of this name, found 2"
    );
    assert!(
        message("<parent link=\"upper\"/>", "<parent link=\"upper\"/>\n<parent link=\"base\"/>")
            .starts_with("6:1: joint `elbow`: parent: expected one element of this name, found 2")
    );
    assert_eq!(
        message("rpy=\"0 1.5707963267948966 0\"", "rpy=\"0 1e308 0\""),
        "9:5: joint `shoulder`: rpy: expected three angles of at most 1000000 rad, found `0 1e308 0`"
    );
    assert!(
        message("xyz=\"0.1 0.2 0.3\"", "xyz=\"0 1e308 0\"").contains("expected finite coordinates")
    );
    assert_eq!(
        robot("<robot name=\"nothing\"/>").unwrap_err().to_string(),
        "1:1: the robot: expected a link, found none"
    );
    let round = message("<parent link=\"base\"/>", "<parent link=\"lower\"/>");
    assert!(round.contains("expected ancestors that end at a root, found a loop"), "{round}");
    let apart = message("<link name=\"base\"/>", "<link name=\"base\"/><link name=\"other\"/>");
    assert!(
        apart.contains("expected one link that no joint moves, found `base` and `other`"),
        "{apart}"
    );
    assert!(
        message("<link name=\"upper\"/>", "<link name=\"base\"/><link name=\"upper\"/>")
            .contains("a name of its own")
    );
    assert!(
        message("name=\"elbow\"", "name=\"shoulder\"")
            .contains("joint 2 `shoulder`: expected a name of its own")
    );
    assert!(
        robot("<sdf/>")
            .unwrap_err()
            .to_string()
            .contains("expected the element `robot`, found `sdf`")
    );
    assert!(message("</robot>", "").contains("a URDF: expected well-formed XML"));
}

proptest! {
    #[test]
    fn no_damage_makes_the_reader_of_urdf_panic(damage in damage()) {
        check(urdf::parse(&damaged(ROBOT.into(), damage), "x".into()));
    }
}

/// Reads every rig of the data, and compares the number of joints with those that move.
#[test]
#[ignore = "needs SINEW_DATA"]
fn real_rigs_are_read() {
    for file in [
        "urdf/poppy-humanoid/Poppy_Humanoid.urdf",
        "urdf/robotis-op3/robotis_op3.urdf",
        "urdf/open-duck-mini/open_duck_mini_v2.urdf",
    ] {
        let text = std::fs::read_to_string(data().join(file)).unwrap();
        let types = ["revolute", "continuous", "prismatic"];
        let moving: usize =
            types.iter().map(|kind| text.matches(&format!("type=\"{kind}\"")).count()).sum();
        let character = read(&data().join(file), &Options::default()).unwrap();
        // Moving joints, plus the root and the ends of limbs.
        assert!(moving > 10 && character.joints().len() > moving, "{file}: {moving}");
    }
}
