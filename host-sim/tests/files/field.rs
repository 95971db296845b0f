//! Inputs as makers and users write them (`field/`), each with its command and the right result.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{sinew_in, text};

/// Creates a temporary folder with a copy of each of these files.
pub(crate) fn folder_with(names: &[&str]) -> tempfile::TempDir {
    let field: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/field");
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in names {
        fs::copy(field.join(name), folder.path().join(name)).expect("a copy");
    }
    folder
}

/// Runs a command that must succeed, and returns its standard error.
#[track_caller]
pub(crate) fn done(folder: &Path, words: &[&str]) -> String {
    let output = sinew_in(folder, words);
    let said = text(&output.stderr);
    assert!(output.status.success(), "{words:?}: {said}");
    said
}

/// Returns the columns' names without units, and the numbers in rad and m, of a table.
pub(crate) fn table(path: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = fs::read_to_string(path).expect("a table");
    let mut lines = text.lines();
    let column = |name: &str| {
        let units = [("_deg", 1_f64.to_radians()), ("_mm", 1e-3)];
        let of_unit = |(unit, factor)| Some((name.strip_suffix(unit)?.to_owned(), factor));
        units.into_iter().find_map(of_unit).unwrap_or((name.to_owned(), 1.0))
    };
    let (header, factors): (Vec<_>, Vec<f64>) =
        lines.next().expect("a header").split(',').map(column).unzip();
    let number = |(field, factor): (&str, &f64)| factor * field.parse::<f64>().expect("a number");
    let row = |line: &str| line.split(',').zip(&factors).map(number).collect();
    (header, lines.map(row).collect())
}

#[test]
fn a_turn_past_half_a_turn_is_followed() {
    let folder = folder_with(&["turn_past_180.bvh", "turn_past_180.map.toml", "lever.toml"]);
    let folder = folder.path();
    done(
        folder,
        &[
            "clip",
            "export",
            "turn_past_180.bvh",
            "--rig",
            "lever.toml",
            "--mapping",
            "turn_past_180.map.toml",
            "--metres-per-unit",
            "0.01",
            "-o",
            "o.csv",
        ],
    );
    let (header, rows) = table(&folder.join("o.csv"));
    let lever = header.iter().position(|name| name == "lever").expect("the lever");
    for (k, row) in rows.iter().enumerate() {
        let clip_deg = 150.0 + 0.5 * k as f64;
        let expected = (-60.0 + 120.0 * (clip_deg - 100.0) / 140.0).to_radians();
        assert!((row[lever] - expected).abs() < 1e-4, "{k}: {} {expected}", row[lever]);
    }
}

#[test]
fn an_angle_that_jumps_by_more_than_half_a_turn_is_told() {
    let folder = folder_with(&["lever.toml"]);
    let folder = folder.path();
    let wrapped = "time,dial_rad\n0,3.0\n0.02,3.1\n0.04,-3.1\n0.06,-3.0\n";
    fs::write(folder.join("wrapped.csv"), wrapped).expect("a table");
    let export = ["clip", "export", "wrapped.csv", "--rig", "lever.toml", "-o", "o.csv"];
    let said = done(folder, &export);
    assert!(said.contains("first `dial`, by -355 deg before 0.040 s"), "{said}");
}

#[test]
fn a_helper_of_no_length_is_no_hip() {
    let folder = folder_with(&["hip_helper.bvh", "hip_plain.bvh"]);
    let folder = folder.path();
    let map = |clip: &str| {
        let output = sinew_in(folder, &["clip", "map", clip]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let text = text(&output.stdout);
        text.lines().find(|line| line.starts_with("thigh_l")).expect("a thigh").to_owned()
    };
    assert_eq!(map("hip_helper.bvh"), map("hip_plain.bvh"));
    for clip in ["hip_helper.bvh", "hip_plain.bvh"] {
        done(folder, &["evaluate", "--clips", clip, "--methods", "world", "--scale", "1.0"]);
    }
}

#[test]
fn the_rate_of_a_given_mapping_is_used_and_told() {
    let folder = folder_with(&["rotational.bvh", "rate_map.toml"]);
    let evaluate =
        ["evaluate", "--clips", "rotational.bvh", "--methods", "world", "--scale", "1.0"];
    let said = done(folder.path(), &[&evaluate[..], &["--mapping", "rate_map.toml"]].concat());
    assert!(
        said.contains("taken as 120 Hz, the mapping's `rate_hz`: the file says 20.000 Hz"),
        "{said}"
    );
}

/// Returns the rig that an import writes, and its notes.
fn imported(folder: &Path, file: &str) -> (String, String) {
    let output = sinew_in(folder, &["rig", "import", file]);
    let said = text(&output.stderr);
    assert!(output.status.success(), "{file}: {said}");
    (text(&output.stdout), said)
}

#[test]
fn models_of_mujoco_are_as_strong_as_there() {
    let files = [
        ("general_motor.xml", Some("effort = 100\n"), ""),
        ("two_actuators_one_clamp.xml", Some("effort = 4\n"), ""),
        ("range_0_0.xml", None, "stands for none"),
        ("damping_1e11.xml", None, "damping = 1e11, which nothing has"),
        ("forcerange_1e9.xml", None, ""),
        ("limit_1e16.urdf", None, "the range -1e16 to 1e16 stands for none"),
    ];
    let folder = folder_with(&files.map(|(file, ..)| file));
    for (file, effort, note) in files {
        let (rig, said) = imported(folder.path(), file);
        assert!(effort.is_none_or(|effort| rig.contains(effort)), "{file}: {rig}");
        assert!(said.contains(note), "{file}: {said}");
    }
    let (rig, _) = imported(folder.path(), "forcerange_1e9.xml");
    assert!(!rig.contains("effort"), "{rig}");
}

#[test]
fn parts_of_a_model_are_read_from_its_folder_only() {
    let outer = tempfile::tempdir().expect("a temporary folder");
    let folder = outer.path().join("robot");
    fs::create_dir_all(folder.join("parts")).expect("folders");
    let body = r#"<mujoco><body name="b"><joint name="j"/><geom size="0.1"/></body></mujoco>"#;
    fs::write(folder.join("parts/arm.xml"), body).expect("a part");
    fs::write(outer.path().join("outside.xml"), body).expect("a part");
    let model = |part: &str| {
        format!(
            r#"<mujoco><worldbody><body name="a"><geom size="0.1"/><include file="{part}"/></body></worldbody></mujoco>"#
        )
    };
    fs::write(folder.join("scene.xml"), model("parts/arm.xml")).expect("a model");
    assert!(imported(&folder, "scene.xml").0.contains("name = \"j\""));
    for part in ["../outside.xml", "parts/../../outside.xml"] {
        fs::write(folder.join("scene.xml"), model(part)).expect("a model");
        let output = sinew_in(&folder, &["rig", "import", "scene.xml"]);
        let said = text(&output.stderr);
        assert!(said.contains("expected a file in the same folder or below"), "{said}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../outside.xml", folder.join("link.xml")).expect("a link");
        fs::write(folder.join("scene.xml"), model("link.xml")).expect("a model");
        let said = text(&sinew_in(&folder, &["rig", "import", "scene.xml"]).stderr);
        assert!(said.contains("is not in the folder of the file"), "{said}");
    }
}
