//! URDFs with one special feature each.

#![expect(clippy::float_cmp, reason = "numbers of the file that nothing is computed with")]

use sinew_rig::description::{InertiaMatrix, JointType};
use sinew_rig::import::{ImportError, Imported, NoteKind, Options, urdf};

use crate::common;
use crate::common::assert_noted;

/// Creates a link of 1 kg.
fn link(name: &str) -> String {
    format!(
        r#"<link name="{name}"><inertial><mass value="1"/>
        <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>"#
    )
}

/// Creates a joint from `a` to `b` with this type and these elements.
fn joint(kind: &str, inside: &str) -> String {
    format!(r#"<joint name="j" type="{kind}"><parent link="a"/><child link="b"/>{inside}</joint>"#)
}

fn robot(inside: &str) -> String {
    format!("<robot name=\"r\">\n{inside}</robot>")
}

/// Creates the links `a` and `b` and a joint between them.
fn pair(kind: &str, inside: &str) -> String {
    robot(&(link("a") + &link("b") + &joint(kind, inside)))
}

/// Creates the link `b` with this content, on a hinge on `a`.
fn moved(inside: &str) -> String {
    let b = format!(r#"<link name="b">{inside}</link>"#);
    robot(&(link("a") + &b + &joint("revolute", LIMIT)))
}

const LIMIT: &str = r#"<limit lower="-1" upper="2" effort="3" velocity="4"/>"#;

fn read(text: &str) -> Imported {
    urdf(text, &Options::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn refused(text: &str) -> ImportError {
    urdf(text, &Options::default()).expect_err("refused")
}

#[track_caller]
fn assert_refused(text: &str, item: &str, expected: &str, found: &str) {
    common::assert_refused(urdf(text, &Options::default()), item, expected, found);
}

fn close(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
}

#[test]
fn a_hinge_keeps_all_that_the_file_says_of_it() {
    let inside = r#"<origin xyz="1 2 3" rpy="0.1 0.2 0.3"/><axis xyz="0 0 2"/>
        <limit lower="-1" upper="2" effort="3" velocity="4"/><dynamics damping="0.5" friction="0.25"/>"#;
    let joint = &read(&pair("revolute", inside)).description.joints[0];
    assert_eq!((joint.name.as_str(), joint.kind), ("j", JointType::Revolute));
    assert_eq!((joint.parent.as_str(), joint.child.as_str()), ("a", "b"));
    assert_eq!(joint.position_m, [1.0, 2.0, 3.0]);
    // Half-angle quaternions of yaw 0.3, pitch 0.2 and roll 0.1, multiplied in Python.
    let rotation = [0.034_270_798_550, 0.106_020_511_062, 0.143_572_175_027, 0.983_347_443_256];
    assert!(joint.rotation_xyzw.iter().zip(rotation).all(|(a, b)| (a - b).abs() < 1e-11));
    assert_eq!(joint.axis, Some([0.0, 0.0, 1.0]), "made unit");
    assert_eq!(joint.range_rad, [[-1.0, 2.0]]);
    assert_eq!((joint.effort, joint.speed_rad_s), (Some(3.0), Some(4.0)));
    assert_eq!((joint.damping, joint.friction), (0.5, 0.25));
}

#[test]
fn joints_of_each_type_become_those_of_a_rig() {
    for (kind, expected) in [
        ("continuous", JointType::Revolute),
        ("prismatic", JointType::Prismatic),
        ("fixed", JointType::Fixed),
        ("floating", JointType::Free),
        ("spherical", JointType::Spherical),
    ] {
        assert_eq!(read(&pair(kind, LIMIT)).description.joints[0].kind, expected);
    }
    let slide = &read(&pair("prismatic", LIMIT)).description.joints[0];
    assert_eq!((slide.range_m, slide.speed_m_s), (Some([-1.0, 2.0]), Some(4.0)));
    let continuous = read(&pair("continuous", LIMIT));
    assert!(continuous.description.joints[0].range_rad.is_empty());
    assert_noted(&continuous, NoteKind::Changed, "without end");
    assert_refused(&pair("planar", ""), "joint `j`: type", "two prismatic", "`planar`");
    assert_refused(&pair("hinge", ""), "joint `j`: type", "revolute, continuous", "`hinge`");
}

#[test]
fn an_axis_is_x_by_default_and_never_zero() {
    assert_eq!(read(&pair("revolute", LIMIT)).description.joints[0].axis, Some([1.0, 0.0, 0.0]));
    let zero = r#"<axis xyz="0 0 0"/>"#;
    assert_refused(&pair("revolute", zero), "joint `j`: axis: xyz", "not zero", "`0 0 0`");
    assert_eq!(read(&pair("fixed", zero)).description.joints[0].axis, None, "nobody reads it");
    let tiny = r#"<axis xyz="0 1e-9 0"/>"#;
    let axis = read(&pair("revolute", tiny)).description.joints[0].axis.expect("an axis");
    assert!(close(&axis, &[0.0, 1.0, 0.0]));
}

#[test]
fn errors_tell_line_column_name_and_value() {
    let text = pair("revolute", "\n  <limit lower=\"-1\" upper=\"up\"/>");
    let error = refused(&text);
    assert_eq!(
        (error.to_string().as_str(), error.place.column),
        ("5:21: joint `j`: limit: upper: expected a number, found `up`", 21)
    );
}

#[test]
fn limits_that_stand_for_none_are_left_out() {
    for (value, left) in
        [("0", None), ("-1", None), ("1000", None), ("inf", None), ("1e8", None), ("7", Some(7.0))]
    {
        let limit = format!(r#"<limit lower="-1" upper="1" effort="{value}" velocity="{value}"/>"#);
        let imported = read(&pair("revolute", &limit));
        let joint = &imported.description.joints[0];
        assert_eq!((joint.effort, joint.speed_rad_s), (left, left), "{value}");
        if left.is_none() {
            assert_noted(
                &imported,
                NoteKind::LeftOut,
                &format!("the limit effort = {value} means no limit"),
            );
        }
    }
    let bad = r#"<limit lower="-1" upper="1" effort="-2"/>"#;
    assert_refused(&pair("revolute", bad), "joint `j`: limit: effort", "zero or more", "`-2`");
    let nan = r#"<limit lower="-1" upper="1" velocity="NaN"/>"#;
    assert_refused(&pair("revolute", nan), "joint `j`: limit: velocity", "zero or more", "`NaN`");
}

#[test]
fn ranges_that_stand_for_none_are_left_out() {
    for (lower, upper) in [
        ("-1e16", "1e16"),
        ("-inf", "inf"),
        ("-1000000", "1000000"),
        ("-3.4e38", "3.4e38"),
        ("-1.8e308", "1.8e308"),
        ("-1", "1e9"),
        ("0", "0"),
        ("0.0", "-0.0"),
    ] {
        let limit = format!("<limit lower='{lower}' upper='{upper}' effort='1' velocity='1'/>");
        let imported = read(&pair("revolute", &limit));
        assert!(imported.description.joints[0].range_rad.is_empty(), "{lower} {upper}");
        assert_noted(&imported, NoteKind::LeftOut, "stands for none");
    }
    let nan = "<limit lower='nan' upper='1' effort='1' velocity='1'/>";
    assert_refused(&pair("revolute", nan), "joint `j`: limit: lower", "a number", "`nan`");
}

#[test]
fn an_xml_declaration_need_not_be_first() {
    let text = pair("revolute", LIMIT);
    for before in ["\n", "<!-- by an exporter -->\n", " "] {
        let declared = format!("{before}<?xml version=\"1.0\"?>\n{text}");
        assert_eq!(read(&declared).description, read(&text).description);
    }
    let wrong = pair("revolute", "\n  <limit lower=\"-1\" upper=\"up\"/>");
    let moved = refused(&format!("\n<?xml version=\"1.0\"?>{wrong}"));
    assert_eq!(moved.place.line, refused(&wrong).place.line + 1);
}

#[test]
fn a_damping_that_nothing_has_is_told() {
    let damped =
        |damping: &str| read(&pair("revolute", &format!("{LIMIT}<dynamics damping='{damping}'/>")));
    for damping in ["1e11", "inf", "1e6"] {
        let imported = damped(damping);
        assert_eq!(imported.description.joints[0].damping, 0.0);
        assert_noted(&imported, NoteKind::LeftOut, "which nothing has");
    }
    let doubtful = damped("1500");
    assert_eq!(doubtful.description.joints[0].damping, 1500.0);
    assert_noted(&doubtful, NoteKind::Doubtful, "damping = 1500: no servo");
}

#[test]
fn ranges_need_not_be_whole() {
    let open = read(&pair("revolute", r#"<limit effort="1" velocity="1"/>"#));
    assert!(open.description.joints[0].range_rad.is_empty());
    assert_noted(&open, NoteKind::Doubtful, "neither `lower` nor `upper`");
    let half = read(&pair("revolute", r#"<limit upper="2"/>"#));
    assert_eq!(half.description.joints[0].range_rad, [[0.0, 2.0]]);
    assert_noted(&half, NoteKind::Filled, "the other is 0");
    let shut = read(&pair("revolute", r#"<limit lower="1" upper="1"/>"#));
    assert_noted(&shut, NoteKind::Doubtful, "cannot move");
    let turned = pair("revolute", r#"<limit lower="2" upper="1"/>"#);
    assert_refused(&turned, "joint `j`: limit: upper", "at least `lower`, which is 2", "`1`");
    assert_noted(&read(&pair("revolute", "")), NoteKind::Doubtful, "no `limit`");
    let of = |lower: &str, upper: &str| {
        read(&pair(
            "revolute",
            &format!("<limit lower='{lower}' upper='{upper}' effort='1' velocity='1'/>"),
        ))
    };
    assert_noted(&of("-90", "90"), NoteKind::Doubtful, "are these degrees?");
    // Two turns, which industrial arms have.
    let turns = of("-6.28319", "6.28319");
    assert!(turns.notes.iter().all(|note| !note.text.contains("degrees")), "{:?}", turns.notes);
}

#[test]
fn a_mimic_joint_is_tied_by_a_limit_without_room() {
    let tied = |kind: &str, of: &str| {
        let c = link("c");
        let other = format!(
            r#"<joint name="k" type="{kind}"><parent link="a"/><child link="c"/>{LIMIT}
            <mimic joint="{of}" multiplier="-0.5" offset="0.1"/></joint>"#
        );
        robot(&(link("a") + &link("b") + &c + &joint("revolute", LIMIT) + &other))
    };
    let imported = read(&tied("revolute", "j"));
    let [limit] = imported.description.limits.as_slice() else { panic!("one limit") };
    assert_eq!((limit.joint.as_str(), limit.other.as_str()), ("k", "j"));
    assert_eq!((limit.factor, limit.other_factor), (1.0, 0.5));
    assert_eq!((limit.least_rad, limit.most_rad), (Some(0.1), Some(0.1)));
    assert_noted(&imported, NoteKind::Changed, "k = -0.5 j + 0.1");
    // A slide follows a hinge: the factor is in m/rad.
    let mixed = read(&tied("prismatic", "j"));
    let [limit] = mixed.description.limits.as_slice() else { panic!("one limit") };
    assert_eq!((limit.other_factor, limit.least_rad, limit.least_m), (0.5, None, Some(0.1)));
    assert_refused(&tied("revolute", "k"), "joint `k`: mimic: joint", "another joint", "`k`");
    assert_refused(&tied("revolute", "x"), "joint `k`: mimic: joint", "a joint of the file", "`x`");
    let ball = read(&tied("spherical", "j"));
    assert!(ball.description.limits.is_empty());
    assert_noted(&ball, NoteKind::LeftOut, "joints of one dof");
}

#[test]
fn inertia_is_turned_into_body_axes() {
    let inertial = r#"<inertial><origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/><mass value="2"/>
        <inertia ixx="1" iyy="2" izz="2.5" ixy="0" ixz="0.1" iyz="0"/></inertial>"#;
    let body = &read(&moved(inertial)).description.bodies[1];
    assert_eq!((body.mass_kg, body.center_of_mass_m), (2.0, [1.0, 2.0, 3.0]));
    let InertiaMatrix { xx, xy, xz, yy, yz, zz } = body.inertia_kg_m2.expect("an inertia");
    assert!(close(&[xx, yy, zz, xy, xz, yz], &[2.0, 1.0, 2.5, 0.0, 0.0, 0.1]));
}

#[test]
fn a_link_without_inertial_is_a_frame() {
    let imported = read(&moved(""));
    let frame = &imported.description.bodies[1];
    assert_eq!((frame.mass_kg, frame.inertia_kg_m2), (0.0, None));
    assert_noted(&imported, NoteKind::Changed, "a frame without mass (`b`)");
    assert_noted(&imported, NoteKind::Doubtful, "moves, but has no mass in the file");
    // Welded to a heavy link, its missing mass does not matter.
    let welded = robot(&(link("a") + r#"<link name="b"/>"# + &joint("fixed", "")));
    let notes = read(&welded).notes;
    assert!(notes.iter().all(|note| !note.text.contains("moves, but has no mass")));
}

#[test]
fn missing_inertia_is_filled_from_solids() {
    let mass = r#"<inertial><mass value="12"/></inertial>"#;
    let cases = [
        (r#"<box size="1 2 3"/>"#, [13.0, 10.0, 5.0]),
        (r#"<sphere radius="0.5"/>"#, [1.2, 1.2, 1.2]),
        (r#"<cylinder radius="1" length="2"/>"#, [7.0, 7.0, 6.0]),
    ];
    for (solid, [x, y, z]) in cases {
        let shape = format!(
            r#"{mass}<collision><origin xyz="0 0 1"/><geometry>{solid}</geometry></collision>"#
        );
        let imported = read(&moved(&shape));
        let body = &imported.description.bodies[1];
        let InertiaMatrix { xx, yy, zz, .. } = body.inertia_kg_m2.expect("an inertia");
        assert!(close(&[xx, yy, zz], &[x, y, z]), "{solid}: {xx} {yy} {zz}");
        assert_eq!((body.mass_kg, body.center_of_mass_m), (12.0, [0.0, 0.0, 1.0]));
        assert_noted(&imported, NoteKind::Filled, "collision solids");
    }
    // Two balls of half the mass each, 2 m apart.
    let ball = |x| {
        format!(
            r#"<visual><origin xyz="{x} 0 0"/><geometry><sphere radius="0.5"/></geometry></visual>"#
        )
    };
    let body = &read(&moved(&(mass.to_owned() + &ball(-1) + &ball(1)))).description.bodies[1];
    let InertiaMatrix { xx, yy, zz, .. } = body.inertia_kg_m2.expect("an inertia");
    assert!(close(&[xx, yy, zz], &[1.2, 13.2, 13.2]));
}

#[test]
fn a_capsule_is_a_cylinder_and_two_half_balls() {
    let inertia_of = |length: f64| {
        let inside = format!(
            r#"<inertial><mass value="1"/></inertial><collision><geometry>
            <capsule radius="1" length="{length}"/></geometry></collision>"#
        );
        read(&moved(&inside)).description.bodies[1].inertia_kg_m2.expect("an inertia")
    };
    // A capsule without length is a ball; a long capsule is a rod: l² / 12.
    assert!(close(&[inertia_of(0.0).xx, inertia_of(0.0).zz], &[0.4, 0.4]));
    let rod = inertia_of(1e3).xx / (1e6 / 12.0);
    assert!((rod - 1.0).abs() < 1e-2, "{rod}: the ends add r/l of it");
}

#[test]
fn meshes_do_not_fill_inertia() {
    let inside = r#"<inertial><origin xyz="0 0 1"/><mass value="1"/></inertial>
        <visual><geometry><mesh filename="package://r/b.stl"/></geometry></visual>"#;
    assert_refused(&moved(inside), "link `b`: inertial", "meshes are not read", "neither");
    let options = Options { repair_inertia: true, ..Options::default() };
    let imported = urdf(&moved(inside), &options).expect("a rig");
    let body = &imported.description.bodies[1];
    assert_eq!((body.inertia_kg_m2, body.center_of_mass_m), (None, [0.0, 0.0, 1.0]));
    assert_noted(&imported, NoteKind::Filled, "that of a point (`b`)");
    assert_noted(&imported, NoteKind::LeftOut, "not read: 1 files, such as `b.stl`");
}

#[test]
fn impossible_inertia_is_refused_or_balanced() {
    let inside = |mass: &str, [x, y, z]: [f64; 3]| {
        format!(
            r#"<inertial><mass value="{mass}"/>
            <inertia ixx="{x}" iyy="{y}" izz="{z}" ixy="0" ixz="0" iyz="0"/></inertial>"#
        )
    };
    let flat = inside("1", [1.0, 1.0, 4.0]);
    assert_refused(
        &moved(&flat),
        "link `b`: inertial: inertia",
        "repair-inertia",
        "a principal moment",
    );
    assert_refused(
        &moved(&inside("1", [-1.0, 1.0, 1.0])),
        "link `b`: inertial: inertia",
        "",
        "a negative moment",
    );
    assert_refused(
        &moved(&inside("0", [1.0, 1.0, 1.0])),
        "link `b`: inertial: inertia",
        "",
        "inertia without mass",
    );
    assert_refused(
        &moved(&inside("-1", [1.0; 3])),
        "link `b`: inertial: mass: value",
        "zero or more",
        "`-1`",
    );
    let options = Options { repair_inertia: true, ..Options::default() };
    let imported = urdf(&moved(&flat), &options).expect("a rig");
    let inertia = imported.description.bodies[1].inertia_kg_m2.expect("an inertia");
    assert_eq!((inertia.xx, inertia.yy, inertia.zz, inertia.xy), (2.0, 2.0, 2.0, 0.0));
    assert_noted(&imported, NoteKind::Changed, "the inertia of a ball");
    // The file itself asks for the repair.
    let own = moved(&flat)
        .replace("</robot>", r#"<mujoco><compiler balanceinertia="true"/></mujoco></robot>"#);
    assert_eq!(read(&own).description.bodies[1].inertia_kg_m2, Some(inertia));
    // All bodies with an error are reported at once.
    let both = robot(
        &(format!(r#"<link name="a">{flat}</link><link name="b">{flat}</link>"#)
            + &joint("fixed", "")),
    );
    assert_refused(&both, "link `a`: inertial: inertia", "", "also refused: `b`");
}

#[test]
fn a_mass_for_programs_that_choke_on_none_is_told() {
    let inside = r#"<inertial><mass value="1e-9"/>
        <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial>"#;
    assert_noted(&read(&moved(inside)), NoteKind::Doubtful, "weighs 1e-9 kg");
}

#[test]
fn z_is_turned_up_once() {
    let imported = read(&pair("revolute", LIMIT));
    let half = std::f64::consts::FRAC_1_SQRT_2;
    assert!(close(&imported.description.mount.rotation_xyzw, &[-half, 0.0, 0.0, half]));
    assert_noted(&imported, NoteKind::Changed, "z is up");
}

#[test]
fn a_floating_base_stands() {
    let world = r#"<link name="a"/>"#;
    let text =
        robot(&(world.to_owned() + &link("b") + &joint("floating", r#"<origin xyz="1 2 3"/>"#)));
    let imported = read(&text);
    let [body] = imported.description.bodies.as_slice() else { panic!("one body") };
    assert_eq!((body.name.as_str(), imported.description.joints.len()), ("b", 0));
    // 3 m up is y; 2 m to the file's left is -z.
    assert!(close(&imported.description.mount.position_m, &[1.0, 3.0, -2.0]));
    assert_noted(&imported, NoteKind::Changed, "mount.base = \"driven\"");
}

#[test]
fn links_are_a_tree() {
    let roots = robot(&(link("a") + &link("b")));
    assert_refused(&roots, "robot `r`", "one link that no joint moves", "2: `a`, `b`");
    let circle = robot(
        &(link("a")
            + &link("b")
            + &joint("fixed", "")
            + r#"<joint name="k" type="fixed"><parent link="b"/><child link="a"/></joint>"#),
    );
    assert_refused(&circle, "robot `r`", "that no joint moves", "a closed loop");
    let apart = circle.replace("</robot>", r#"<link name="c"/></robot>"#);
    assert_refused(&apart, "robot `r`", "connected to the root", "a closed loop");
    let twice = pair("revolute", LIMIT).replace(
        "</robot>",
        r#"<link name="c"/><joint name="l" type="fixed"><parent link="a"/><child link="c"/></joint>
        <joint name="k" type="fixed"><parent link="c"/><child link="b"/></joint></robot>"#,
    );
    assert_refused(
        &twice,
        "joint `k`",
        "one joint that moves the link `b`",
        "`j` and `k`: a closed loop",
    );
    let cut = |name: &str| Options { cut: vec![name.to_owned()], ..Options::default() };
    let imported = urdf(&twice, &cut("k")).expect("a tree");
    assert_eq!(imported.description.joints.len(), 2);
    assert_noted(&imported, NoteKind::LeftOut, "by the user's word (`k`)");
    let error = urdf(&twice, &cut("nobody")).expect_err("refused");
    assert_eq!(error.found, "`nobody`");
    let imported = urdf(&pair("revolute", LIMIT), &cut("j")).expect("a rig of one body");
    assert_eq!(imported.description.bodies.len(), 1);
    assert_noted(&imported, NoteKind::LeftOut, "not connected without the joints left out (`b`)");
}

#[test]
fn joints_come_from_the_base_outwards() {
    let text = r#"<robot name="r"><link name="c"/><link name="b"/><link name="a"/><link name="d"/>
        <joint name="3" type="fixed"><parent link="b"/><child link="c"/></joint>
        <joint name="2" type="fixed"><parent link="a"/><child link="b"/></joint>
        <joint name="1" type="fixed"><parent link="a"/><child link="d"/></joint></robot>"#;
    let description = read(text).description;
    let bodies: Vec<&str> = description.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(bodies, ["a", "b", "c", "d"]);
    let joints: Vec<&str> = description.joints.iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(joints, ["2", "3", "1"]);
}

#[test]
fn names_are_there_and_unique() {
    assert_refused(&robot(r#"<link name=""/>"#), "robot `r`: link: name", "with a value", "``");
    assert_refused(&robot("<link/>"), "robot `r`: link: name", "with a value", "none");
    assert_refused(&robot(&(link("a") + &link("a"))), "link `a`: name", "no other link", "`a`");
    let ghost = robot(&(link("a") + &joint("fixed", "")));
    assert_refused(&ghost, "joint `j`: child: link", "a link of the file", "`b`");
    assert_refused(&robot(""), "robot `r`", "a link", "none");
}

#[test]
fn other_files_are_told_apart() {
    let mjcf = refused("<mujoco/>");
    assert!(mjcf.expected.contains("`robot`") && mjcf.found.contains("mujoco"), "{mjcf}");
    assert!(refused("<robot>").expected.contains("well-formed XML"));
    for text in [
        r#"<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:if value="1"/></robot>"#,
        r#"<robot><xacro:if value="1"/></robot>"#,
        r#"<robot><link name="a"><inertial><mass value="${m}"/></inertial></link></robot>"#,
        r#"<robot><link name="$(arg n)"/></robot>"#,
    ] {
        assert!(refused(text).expected.contains("xacro FILE"), "{}", refused(text));
    }
    let prefix = refused(r#"<robot><sensor:camera name="x"/></robot>"#);
    assert!(prefix.expected.contains("xmlns:sensor"), "{prefix}");
}

#[test]
fn a_name_space_and_comments_are_no_hindrance() {
    let text = pair("revolute", LIMIT).replace(
        "<robot",
        r#"<?xml version="1.0"?><!-- by hand --><robot xmlns="http://www.ros.org" xmlns:x="urn:x" x:version="1""#,
    );
    assert_eq!(read(&text).description.bodies.len(), 2);
}

#[test]
fn what_says_nothing_is_counted() {
    let text = pair("revolute", r#"<safety_controller k_velocity="1"/><calibration rising="0"/>"#)
        .replace("</robot>", "<gazebo/><gazebo/></robot>");
    let imported = read(&text);
    assert_noted(&imported, NoteKind::LeftOut, "`gazebo: 2`");
    assert_noted(&imported, NoteKind::LeftOut, "`safety_controller of a joint: 1`");
    let driven = pair("revolute", LIMIT)
        .replace("</robot>", r#"<transmission><joint name="other"/></transmission></robot>"#);
    assert_noted(&read(&driven), NoteKind::Doubtful, "transmissions do not drive it");
}

#[test]
fn loops_that_were_cut_open_are_refused_unless_the_user_says_so() {
    let frame = |n: u8, on: &str| {
        format!(
            r#"<link name="closing_x_{n}"/><joint name="f{n}" type="fixed">
            <parent link="{on}"/><child link="closing_x_{n}"/></joint>"#
        )
    };
    let text = pair("revolute", LIMIT).replace("\"j\"", "\"passive_j\"");
    let open = text.replace("</robot>", &(frame(1, "a") + "</robot>"));
    assert_noted(&read(&open), NoteKind::Doubtful, "no drive, by its name");
    let shut = open.replace("</robot>", &(frame(2, "b") + "</robot>"));
    assert_refused(&shut, "robot `r`", "open-loops", "`a` meets `b` at closing_x");
    assert!(refused(&shut).found.contains("`passive_j`"));
    let options = Options { open_loops: true, ..Options::default() };
    assert_noted(&urdf(&shut, &options).expect("a tree"), NoteKind::Doubtful, "loops stay open");
}

#[test]
fn a_chain_of_thousands_takes_no_stack_and_no_time() {
    let moved = |i: usize| {
        let parent = i - 1;
        format!(
            r#"<link name="l{i}"/><joint name="j{i}" type="fixed">
            <parent link="l{parent}"/><child link="l{i}"/></joint>"#
        )
    };
    let chain: String = (1..20_000).map(moved).collect();
    let text = robot(&format!("<link name=\"l0\"/>{chain}"));
    assert_eq!(read(&text).description.bodies.len(), 20_000);
}

#[test]
fn lengths_are_in_the_unit_that_is_told() {
    let text = robot(
        &(link("a")
            + &link("b")
            + r#"<joint name="j" type="prismatic"><parent link="a"/><child link="b"/><origin xyz="0 0 300"/>
               <axis xyz="0 0 1"/><limit lower="0" upper="40" effort="3" velocity="20"/></joint>"#),
    );
    let options = Options { metres_per_unit: Some(0.001), ..Options::default() };
    let imported = urdf(&text, &options).unwrap();
    let joint = &imported.description.joints[0];
    assert!(close(&joint.position_m, &[0.0, 0.0, 0.3]));
    assert!(close(&joint.range_m.unwrap(), &[0.0, 0.04]));
    assert!(close(&[joint.speed_m_s.unwrap()], &[0.02]));
    assert_eq!(joint.effort, Some(3.0));
    let body = &imported.description.bodies[1];
    assert!(close(&[body.mass_kg, body.inertia_kg_m2.unwrap().xx], &[1.0, 1e-6]));
    assert_noted(&imported, NoteKind::Changed, "lengths by 0.001");
}

#[test]
fn a_tie_of_a_slide_and_a_hinge_is_in_the_unit_that_is_told() {
    let joint = |name: &str, kind: &str, end: f64, mimic: &str| {
        let child = if name == "way" { "b" } else { "c" };
        format!(
            r#"<joint name="{name}" type="{kind}"><parent link="a"/><child link="{child}"/><axis xyz="0 0 1"/>
            <limit lower="0" upper="{end}" effort="3" velocity="20"/>{mimic}</joint>"#
        )
    };
    let of = |on_way: &str, on_turn: &str| {
        let joints =
            joint("way", "prismatic", 40.0, on_way) + &joint("turn", "revolute", 2.0, on_turn);
        let text = robot(&(link("a") + &link("b") + &link("c") + &joints));
        let options = Options { metres_per_unit: Some(0.001), ..Options::default() };
        let rig = urdf(&text, &options).unwrap().description;
        let [limit] = rig.limits.as_slice() else { panic!("one limit") };
        limit.other_factor
    };
    // The relation is 20 mm per rad in both directions.
    let by_turn = of(r#"<mimic joint="turn" multiplier="20"/>"#, "");
    assert!((by_turn + 0.02).abs() < 1e-12, "{by_turn} m/rad");
    let by_way = of("", r#"<mimic joint="way" multiplier="0.05"/>"#);
    assert!((by_way + 50.0).abs() < 1e-9, "{by_way} rad/m");
}

#[test]
fn the_axis_that_is_told_points_up() {
    for axis in glam::DVec3::AXES {
        let options = Options { up: Some(axis), ..Options::default() };
        let rig = urdf(&pair("revolute", LIMIT), &options).unwrap().description;
        let up = glam::DQuat::from_array(rig.mount.rotation_xyzw) * axis;
        assert!(close(&up.to_array(), &[0.0, 1.0, 0.0]), "{axis}: {up}");
    }
}
