//! `sinew clip weights` as a command: its output, pictures and exit codes.

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::{Value, json};

use crate::common::{command, sinew_in, text};

const RIG: &str = r#"<robot name="arm"><link name="base"/><link name="upper"/><link name="lower"/>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.3"/></joint>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0.2 0 0"/></joint></robot>"#;

fn weights(folder: &Path, more: &[&str]) -> Output {
    fs::write(folder.join("arm.urdf"), RIG).expect("a folder to write to");
    sinew_in(folder, &[&["clip", "weights", "arm.urdf"], more].concat())
}

#[test]
fn a_rig_is_weighed_by_all_that_it_has() {
    let folder = tempfile::tempdir().expect("a folder");
    let output =
        weights(folder.path(), &["--format", "json", "--base", "0.1", "--discount", "0.5"]);
    let said = text(&output.stderr);
    assert!(
        said.starts_with("note: arm: ") && said.contains("y is up (as its format says)"),
        "{said}"
    );
    assert!(said.ends_with("\nmethod mesh is left out: the file has a skeleton only\n"), "{said}");
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let methods = json["methods"].as_object().expect("methods");
    assert_eq!(methods.keys().collect::<Vec<_>>(), ["cylinders", "lengths"]);
    // 0.1, 0.1 + 0.5 (0.2 + 0.1), 0.1 + 0.5 (0.3 + 0.25), divided by their sum.
    for (joint, (name, raw)) in
        [("base", 0.375), ("shoulder", 0.25), ("elbow", 0.1)].into_iter().enumerate()
    {
        assert_eq!(methods["lengths"][joint]["joint"], name);
        let found = methods["lengths"][joint]["weight"].as_f64().expect("a number");
        assert!((found - raw / 0.725).abs() < 1e-6, "{name}: {found}");
    }
}

/// A triangle without area, in a glTF with one joint.
#[test]
fn a_mesh_without_surface_is_left_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let floats = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0];
    let weights = [1.0_f32, 0.0, 0.0, 0.0].repeat(3);
    let bytes = floats.iter().chain(&weights).flat_map(|number| number.to_le_bytes());
    fs::write(folder.path().join("flat.bin"), bytes.chain([0; 12]).collect::<Vec<u8>>())
        .expect("a file");
    let file = json!({
        "asset": { "version": "2.0" },
        "nodes": [{ "name": "hips" }, { "mesh": 0, "skin": 0 }],
        "skins": [{ "joints": [0] }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "WEIGHTS_0": 1, "JOINTS_0": 2 } }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
              "min": [0.0, 0.0, 0.0], "max": [2.0, 0.0, 0.0] },
            { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC4" },
            { "bufferView": 2, "componentType": 5121, "count": 3, "type": "VEC4" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 84, "byteLength": 12 },
        ],
        "buffers": [{ "byteLength": 96, "uri": "flat.bin" }],
    });
    fs::write(folder.path().join("flat.gltf"), file.to_string()).expect("a file");
    let weights = |method: &str| {
        let mut command = command();
        command.current_dir(folder.path()).args([
            "clip",
            "weights",
            "flat.gltf",
            "--method",
            method,
        ]);
        command.output().expect("the command runs")
    };
    let all = weights("all");
    assert!(all.status.success(), "{}", text(&all.stderr));
    let said = text(&all.stderr);
    assert!(
        said.ends_with("\nmethod mesh is left out: the file's mesh has no surface\n"),
        "{said}"
    );
    assert!(!text(&all.stdout).contains("mesh"), "{}", text(&all.stdout));
    let mesh = weights("mesh");
    assert_eq!(mesh.status.code(), Some(2));
    let told = "method mesh: expected a mesh with a surface, found 1 triangles without area";
    assert!(text(&mesh.stderr).contains(told), "{}", text(&mesh.stderr));
}

#[test]
fn pictures_are_drawn_and_radii_come_from_its_own_table() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["arm.svg", "arm.png"] {
        let output = weights(folder.path(), &["--picture", name, "--method", "lengths"]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert_eq!(text(&output.stderr).lines().count(), 1, "its size alone");
        assert!(fs::metadata(folder.path().join(name)).expect("a picture").len() > 1000);
    }
    let first = weights(folder.path(), &["--format", "csv", "--method", "cylinders"]);
    fs::write(folder.path().join("radii.csv"), &first.stdout).expect("a file");
    let again = weights(
        folder.path(),
        &["--format", "csv", "--method", "cylinders", "--radii", "radii.csv"],
    );
    assert_eq!(text(&first.stdout), text(&again.stdout));
    assert!(
        text(&first.stdout).starts_with("joint,parent,length_m,radius_m,cylinders\nbase,,0,0,")
    );
}

#[test]
fn what_cannot_be_done_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    for (arguments, told) in [
        (
            &["--method", "mesh"][..],
            "error: arm.urdf: method mesh: expected a character with a skinned mesh",
        ),
        (&["--base", "-1"], "error: arm.urdf: base: expected a number from 0 to 1e15, found -1.0"),
        (
            &["--base", "1e60"],
            "error: arm.urdf: base: expected a number from 0 to 1e15, found 1e60",
        ),
        (
            &["--radii", "1e30"],
            "error: arm.urdf: radii: expected metres from 0 to 100000, found 1e30",
        ),
        (&["--discount", "nan"], "error: arm.urdf: discount: expected a number from 0 to 1"),
        (
            &["--radii", "-0.1"],
            "error: arm.urdf: radii: expected metres from 0 to 100000, found -0.1",
        ),
        (&["--radii", "no.csv"], "error: no.csv: expected a CSV of radii"),
        (
            &["--picture", "a.jpg"],
            "error: --picture a.jpg: expected a picture named *.svg or *.png",
        ),
        (&["--frame", "3"], "error: arm.urdf: --frame: expected a motion, or this option left out"),
        (&["--up", "w"], "expected x, y or z"),
        (
            &["--method", "lengths", "--radii", "0.1"],
            "error: --radii: expected only with the method cylinders",
        ),
        (
            &["--vertex-area", "article"],
            "error: --vertex-area article: expected only with the method mesh",
        ),
        (&["--metres-per-unit", "0"], "expected a length in m from 1e-6 to 1000"),
    ] {
        let output = weights(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(text(&output.stderr).contains(told), "{}", text(&output.stderr));
        assert!(output.stdout.is_empty(), "{arguments:?}");
    }
}
