//! Compares published figures of servos with simulated ones.

use sinew_servo_sim::model::Parameters;
use sinew_servo_sim::published::{page, sag_rad, table};

#[test]
fn simulated_servos_do_what_is_published_of_them() {
    let rows = table().expect("the built-in files are good");
    for row in &rows {
        println!("{row:?}");
    }
    let wrong: Vec<_> = rows.iter().filter(|row| !row.holds()).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(rows.iter().filter(|row| !row.is_fitted && row.within.is_some()).count() >= 5);
}

#[test]
fn the_page_is_what_the_simulation_does() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/simulated-servos.md");
    let written = std::fs::read_to_string(path).expect("the page is there");
    let now = page(&table().expect("the built-in files are good"));
    assert!(
        written == now,
        "docs/simulated-servos.md is old: `cargo run -p sinew-servo-sim --example published` prints it anew"
    );
}

#[test]
fn an_sts3215_holds_with_its_stiffness_give_or_take_its_friction() {
    let kind = Parameters::built_in("STS3215-7.4V").expect("it is built in");
    let (torque_nm, stiffness) = (0.3, kind.position_gain_nm_rad);
    let [sagging, lifted] = sag_rad(&kind, torque_nm).expect("it has registers");
    // At rest the motor's torque differs from the load's by at most the friction, which grows with both torques: at
    // most by the friction of the larger one.
    let most_nm = torque_nm + 2.0 * kind.friction_nm;
    let band = kind.friction_nm + kind.stribeck_nm + 2.0 * kind.load_friction * most_nm;
    let step = kind.resolution_rad;
    for rest in [sagging, lifted] {
        assert!((rest - torque_nm / stiffness).abs() <= band / stiffness + step, "{rest} rad");
    }
    assert!(lifted > sagging, "it rests where friction lets it: {lifted} and {sagging} rad");
}

#[test]
fn guesses_are_told() {
    for name in sinew_rig::description::ServoModel::built_in_names() {
        let kind = Parameters::built_in(name).expect("it is built in");
        assert!(kind.guesses.contains(&"winding_time_s"), "{name}");
        let motor_nm = kind.torque_constant_nm_a * kind.voltage_v / kind.resistance_ohm;
        println!(
            "{name}: {:.3} N m/A, {:.2} ohm, {motor_nm:.2} N m before friction, {:.3} of the load; guessed: {}",
            kind.torque_constant_nm_a,
            kind.resistance_ohm,
            kind.load_friction,
            kind.guesses.join(", ")
        );
    }
    assert!(
        Parameters::built_in("X1").is_err_and(|error| error.to_string().contains("XL330-M288-T"))
    );
}
