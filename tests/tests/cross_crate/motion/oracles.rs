//! Golden numbers, recomputed by the code of `sinew evaluate verify`; and checks that a wrong number would be
//! noticed.

use std::fs;
use std::path::{Path, PathBuf};

use sinew_verification::{Kind, VerifyError, verify_folder};
use tempfile::TempDir;

fn oracles() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("oracles")
}

/// Creates a folder with one changed file of the oracles.
fn folder_with(file: &str, change: impl Fn(&str) -> String) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let text = fs::read_to_string(oracles().join(file)).expect("the oracles are there");
    let changed = change(&text);
    assert_ne!(text, changed, "nothing was changed");
    fs::write(folder.path().join(file), changed).expect("the folder can be written");
    folder
}

fn refusal(folder: &TempDir) -> String {
    verify_folder(folder.path(), &[]).expect_err("it cannot be computed").to_string()
}

#[test]
fn all_are_within_their_limits() {
    let report = verify_folder(&oracles(), &[]).expect("the oracles can be computed");
    let files: Vec<_> = report.files.iter().map(|(file, _)| file.as_str()).collect();
    let expected = [
        "control",
        "errors",
        "finite_difference",
        "hauberg",
        "rnea_05",
        "rnea_18",
        "rnea_32",
        "solids",
        "weights",
    ];
    assert_eq!(files, expected.map(|name| format!("{name}.json")));
    for (file, tallies) in &report.files {
        for tally in tallies {
            assert!(tally.passed(), "{file}: {tally:?}");
        }
    }
    assert!(report.passed());
}

#[test]
fn a_wrong_number_is_over_its_limit() {
    // In each file one number is changed, by another digit.
    for (file, quantity, right, wrong) in [
        ("rnea_05.json", "tau", "\"tau\":[[", "\"tau\":[[1"),
        ("solids.json", "volume", "\"volume\":", "\"volume\":1"),
        ("hauberg.json", "line energy", "\"line\":{\"energy\":", "\"line\":{\"energy\":1"),
        ("weights.json", "cylinder_exact raw", "\"radius\":[0.1,0.14", "\"radius\":[0.1,0.15"),
        ("errors.json", "local e_rot", "\"local\":[{\"e_rot\":[", "\"local\":[{\"e_rot\":[1"),
        ("finite_difference.json", "forward lin_vel", "\"lin_vel\":[[", "\"lin_vel\":[[1"),
        (
            "control.json",
            "local, acceleration",
            "\"local\":{\"joint_acc_child\":[[",
            "\"local\":{\"joint_acc_child\":[[1",
        ),
    ] {
        let folder = folder_with(file, |text| {
            // Inserts a digit before the first number, after its sign.
            let minus = format!("{right}-");
            if text.contains(&minus) {
                text.replacen(&minus, &wrong.replace("[1", "[-1"), 1)
            } else {
                text.replacen(right, wrong, 1)
            }
        });
        let report = verify_folder(folder.path(), &[]).expect("it can be computed");
        assert!(!report.passed(), "{file}");
        let failed: Vec<_> =
            report.files[0].1.iter().filter(|t| !t.passed()).map(|t| t.quantity.as_str()).collect();
        assert!(failed.contains(&quantity), "{file}: {failed:?}");
    }
}

#[test]
fn what_cannot_be_computed_is_named_with_file_case_and_field() {
    let rename =
        |from: &'static str, to: &'static str| move |text: &str| text.replacen(from, to, 1);
    let unknown = folder_with("rnea_05.json", rename("rnea/1", "rnea/2"));
    let error = refusal(&unknown);
    assert!(error.contains("rnea_05.json") && error.contains("rnea/2"), "{error}");

    let missing = folder_with("rnea_05.json", rename("\"tau\"", "\"tua\""));
    let error = refusal(&missing);
    for part in ["rnea_05.json", "case 0 (s05_free_random_g0)", "states[0]", "`tau`"] {
        assert!(error.contains(part), "{part}: {error}");
    }

    let huge = folder_with("errors.json", rename("\"pos\":[[-0.", "\"pos\":[[-1e39,0."));
    let error = refusal(&huge);
    assert!(error.contains("case 0 (s05_small), desired.pos[0]"), "{error}");

    let long = folder_with(
        "control.json",
        rename("\"desired\":{\"quat\":[[0.", "\"desired\":{\"quat\":[[1."),
    );
    let error = refusal(&long);
    assert!(error.contains("desired.quat[0]") && error.contains("unit quaternion"), "{error}");

    let short =
        folder_with("finite_difference.json", rename("\"lin_vel\":[[", "\"lin_vel\":[[0,0,0],["));
    let error = refusal(&short);
    assert!(
        error.contains("forward.lin_vel") && error.contains("12 entries, expected 11"),
        "{error}"
    );

    let two = folder_with("weights.json", rename("\"parent\":[-1,0", "\"parent\":[-1,-1"));
    let error = refusal(&two);
    assert!(error.contains("parent, pos") && error.contains("joint 1 has no parent"), "{error}");

    let cut = folder_with("errors.json", |text| text[..text.len() / 2].to_owned());
    let error = refusal(&cut);
    assert!(error.contains("errors.json") && error.contains("line"), "{error}");

    let empty = folder_with("errors.json", |_| r#"{"schema": "errors/1", "cases": []}"#.to_owned());
    assert!(refusal(&empty).contains("no cases"));
}

#[test]
fn a_kind_can_be_skipped_but_not_everything() {
    let folder = folder_with("rnea_05.json", |text| text.replacen("rnea/1", "hauberg/2", 1));
    let error = refusal(&folder);
    assert!(error.contains("hauberg/2") && error.contains("--skip"), "{error}");
    let all = verify_folder(folder.path(), &[Kind::Hauberg]);
    assert!(matches!(all, Err(VerifyError::NoFile { skipped: 1, .. })), "{all:?}");

    fs::copy(oracles().join("control.json"), folder.path().join("control.json")).expect("a copy");
    let report = verify_folder(folder.path(), &[Kind::Hauberg]).expect("one file is left");
    assert_eq!(report.skipped, [("rnea_05.json".to_owned(), Kind::Hauberg)]);
    assert!(report.passed());
}

#[test]
fn a_folder_without_golden_files_is_an_error() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let none = verify_folder(folder.path(), &[]);
    assert!(matches!(none, Err(VerifyError::NoFile { skipped: 0, .. })), "{none:?}");
    let missing = verify_folder(&folder.path().join("missing"), &[]);
    assert!(matches!(missing, Err(VerifyError::Read { .. })), "{missing:?}");
}
