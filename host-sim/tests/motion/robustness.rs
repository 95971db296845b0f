//! `sinew evaluate robustness` and `sinew evaluate latency` as commands.

use crate::common::{printed, sinew};

#[test]
fn every_rig_has_a_row_and_the_threads_do_not_matter() {
    let rigs = |threads: &str| {
        printed(&[
            "evaluate",
            "robustness",
            "--seconds",
            "0.2",
            "--rigs",
            "3",
            "--threads",
            threads,
        ])
    };
    let text = rigs("1");
    assert_eq!(text, rigs("2"));
    for row in ["|      1 |", "|      2 |", "|      3 |", "| median |"] {
        assert!(text.contains(row), "{text}");
    }
    assert!(
        text.contains("recommended is below world in mean angular and linear error on"),
        "{text}"
    );
}

#[test]
fn the_front_trades_angle_for_distance() {
    let text = printed(&[
        "evaluate",
        "robustness",
        "--seconds",
        "0.5",
        "--rigs",
        "2",
        "--methods",
        "local,recommended",
        "--projection-weights",
        "1,0.5",
    ]);
    let (_, front) = text.split_once("medians over the rigs").expect("a second table");
    let cells = |name: &str| -> [&str; 2] {
        let mut rows = front.lines().map(|line| line.split('|').map(str::trim).collect::<Vec<_>>());
        let row = rows.find(|row| row.get(1) == Some(&name));
        let row = row.expect("a row of the setting");
        [row[2], row[3]]
    };
    assert_eq!(cells("recommended, 0.5 m"), cells("recommended"), "{text}");
    let medians = |name: &str| cells(name).map(|cell| cell.parse::<f64>().expect("a number"));
    let ([angle, distance], [default_angle, default_distance]) =
        (medians("recommended, 1 m"), medians("recommended, 0.5 m"));
    assert!(angle < default_angle && distance > default_distance, "{text}");
}

#[test]
fn looking_ahead_lets_a_drive_come_later() {
    let text = printed(&[
        "evaluate",
        "latency",
        "--seconds",
        "1",
        "--rates-hz",
        "500",
        "--methods",
        "world",
    ]);
    let steps = |looks_ahead: &str| -> usize {
        let row = text.lines().find(|line| line.contains(&format!("{looks_ahead} |")));
        let cell = row.and_then(|row| row.split('|').nth(3)).expect("a row of three cells");
        cell.split_whitespace().next().and_then(|n| n.parse().ok()).expect("a number of steps")
    };
    assert!(steps("yes") > steps("no"), "{text}");
}

#[test]
fn what_cannot_be_is_refused_with_what_could() {
    for (arguments, part) in [
        (&["evaluate", "robustness", "--rigs", "0"][..], "1..=1000"),
        (&["evaluate", "robustness", "--projection-weights", "0.5,0"], "rotation_m"),
        (&["evaluate", "robustness", "--projection-weights", "nan"], "rotation_m"),
        (
            &["evaluate", "robustness", "--rate-hz", "500", "--frame-rate-hz", "300"],
            "divides the control rate",
        ),
        (&["evaluate", "robustness", "--set", "controller.law=pd"], "inverse_dynamics"),
        (&["evaluate", "robustness", "--set", "disturbance.sensor_bits=40"], "0 to 24 bits"),
        (&["evaluate", "latency", "--rates-hz", "nan"], "a number of Hz from 10 to 10000"),
        (&["evaluate", "latency", "--set", "controller.observer.cancel=true"], "nothing to cancel"),
    ] {
        let output = sinew(arguments);
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(told.contains(part), "{arguments:?}: {told}");
        assert!(output.stdout.is_empty());
    }
}
