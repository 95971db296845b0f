//! `sinew robustness` and `sinew latency` as commands.

use std::process::{Command, Output};

fn sinew(arguments: &[&str]) -> Output {
    let output = Command::new(env!("CARGO_BIN_EXE_sinew")).args(arguments).output();
    output.expect("the command starts")
}

fn printed(arguments: &[&str]) -> String {
    let output = sinew(arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

#[test]
fn every_rig_has_a_row_and_the_threads_do_not_matter() {
    let rigs = |threads: &str| {
        printed(&["robustness", "--seconds", "0.2", "--seeds", "3", "--threads", threads])
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
        "robustness",
        "--seconds",
        "0.5",
        "--seeds",
        "2",
        "--methods",
        "local,recommended",
        "--front",
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
    let text = printed(&["latency", "--seconds", "1", "--rates", "500", "--methods", "world"]);
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
        (&["robustness", "--seeds", "0"][..], "1..=1000"),
        (&["robustness", "--front", "0.5,0"], "rotation_m"),
        (&["robustness", "--front", "nan"], "rotation_m"),
        (&["robustness", "--rate", "500", "--frames", "300"], "a whole number of times"),
        (&["robustness", "--set", "controller.law=pd"], "inverse_dynamics"),
        (&["robustness", "--set", "disturbance.sensor_bits=40"], "0 to 24 bits"),
        (&["latency", "--rates", "nan"], "a number of Hz from 10 to 10000"),
        (&["latency", "--set", "controller.observer.cancel=true"], "nothing to cancel"),
    ] {
        let output = sinew(arguments);
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(told.contains(part), "{arguments:?}: {told}");
        assert!(output.stdout.is_empty());
    }
}
