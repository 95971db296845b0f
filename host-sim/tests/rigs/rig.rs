//! `sinew rig` as a command.

use std::io::Write as _;
use std::path::Path;
use std::process::{Output, Stdio};

use crate::common::command;

/// Two links that nod and lift: a hinge about y, a slide along z.
const URDF: &str = r#"<robot name="lamp">
  <link name="stand"/>
  <link name="arm">
    <inertial>
      <origin xyz="0.1 0 0"/><mass value="2"/>
      <inertia ixx="0.001" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <link name="lift">
    <inertial><mass value="0.5"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="nod" type="revolute">
    <parent link="stand"/><child link="arm"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="3" velocity="4"/>
  </joint>
  <joint name="rise" type="prismatic">
    <parent link="arm"/><child link="lift"/><origin xyz="0.2 0 0"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="0.1" effort="10" velocity="0.2"/>
  </joint>
</robot>"#;

fn sinew(folder: &Path, args: &[&str], input: &str) -> Output {
    let mut child = command()
        .arg("rig")
        .args(args)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A command that refuses its arguments does not read its input.
    let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
    child.wait_with_output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

/// Returns the messages of a command: its standard error.
fn text_of(output: &Output) -> &str {
    text(&output.stderr)
}

#[track_caller]
fn assert_done(output: &Output) {
    assert!(output.status.success(), "{}", text(&output.stderr));
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lamp.urdf"), URDF).unwrap();
    folder
}

#[test]
fn from_a_urdf_to_the_page() {
    let folder = folder();
    let at = folder.path();
    let imported = sinew(at, &["import", "lamp.urdf", "-o", "rig.toml"], "");
    assert_done(&imported);
    assert!(text(&imported.stderr).contains("mount.rotation_xyzw"), "what was turned is said");
    // The file may contain edits, so it is not overwritten.
    let again = sinew(at, &["import", "lamp.urdf", "-o", "rig.toml"], "");
    assert_eq!(again.status.code(), Some(2));
    assert!(text(&again.stderr).contains("--force"));

    let checked = sinew(at, &["check", "rig.toml", "--format", "json"], "");
    assert_done(&checked);
    let review: serde_json::Value = serde_json::from_slice(&checked.stdout).unwrap();
    // 2 kg at 0.1 m and 0.5 kg at up to 0.2 m by 0.1 m above: in the worst pose the common centre of mass is level
    // with the hinge.
    let worst = 9.81 * f64::hypot(2.0 * 0.1 + 0.5 * 0.2, 0.5 * 0.1);
    let found = review["by_freedom"][0]["gravity_effort"].as_f64().unwrap();
    assert!((found - worst).abs() < 1e-9, "{found} {worst}");
    assert_eq!(review["by_freedom"][1]["name"], "rise");

    assert_done(&sinew(at, &["view", "rig.toml", "-o", "rig.html"], ""));
    let page = std::fs::read_to_string(at.join("rig.html")).unwrap();
    assert!(page.contains("\"name\":\"rise\"") && page.contains("id=\"stage\""));
    assert!(!page.contains("http://") && !page.contains("https://"), "nothing is fetched");
}

/// A file with inertia in g mm² instead of kg m²: the check names the body and the option, and the option corrects
/// it.
#[test]
fn inertia_in_g_mm2_is_found_and_read_as_that() {
    let folder = folder();
    let at = folder.path();
    // The inertia of the lift, 0.5 kg: 1e-4 kg m² as a CAD program prints it.
    let printed = URDF.replace("1e-4", "1e5");
    assert_ne!(printed, URDF);
    std::fs::write(at.join("cad.urdf"), printed).unwrap();

    let checked = sinew(at, &["check", "cad.urdf"], "");
    assert!(text(&checked.stdout).contains("--inertia-g-mm2 lift"), "{}", text(&checked.stdout));

    assert_done(&sinew(
        at,
        &["import", "cad.urdf", "--inertia-g-mm2", "lift", "-o", "cad.toml"],
        "",
    ));
    let checked = sinew(at, &["check", "cad.toml"], "");
    assert!(!text(&checked.stdout).contains("g mm²"), "{}", text(&checked.stdout));
    let torques = |rig| {
        sinew(at, &["dynamics", rig], "q.nod,q.rise,qd.nod,qd.rise,qdd.nod,qdd.rise\n0,0,0,0,1,0\n")
    };
    let (cad, lamp) = (torques("cad.toml"), torques("lamp.urdf"));
    assert_done(&cad);
    assert_eq!(text(&cad.stdout), text(&lamp.stdout));

    let refused = sinew(at, &["import", "cad.urdf", "--inertia-g-mm2", "leg"], "");
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("no body of that name"), "{}", text(&refused.stderr));
}

#[test]
fn torques_come_out_in_columns_of_any_order() {
    let folder = folder();
    let header = sinew(folder.path(), &["dynamics", "lamp.urdf", "--header"], "");
    assert_eq!(text(&header.stdout), "nod,rise\n");
    // Horizontal and at rest: 2 kg at 0.1 m and 0.5 kg at 0.2 m about -y of the file; the slide carries 0.5 kg.
    let rows = "qdd.rise,q.rise,qd.nod,q.nod,qd.rise,qdd.nod\n0,0,0,0,0,0\n";
    let output = sinew(folder.path(), &["dynamics", "lamp.urdf"], rows);
    assert_done(&output);
    let mut lines = text(&output.stdout).lines();
    assert_eq!(lines.next(), Some("tau.nod,tau.rise"));
    let numbers: Vec<f64> =
        lines.next().unwrap().split(',').map(|number| number.parse().unwrap()).collect();
    for (found, expected) in numbers.iter().zip([-9.81 * 0.3, 9.81 * 0.5]) {
        // The core computes in f32.
        assert!((found - expected).abs() < 1e-6 * 9.81, "{numbers:?}");
    }
    assert_eq!(lines.next(), None);
}

#[test]
fn what_cannot_be_is_refused_by_line_and_name() {
    let folder = folder();
    for (args, input, words) in [
        (&["dynamics", "lamp.urdf"][..], "q.nod\n0\n", "the column `q.rise` is missing"),
        (&["dynamics", "lamp.urdf"], "q.nod,q.rise,q.x\n0,0,0\n", "column `q.x`: expected"),
        (
            &["dynamics", "lamp.urdf"],
            "q.nod,q.rise\n0,nan\n",
            "line 2, column `q.rise`: expected a number",
        ),
        (&["dynamics", "lamp.urdf"], "q.nod,q.nod\n0,0\n", "column `q.nod` occurs twice"),
        (&["check", "none.toml"], "", "none.toml"),
        (&["check", "lamp.urdf", "--rate-hz", "nan"], "", "expected a number from 1 to 100000"),
        (&["new"], "", "--arm"),
        (&["new", "--arm", "41"], "", "1..=40"),
    ] {
        let output = sinew(folder.path(), args, input);
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        assert!(text(&output.stderr).contains(words), "{args:?}: {}", text(&output.stderr));
    }
}

#[test]
fn rigs_to_start_from_pass_their_check() {
    let folder = folder();
    // Servos with their own control loops have no margins.
    for (args, name, has_margins) in
        [(&["new", "--arm", "6"][..], "arm.toml", true), (&["new", "--face"], "face.toml", false)]
    {
        let args = [args, &["-o", name]].concat();
        assert_done(&sinew(folder.path(), &args, ""));
        let checked = sinew(folder.path(), &["check", name], "");
        assert_done(&checked);
        let said = text(&checked.stdout);
        assert_eq!(said.contains("Loops by current"), has_margins, "{said}");
        assert!(!said.contains("shakes  "), "{said}");
    }
    let shakes = [
        "check",
        "arm.toml",
        "--bandwidth-rad-s",
        "400",
        "--latency-ticks",
        "4",
        "--format",
        "json",
    ];
    let checked = sinew(folder.path(), &shakes, "");
    assert_eq!(checked.status.code(), Some(1), "{}", text(&checked.stdout));
    assert!(text(&checked.stdout).contains("by current it shakes"), "{}", text(&checked.stdout));
}

/// A name that would be markup if it were not escaped.
#[test]
fn names_are_no_markup() {
    let folder = folder();
    let named = URDF
        .replace("name=\"lamp\"", "name=\"a&lt;/script>&lt;b>\"")
        .replace("\"rise\"", "\"r&lt;/script>\"");
    std::fs::write(folder.path().join("odd.urdf"), named).unwrap();
    assert_done(&sinew(folder.path(), &["view", "odd.urdf", "-o", "odd.html"], ""));
    let page = std::fs::read_to_string(folder.path().join("odd.html")).unwrap();
    assert_eq!(page.matches("</script>").count(), 2, "the data's and the script's own");
}

#[test]
fn a_rig_in_millimetres_is_refused_until_its_unit_is_told() {
    let folder = folder();
    let mm = URDF
        .replace("xyz=\"0.2 0 0\"", "xyz=\"200 0 0\"")
        .replace("xyz=\"0.1 0 0\"", "xyz=\"100 0 0\"")
        .replace(
            "upper=\"0.1\" effort=\"10\" velocity=\"0.2\"",
            "upper=\"100\" effort=\"10\" velocity=\"200\"",
        );
    std::fs::write(folder.path().join("mm.urdf"), mm).unwrap();
    let refused = sinew(folder.path(), &["check", "mm.urdf"], "");
    let said = text_of(&refused);
    assert_eq!(refused.status.code(), Some(2), "{said}");
    assert!(said.contains("found 200.0000 m from end to end"), "{said}");
    assert!(said.contains("--metres-per-unit 0.001"), "{said}");
    let told = ["import", "mm.urdf", "--metres-per-unit", "0.001", "--up", "y"];
    let done = sinew(folder.path(), &told, "");
    assert_done(&done);
    let said = text_of(&done);
    assert!(said.contains("0.200 m across; a unit is 0.001 m (as you specified)"), "{said}");
    assert!(said.contains("y is up (as you specified)"), "{said}");
    let rig = text(&done.stdout);
    assert!(rig.contains("position_m = [0.2, 0, 0]") && rig.contains("speed_m_s = 0.2"), "{rig}");

    std::fs::write(folder.path().join("rig.toml"), rig).unwrap();
    let refused = sinew(folder.path(), &["check", "rig.toml", "--up", "z"], "");
    assert!(text_of(&refused).contains("a rig.toml is in metres"), "{}", text_of(&refused));
}
