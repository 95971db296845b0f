//! `sinew evaluate figure` as a command: its output, and its exit codes.

use std::path::Path;
use std::process::Output;

use serde_json::Value;

use crate::common::{sinew, text};

fn figure(more: &[&str]) -> Output {
    sinew(&[&["evaluate", "figure"], more].concat())
}

fn json(more: &[&str]) -> Value {
    let output = figure(&[&["--format", "json"], more].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn a_row_for_each_body_and_the_sum() {
    let output = figure(&[]);
    let printed = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let row = |body: &str| -> Vec<&str> {
        let row = printed.lines().find(|line| line.starts_with(body));
        row.unwrap_or_else(|| panic!("no {body}: {printed}")).split_whitespace().collect()
    };
    assert_eq!(row("hand_r")[1..5], ["ellipsoid", "0.450", "0.59", "0.61"]);
    assert_eq!(row("shank_l")[1..5], ["cone", "3.677", "4.81", "4.33"]);
    assert_eq!(row("head")[1..5], ["ellipsoid", "4.864", "6.36", "6.94"]);
    assert_eq!(row("sum")[4..], ["76.483", "kg"]);
    assert_eq!(row("mass of the")[4..], ["75.000", "kg"]);
    assert!(printed.lines().all(|line| line.chars().count() <= 100), "{printed}");
}

/// Checks the JSON: rows sum to the total, dimensions scale correctly, and the axes are principal axes.
#[test]
fn json_holds_the_same_and_scales() {
    let (one, larger) = (json(&[]), json(&["--scale", "1.1"]));
    let bodies = one["bodies"].as_array().expect("bodies");
    assert_eq!(bodies.len(), 18);
    let sum = |key: &str| bodies.iter().map(|body| body[key].as_f64().expect(key)).sum::<f64>();
    let number = |value: &Value| value.as_f64().expect("a number");
    assert!((sum("mass_kg") - number(&one["sum_kg"])).abs() < 1e-12);
    assert!((sum("fraction") - 1.0).abs() < 1e-12);
    assert!((sum("de_leva_fraction") - 1.0).abs() < 1e-12);
    for (body, larger) in bodies.iter().zip(larger["bodies"].as_array().expect("bodies")) {
        assert!((number(&larger["mass_kg"]) / number(&body["mass_kg"]) - 1.331).abs() < 1e-12);
        for row in 0..3 {
            let center = number(&body["center_of_mass_m"][row]);
            assert!((number(&larger["center_of_mass_m"][row]) - 1.1 * center).abs() < 1e-15);
            for column in 0..3 {
                let element = |body: &Value| number(&body["rotational_kg_m2"][row][column]);
                if row == column {
                    assert!((element(larger) / element(body) - 1.1f64.powi(5)).abs() < 1e-12);
                } else {
                    assert!(element(body).abs() < 1e-15, "{body}");
                }
            }
        }
    }
}

#[test]
fn a_subject_of_ones_own() {
    let reference =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/figure/subjects/reference.toml");
    let reference = std::fs::read_to_string(reference).expect("the built-in subject");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("anna.toml");
    let path = file.to_str().expect("a path in UTF-8");

    std::fs::write(&file, reference.replace("normalise = false", "normalise = true")).unwrap();
    let normalised = json(&[path]);
    assert!((normalised["sum_kg"].as_f64().unwrap() - 75.0).abs() < 1e-12);
    assert!((normalised["regression_sum_kg"].as_f64().unwrap() - 76.483).abs() < 1e-3);

    let slip = reference.replace("wrist_breadth_m = 0.058", "wrist_breadth_m = 5.8");
    std::fs::write(&file, slip).unwrap();
    let output = figure(&[path]);
    assert_eq!(output.status.code(), Some(2));
    let error = text(&output.stderr);
    for part in ["anna.toml", "line ", "wrist_breadth_m = 5.8", "is it in centimetres"] {
        assert!(error.contains(part), "{part}: {error}");
    }

    let output = figure(&["nobody.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("nobody.toml: cannot be read"));
}
