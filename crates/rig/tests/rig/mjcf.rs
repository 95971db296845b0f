//! MJCFs with one special feature each. The golden file `quirks` tests that all forms of poses and masses give
//! MuJoCo's torques.

#![expect(clippy::float_cmp, reason = "numbers of the file that nothing is computed with")]

use sinew_rig::description::JointType;
use sinew_rig::import::{Imported, NoteKind, Options, mjcf, mjcf_with_parts, urdf};

use crate::common;
use crate::common::assert_noted;

/// Creates a model with sections before and after its bodies.
fn model(before: &str, bodies: &str, behind: &str) -> String {
    format!("<mujoco model=\"m\">{before}<worldbody>{bodies}</worldbody>{behind}</mujoco>")
}

/// Creates a fixed body `a`, and on it a body `b` with this content.
fn moved(inside: &str) -> String {
    model("", &on_stand(inside), "")
}

fn on_stand(inside: &str) -> String {
    format!("<body name=\"a\"><geom size=\"0.1\"/><body name=\"b\">{inside}</body></body>")
}

const JOINT: &str = r#"<joint name="j" range="-90 90"/><geom size="0.1"/>"#;

fn read(text: &str) -> Imported {
    mjcf(text, &Options::default()).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn assert_refused(text: &str, item: &str, expected: &str, found: &str) {
    common::assert_refused(mjcf(text, &Options::default()), item, expected, found);
}

#[test]
fn angles_are_degrees_unless_the_compiler_says_otherwise() {
    let range = |before: &str| {
        read(&model(before, &on_stand(JOINT), "")).description.joints[0].range_rad[0][1]
    };
    assert!((range("") - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert_eq!(range(r#"<compiler angle="radian"/>"#), 90.0);
    assert_eq!(range(r#"<compiler/><compiler angle="degree"/><compiler angle="radian"/>"#), 90.0);
    let gon = model(r#"<compiler angle="gon"/>"#, &on_stand(JOINT), "");
    assert_refused(&gon, "mujoco: compiler: angle", "degree or radian", "`gon`");
    let global = model(r#"<compiler coordinate="global"/>"#, &on_stand(JOINT), "");
    assert_refused(&global, "mujoco: compiler: coordinate", "local", "`global`");
}

#[test]
fn ranges_limit_by_themselves_or_by_a_word() {
    let ranges = |before: &str, joint: &str| {
        let inside = format!("<joint name=\"j\" {joint}/><geom size=\"0.1\"/>");
        read(&model(before, &on_stand(&inside), "")).description.joints[0].range_rad.len()
    };
    let no_auto = r#"<compiler autolimits="false"/>"#;
    assert_eq!(ranges("", r#"range="-1 1""#), 1);
    assert_eq!(ranges("", r#"range="-1 1" limited="false""#), 0);
    assert_eq!(ranges(no_auto, r#"range="-1 1""#), 0);
    assert_eq!(ranges(no_auto, r#"range="-1 1" limited="true""#), 1);
    assert_refused(
        &moved(r#"<joint name="j" limited="true"/><geom size="0.1"/>"#),
        "joint `j`: range",
        "the least and the most",
        "none",
    );
}

#[test]
fn what_stands_for_none_is_none() {
    let joint = |attributes: &str, actuator: &str| {
        let inside = format!("<joint name=\"j\" {attributes}/><geom size=\"0.1\"/>");
        let actuators = format!("<actuator>{actuator}</actuator>");
        read(&model("", &on_stand(&inside), &actuators))
    };
    let motor = r#"<motor joint="j" ctrlrange="-2 2"/>"#;
    for range in ["0 0", "1 1", "-1e6 1e6", "-inf inf", "-3.4e38 3.4e38"] {
        let imported = joint(&format!("range=\"{range}\""), motor);
        assert!(imported.description.joints[0].range_rad.is_empty(), "{range}");
        assert_noted(&imported, NoteKind::LeftOut, "for none: the rig has none there (`j`)");
        let imported = joint(&format!("actuatorfrcrange=\"{range}\""), motor);
        assert_eq!(imported.description.joints[0].effort, Some(2.0), "{range}");
    }
    for forces in ["-1e9 1e9", "0 0", "-inf inf"] {
        let general = format!("<general joint=\"j\" forcerange=\"{forces}\"/>");
        assert_eq!(joint("", &general).description.joints[0].effort, None, "{forces}");
    }
    let strong = joint("", r#"<motor joint="j" gear="1e6" ctrlrange="-2 2"/>"#);
    assert_eq!(strong.description.joints[0].effort, None);
    assert_noted(&strong, NoteKind::LeftOut, "the force 2e6 stands for none");
    let locked = joint(r#"damping="1e11""#, motor);
    assert_eq!(locked.description.joints[0].damping, 0.0);
    assert_noted(&locked, NoteKind::LeftOut, "damping = 1e11, which nothing has");
}

#[test]
fn tendons_of_two_joints_tie_them() {
    let hand = |tendon: &str, equality: &str| {
        let bodies = r#"<body name="a"><geom size="0.1"/><body name="b"><joint name="i"/><geom size="0.1"/>
            <body name="c"><joint name="j" ref="10"/><geom size="0.1"/></body></body></body>"#;
        let behind = format!("<tendon>{tendon}</tendon><equality>{equality}</equality>");
        read(&model("", bodies, &behind))
    };
    let fixed = |attributes: &str| {
        format!(
            r#"<fixed name="t" {attributes}><joint joint="i" coef="2"/><joint joint="j" coef="-4"/></fixed>"#
        )
    };
    // 2 i - 4 (j - 10 deg) = 0.
    let tied = hand(&fixed(""), r#"<tendon tendon1="t"/>"#);
    let [limit] = tied.description.limits.as_slice() else { panic!("one limit") };
    assert_eq!((limit.joint.as_str(), limit.other.as_str()), ("j", "i"));
    assert_eq!((limit.factor, limit.other_factor), (1.0, -0.5));
    assert!((limit.least_rad.unwrap() - 10.0_f64.to_radians()).abs() < 1e-12);
    let ranged = hand(&fixed(r#"range="-1 0.5""#), "");
    let [limit] = ranged.description.limits.as_slice() else { panic!("one limit") };
    assert_eq!((limit.factor, limit.other_factor), (2.0, -4.0));
    assert_eq!((limit.least_rad, limit.most_rad), (Some(-1.0), Some(0.5)));
    let spring = hand(&fixed(r#"stiffness="3""#), "");
    assert!(spring.description.limits.is_empty());
    assert_noted(&spring, NoteKind::LeftOut, "until one servo drives them (`t of `i`, `j``)");
}

#[test]
fn a_hinge_and_a_slide_are_tied_too() {
    let rack = |behind: &str| {
        let bodies = r#"<body name="a"><geom size="0.1"/><body name="b"><joint name="turn" range="-90 90"/>
            <geom size="0.1"/></body><body name="c"><joint name="way" type="slide" range="0 0.02"/><geom size="0.1"/>
            </body></body>"#;
        read(&model("", bodies, behind)).description
    };
    // The tie is way = 0.01 + 0.02 turn: a turn of 0.5 rad moves the slide by 10 mm.
    let by_turn = rack(
        r#"<equality><joint joint1="way" joint2="turn" polycoef="0.01 0.02 0 0 0"/></equality>"#,
    );
    let [limit] = by_turn.limits.as_slice() else { panic!("one limit") };
    assert_eq!((limit.joint.as_str(), limit.other_factor), ("way", -0.02));
    assert_eq!((limit.least_m, limit.most_m, limit.least_rad), (Some(0.01), Some(0.01), None));
    // The range of the leader is reduced to the positions that the slide can reach.
    let [least, most] = by_turn.joints[0].range_rad[0];
    assert!((least + 0.5).abs() < 1e-12 && (most - 0.5).abs() < 1e-12, "{least} {most}");
    let tie = by_turn.mechanism().expect("a mechanism").ties();
    let mut q = [0.25, 0.0];
    tie.follow(&mut q);
    assert!((q[1] - 0.015).abs() < 1e-12);
    // The tie is turn = 50 way.
    let by_way =
        rack(r#"<equality><joint joint1="turn" joint2="way" polycoef="0 50 0 0 0"/></equality>"#);
    let [limit] = by_way.limits.as_slice() else { panic!("one limit") };
    assert_eq!((limit.joint.as_str(), limit.other_factor), ("turn", -50.0));
    assert_eq!((limit.least_rad, limit.least_m), (Some(0.0), None));
    // A tendon's sum is in the unit of its first joint. The limit is 0.02 turn - 1 way from -0.01 to 0.01 m.
    let ranged = rack(
        r#"<tendon><fixed name="t" range="-0.01 0.01"><joint joint="turn" coef="0.02"/><joint joint="way" coef="-1"/>
        </fixed></tendon>"#,
    );
    let [limit] = ranged.limits.as_slice() else { panic!("one limit") };
    assert_eq!((limit.factor, limit.other_factor), (1.0, -50.0));
    assert_eq!((limit.least_rad, limit.most_rad), (Some(-0.5), Some(0.5)));
}

#[test]
fn parts_in_other_files_are_included() {
    let arm =
        r#"<mujocoinclude><body name="b"><include file="parts/joint.xml"/></body></mujocoinclude>"#;
    let inner = format!("<mujoco>{JOINT}</mujoco>");
    let whole = r#"<mujoco><include file="empty.xml"/><worldbody><body name="a"><geom size="0.1"/>
        <include file="arm.xml"/></body></worldbody></mujoco>"#;
    let load = |name: &str| match name {
        "arm.xml" => Ok(arm.to_owned()),
        "parts/joint.xml" => Ok(inner.clone()),
        "empty.xml" => Ok("<mujoco/>".to_owned()),
        "self.xml" => Ok(r#"<mujoco><include file="again.xml"/></mujoco>"#.to_owned()),
        "again.xml" => Ok(r#"<mujoco><include file="self.xml"/></mujoco>"#.to_owned()),
        "large.xml" => Ok(format!("<mujoco><!--{}--><body/></mujoco>", " ".repeat(20_000_000))),
        _ => Err("no such file".to_owned()),
    };
    let imported = mjcf_with_parts(whole, &Options::default(), &load).expect("a rig");
    assert_eq!(imported.description.joints[0].name, "j");
    for (file, expected) in [
        ("missing.xml", "no such file"),
        ("../arm.xml", "`../arm.xml`"),
        ("/arm.xml", "`/arm.xml`"),
        ("self.xml", "a second time"),
        ("large.xml", "bytes"),
    ] {
        let text = whole.replace("arm.xml", file);
        let error = mjcf_with_parts(&text, &Options::default(), &load).expect_err(file);
        assert!(error.to_string().contains(expected), "{file}: {error}");
    }
}

#[test]
fn joints_of_each_type_become_those_of_a_rig() {
    for (joint, expected) in [
        (r#"<joint name="j"/>"#, JointType::Revolute),
        (r#"<joint name="j" type="slide" axis="1 0 0"/>"#, JointType::Prismatic),
        (r#"<joint name="j" type="ball" range="0 60"/>"#, JointType::Spherical),
        (r#"<freejoint name="j"/>"#, JointType::Free),
        ("", JointType::Fixed),
    ] {
        let joint = &read(&moved(&format!("{joint}<geom size=\"0.1\"/>"))).description.joints[0];
        assert_eq!(joint.kind, expected);
    }
    let screw = moved(r#"<joint name="j" type="screw"/><geom size="0.1"/>"#);
    assert_refused(&screw, "joint `j`: type", "hinge, slide, ball or free", "`screw`");
    let zero = moved(r#"<joint name="j" axis="0 0 0"/><geom size="0.1"/>"#);
    assert_refused(&zero, "joint `j`: axis", "not zero", "`0 0 0`");
    let two = moved(r#"<freejoint name="f"/><joint name="j"/><geom size="0.1"/>"#);
    assert_refused(&two, "freejoint `f`", "alone in its body", "2 joints");
}

#[test]
fn a_body_with_several_joints_is_a_chain() {
    let imported = read(&moved(&format!(r#"<joint name="i" axis="1 0 0"/>{JOINT}"#)));
    let bodies: Vec<(&str, bool)> = imported
        .description
        .bodies
        .iter()
        .map(|body| (body.name.as_str(), body.mass_kg > 0.0))
        .collect();
    assert_eq!(bodies, [("a", true), ("b_i", false), ("b", true)]);
    let ends: Vec<(&str, &str)> = imported
        .description
        .joints
        .iter()
        .map(|joint| (joint.parent.as_str(), joint.child.as_str()))
        .collect();
    assert_eq!(ends, [("a", "b_i"), ("b_i", "b")]);
    assert_noted(&imported, NoteKind::Changed, "without mass between (`b_i`)");
}

#[test]
fn classes_say_what_elements_do_not() {
    let before = r#"<default><joint armature="1"/><default class="x"><joint damping="2"/>
        <default class="y"><joint armature="3"/></default></default></default>"#;
    let joint = |attributes: &str, childclass: &str| {
        let body = format!(
            r#"<body name="a" {childclass}><geom size="0.1"/><body name="b"><joint {attributes}/><geom size="0.1"/>
            </body></body>"#
        );
        let joint = read(&model(before, &body, "")).description.joints[0].clone();
        (joint.rotor_inertia, joint.damping)
    };
    assert_eq!(joint("", ""), (Some(1.0), 0.0));
    assert_eq!(joint(r#"class="x""#, ""), (Some(1.0), 2.0));
    assert_eq!(joint(r#"class="y""#, ""), (Some(3.0), 2.0));
    assert_eq!(joint("", r#"childclass="y""#), (Some(3.0), 2.0));
    assert_eq!(joint(r#"class="main""#, r#"childclass="y""#), (Some(1.0), 0.0));
    assert_eq!(joint(r#"class="y" armature="4""#, ""), (Some(4.0), 2.0));
    let unknown = moved(r#"<joint name="j" class="z"/><geom size="0.1"/>"#);
    assert_refused(&unknown, "joint `j`: class", "a class of the file", "`z`");
}

#[test]
fn a_quaternion_begins_with_w() {
    let text = model("", r#"<body name="a"><body name="b" quat="0 2 0 0"/></body>"#, "");
    assert_eq!(read(&text).description.joints[0].rotation_xyzw, [1.0, 0.0, 0.0, 0.0]);
    let zero = model("", r#"<body name="a" quat="0 0 0 0"/>"#, "");
    assert_refused(&zero, "body `a`: quat", "length zero", "`0 0 0 0`");
    let two = model("", r#"<body name="a" quat="1 0 0 0" euler="0 0 0"/>"#, "");
    assert_refused(&two, "body `a`: euler", "one way", "`0 0 0`");
}

#[test]
fn the_body_that_floats_or_stands_is_the_base() {
    let floats =
        read(&model("", r#"<body name="a" pos="1 2 3"><freejoint/><geom size="0.1"/></body>"#, ""));
    assert_eq!(floats.description.bodies[0].name, "a");
    let position = floats.description.mount.position_m;
    assert!((glam::DVec3::from(position) - glam::DVec3::new(1.0, 3.0, -2.0)).length() < 1e-12);
    assert_noted(&floats, NoteKind::Changed, "mount.base = \"driven\"");
    // A body that turns in the world gets the world as its base.
    let turns = read(&model("", &format!("<body name=\"a\">{JOINT}</body>"), ""));
    assert_eq!(turns.description.bodies[0].name, "world");
    let ball = |name| format!("<body name=\"{name}\"><freejoint/><geom size=\"0.1\"/></body>");
    let two = model("", &(ball("a") + &ball("c")), "");
    assert_refused(&two, "mujoco", "the option cut", "2: `a`, `c`");
    let options = Options { cut: vec!["c".to_owned()], ..Options::default() };
    let one = mjcf(&two, &options).expect("a rig");
    assert_eq!(one.description.bodies.len(), 1);
    assert_noted(&one, NoteKind::LeftOut, "by the user's word (`c`)");
}

#[test]
fn geoms_weigh_if_no_inertial_does() {
    let mass = |before: &str, inside: &str| {
        let inside = format!("<joint/>{inside}");
        read(&model(before, &on_stand(&inside), "")).description.bodies[1].mass_kg
    };
    let cube = r#"<geom type="box" size="0.5 0.5 0.5"/>"#;
    let inertial = r#"<inertial pos="0 0 0" mass="3" diaginertia="1 1 1"/>"#;
    assert!((mass("", cube) - 1000.0).abs() < 1e-9, "water");
    assert_eq!(mass("", &format!("{inertial}{cube}")), 3.0);
    let always = r#"<compiler inertiafromgeom="true"/>"#;
    assert!((mass(always, &format!("{inertial}{cube}")) - 1000.0).abs() < 1e-9);
    assert_eq!(mass(r#"<compiler inertiafromgeom="false"/>"#, cube), 0.0);
    assert_eq!(mass(r#"<compiler inertiagrouprange="1 2"/>"#, cube), 0.0);
    assert_eq!(mass(r#"<compiler boundmass="2"/>"#, r#"<geom size="0.1" mass="0.5"/>"#), 2.0);
    let total: f64 = read(&model(r#"<compiler settotalmass="7"/>"#, &on_stand(JOINT), ""))
        .description
        .bodies
        .iter()
        .map(|body| body.mass_kg)
        .sum();
    assert!((total - 7.0).abs() < 1e-9);
    let shrunk = moved(r#"<joint/><geom type="box" size="0.1 0.1"/>"#);
    assert_refused(&shrunk, "body `b`: geom: size", "3 sizes above zero", "`0.1 0.1`");
}

#[test]
fn meshes_do_not_weigh() {
    let mesh = moved(r#"<joint name="j"/><geom type="mesh" mesh="x" mass="2" pos="0 0 1"/>"#);
    assert_refused(&mesh, "body `b`: geom", "meshes are not read", "a mesh");
    let options = Options { repair_inertia: true, ..Options::default() };
    let imported = mjcf(&mesh, &options).expect("a rig");
    let body = &imported.description.bodies[1];
    assert_eq!(
        (body.mass_kg, body.center_of_mass_m, body.inertia_kg_m2),
        (2.0, [0.0, 0.0, 1.0], None)
    );
    assert_noted(&imported, NoteKind::Filled, "that of a point where the mesh is (`b`)");
    // Geoms without mass do not matter.
    read(&moved(r#"<joint name="j"/><geom type="mesh" mesh="x" mass="0"/><geom size="0.1"/>"#));
}

#[test]
fn impossible_inertia_is_refused_or_balanced() {
    let inside = r#"<joint name="j"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 4"/>"#;
    assert_refused(&moved(inside), "body `b`: inertial", "repair-inertia", "a principal moment");
    let own = model(r#"<compiler balanceinertia="true"/>"#, &on_stand(inside), "");
    let inertia = read(&own).description.bodies[1].inertia_kg_m2.expect("an inertia");
    assert_eq!((inertia.xx, inertia.yy, inertia.zz), (2.0, 2.0, 2.0));
}

#[test]
fn actuators_tell_how_strong_joints_are() {
    let joint = |actuators: &str| {
        let before = r#"<default><position kp="7" forcerange="-2 3"/></default>"#;
        read(&model(before, &on_stand(JOINT), &format!("<actuator>{actuators}</actuator>")))
    };
    for (actuators, effort) in [
        (r#"<position joint="j"/>"#, 3.0),
        (r#"<position joint="j" gear="2"/>"#, 6.0),
        (r#"<motor joint="j" gear="10" ctrlrange="-0.5 0.4" forcelimited="false"/>"#, 5.0),
        (r#"<position joint="j" forcerange="-1 1"/><position joint="j" forcerange="-1 1"/>"#, 2.0),
    ] {
        let imported = joint(actuators);
        assert_eq!(imported.description.joints[0].effort, Some(effort), "{actuators}");
    }
    assert_noted(&joint(r#"<position joint="j"/>"#), NoteKind::LeftOut, "j: kp 7, kv 0");
    assert_noted(&joint(r#"<muscle tendon="t" name="m"/>"#), NoteKind::LeftOut, "(`m`)");
    assert_noted(
        &joint(r#"<muscle tendon="t" name="m"/>"#),
        NoteKind::Doubtful,
        "no actuator drives it; the",
    );
    let ghost = model("", &on_stand(JOINT), r#"<actuator><motor joint="x"/></actuator>"#);
    assert_refused(&ghost, "mujoco: actuator: motor: joint", "a joint of the file", "`x`");
    let own = read(&moved(r#"<joint name="j" actuatorfrcrange="-4 4"/><geom size="0.1"/>"#));
    assert_eq!(own.description.joints[0].effort, Some(4.0));
}

#[test]
fn equalities_tie_joints_and_close_loops() {
    let both = r#"<body name="a"><geom size="0.1"/><body name="b"><joint name="j" ref="10"/><geom size="0.1"/></body>
        <body name="c"><joint name="k"/><geom size="0.1"/></body></body>"#;
    let text = |equality: &str| model("", both, &format!("<equality>{equality}</equality>"));
    let tied = read(&text(r#"<joint joint1="j" joint2="k" polycoef="0.1 -2 0 0 0"/>"#));
    let [limit] = tied.description.limits.as_slice() else { panic!("one limit") };
    assert_eq!((limit.joint.as_str(), limit.other.as_str(), limit.other_factor), ("j", "k", 2.0));
    let offset = 0.1 + 10_f64.to_radians();
    assert!(
        (limit.least_rad.expect("an end") - offset).abs() < 1e-12,
        "from where the bodies are drawn"
    );
    let curve = read(&text(r#"<joint joint1="j" joint2="k" polycoef="0 1 1 0 0"/>"#));
    assert_noted(&curve, NoteKind::LeftOut, "along a curve");
    let shut = text(r#"<connect body1="b" body2="c" anchor="0 0 0"/>"#);
    assert_refused(&shut, "mujoco: equality: connect", "open-loops", "connect of `b`, `c`");
    let options = Options { open_loops: true, ..Options::default() };
    assert_noted(&mjcf(&shut, &options).expect("a tree"), NoteKind::Doubtful, "They stay open");
    let options = Options { cut: vec!["k".to_owned()], ..Options::default() };
    assert_eq!(mjcf(&shut, &options).expect("a tree").description.bodies.len(), 2);
    read(&text(r#"<weld body1="a"/><connect body1="b" body2="c" active="false"/>"#));
}

#[test]
fn what_stands_in_other_files_is_refused() {
    assert_refused("<robot/>", "robot", "`mujoco`", "`robot`");
    let include = r#"<mujoco><include file="x.xml"/></mujoco>"#;
    assert_refused(include, "mujoco: include", "mj_saveLastXML", "`include`");
    let many = model("", r#"<replicate count="3"><body name="a"/></replicate>"#, "");
    assert_refused(&many, "mujoco: worldbody: replicate", "mj_saveLastXML", "`replicate`");
    assert_refused("<mujoco/>", "mujoco", "a body in `worldbody`", "none");
    let twice = model("", r#"<body name="a"/><body name="a"/>"#, "");
    assert_refused(&twice, "body `a`: name", "no other one", "`a`");
}

#[test]
fn bodies_nested_by_thousands_take_no_stack() {
    let deep = "<body>".repeat(20_000) + &"</body>".repeat(20_000);
    assert_eq!(read(&model("", &deep, "")).description.bodies.len(), 20_000);
}

/// An arm with a slide, in both formats: the imported rigs must be equal.
#[test]
fn a_urdf_and_an_mjcf_of_one_arm_are_one_rig() {
    let from_urdf = r#"<robot name="arm">
        <link name="stand"/>
        <link name="upper"><inertial><origin xyz="0.1 0 0"/><mass value="0.4"/>
            <inertia ixx="0.001" iyy="0.002" izz="0.0025" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <link name="hand"><inertial><origin xyz="0 0 0.05"/><mass value="0.1"/>
            <inertia ixx="0.0001" iyy="0.0002" izz="0.0002" ixy="0.00001" ixz="0" iyz="0"/></inertial></link>
        <joint name="shoulder" type="revolute"><origin xyz="0 0 0.2" rpy="0.3 0 0"/><parent link="stand"/>
            <child link="upper"/><axis xyz="0 1 0"/><limit lower="-1" upper="2" effort="3"/>
            <dynamics damping="0.1" friction="0.2"/></joint>
        <joint name="reach" type="prismatic"><origin xyz="0.25 0 0"/><parent link="upper"/><child link="hand"/>
            <axis xyz="1 0 0"/><limit lower="0" upper="0.1" effort="20"/></joint></robot>"#;
    let from_mjcf = r#"<mujoco model="arm"><compiler angle="radian"/><worldbody><body name="stand">
        <body name="upper" pos="0 0 0.2" euler="0.3 0 0">
            <inertial pos="0.1 0 0" mass="0.4" diaginertia="0.001 0.002 0.0025"/>
            <joint name="shoulder" axis="0 1 0" range="-1 2" damping="0.1" frictionloss="0.2"/>
            <body name="hand" pos="0.25 0 0">
                <inertial pos="0 0 0.05" mass="0.1" fullinertia="0.0001 0.0002 0.0002 0.00001 0 0"/>
                <joint name="reach" type="slide" axis="1 0 0" range="0 0.1"/>
            </body></body></body></worldbody><actuator><motor joint="shoulder" ctrlrange="-3 3"/>
            <position joint="reach" forcerange="-20 20"/></actuator></mujoco>"#;
    let urdf = urdf(from_urdf, &Options::default()).expect("a rig").description;
    assert_eq!(urdf, read(from_mjcf).description);
}

/// MuJoCo has no units: a gravity of 981 means centimetres.
#[test]
fn gravity_tells_the_unit_and_what_is_up() {
    let inside = r#"<joint name="j" range="-90 90"/><geom size="10" mass="2"/>"#;
    let bodies = format!(
        r#"<body name="a" pos="0 100 0"><geom size="10" mass="1"/><body name="b" pos="0 20 0">{inside}</body></body>"#
    );
    let imported = read(&model(r#"<option gravity="0 -981 0"/>"#, &bodies, ""));
    let rig = &imported.description;
    assert_eq!((imported.world.metres_per_unit, imported.world.up), (0.01, glam::DVec3::Y));
    assert_eq!(rig.mount.rotation_xyzw, [0.0, 0.0, 0.0, 1.0]);
    assert_eq!(
        (rig.mount.position_m, rig.joints[0].position_m),
        ([0.0, 1.0, 0.0], [0.0, 0.2, 0.0])
    );
    // A ball of 10 cm radius.
    let inertia = rig.bodies[1].inertia_kg_m2.unwrap().xx;
    assert!((inertia - 0.4 * 2.0 * 0.01).abs() < 1e-12, "{inertia}");
    let mine =
        Options { metres_per_unit: Some(1.0), up: Some(glam::DVec3::Z), ..Options::default() };
    let text = model(r#"<option gravity="0 -981 0"/>"#, &bodies, "");
    let told = mjcf(&text, &mine).unwrap().world;
    assert_eq!((told.metres_per_unit, told.up), (1.0, glam::DVec3::Z));
}
