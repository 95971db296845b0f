//! Tests of the built-in kinds of servo: plausible, with sources, and equal to their page in the documentation.
//! `INSTA_UPDATE=always` with this test writes `docs/servos.md`.

use std::fmt::Write as _;

use sinew_rig::description::{ServoModel, SourcedValue};

type Value = fn(&ServoModel) -> &SourcedValue;

/// Name, unit and accessor of each value.
const VALUES: [(&str, &str, Value); 19] = [
    ("voltage", "V", |m| &m.voltage_v),
    ("torque constant", "N m/A", |m| &m.torque_constant_nm_a),
    ("stall torque", "N m", |m| &m.stall_torque_nm),
    ("stall current", "A", |m| &m.stall_current_a),
    ("continuous torque", "N m", |m| &m.continuous_torque_nm),
    ("no-load speed", "rad/s", |m| &m.no_load_speed_rad_s),
    ("own position gain", "N m/rad", |m| &m.position_gain_nm_rad),
    ("rotor inertia, at the shaft", "kg m²", |m| &m.rotor_inertia_kg_m2),
    ("Coulomb friction", "N m", |m| &m.friction_nm),
    ("viscous friction", "N m s", |m| &m.damping_nm_s),
    ("resolution", "rad", |m| &m.resolution_rad),
    ("backlash, end to end", "rad", |m| &m.backlash_rad),
    ("gear stiffness", "N m/rad", |m| m.gear_stiffness_nm_rad.as_ref().expect("it has one")),
    ("gear damping", "N m s", |m| m.gear_damping_nm_s.as_ref().expect("it has one")),
    ("friction at the output", "1", |m| m.output_friction_share.as_ref().expect("it has one")),
    ("range, end to end", "rad", |m| &m.range_rad),
    ("thermal resistance", "K/W", |m| &m.thermal_resistance_k_w),
    ("thermal time constant", "s", |m| &m.thermal_time_s),
    ("shuts down at", "°C", |m| &m.shutdown_c),
];

type Pulse = fn(&ServoModel) -> &Option<SourcedValue>;

/// Name of each pulse of a hobby servo, and a function that returns it.
const PULSES: [(&str, Pulse); 3] = [
    ("shortest pulse", |m| &m.pulse_least_us),
    ("pulse of position zero", |m| &m.pulse_middle_us),
    ("longest pulse", |m| &m.pulse_most_us),
];

fn models() -> Vec<ServoModel> {
    ServoModel::built_in_names()
        .map(|name| {
            let model = ServoModel::built_in(name).unwrap_or_else(|| panic!("{name} is no TOML"));
            assert_eq!(model.name, name);
            model
        })
        .collect()
}

#[test]
fn every_value_is_plausible_and_says_where_it_is_from() {
    for model in models() {
        let name = &model.name;
        for (what, _, of) in VALUES {
            let SourcedValue { value, source } = of(&model);
            assert!(value.is_finite() && *value > 0.0, "{name}: {what} is {value}");
            assert!(source.trim().len() > 5, "{name}: {what} has no source");
        }
        let value = |of: Value| of(&model).value;
        let (torque, current) = (value(|m| &m.stall_torque_nm), value(|m| &m.stall_current_a));
        let constant = value(|m| &m.torque_constant_nm_a);
        // Makers measure stall values in the first moment; gears and amplifiers lose up to a quarter of the torque.
        let ratio = torque / (constant * current);
        assert!(
            (0.75..1.25).contains(&ratio),
            "{name}: stall torque {ratio} of constant times current"
        );
        // No motor is faster than its constant permits; friction, gears and speed limits reduce the speed by up to
        // 60 %.
        let ratio = value(|m| &m.no_load_speed_rad_s) * constant / value(|m| &m.voltage_v);
        assert!(
            (0.4..1.0).contains(&ratio),
            "{name}: no-load speed {ratio} of voltage over constant"
        );
        // Friction at no-load speed must be below the stall torque.
        let lost = value(|m| &m.friction_nm)
            + value(|m| &m.damping_nm_s) * value(|m| &m.no_load_speed_rad_s);
        assert!(lost < torque, "{name}: friction {lost} of {torque} N m");
        let held = value(|m| &m.continuous_torque_nm) / torque;
        assert!((0.1..0.6).contains(&held), "{name}: continuous torque is {held} of stall");
        // A servo's own controller gives full torque at a position error below 1 rad, but not at an error of one
        // step.
        let full = torque / value(|m| &m.position_gain_nm_rad);
        assert!(
            (value(|m| &m.resolution_rad)..1.0).contains(&full),
            "{name}: full torque at {full} rad"
        );
        assert!(value(|m| &m.backlash_rad) < 0.05 && value(|m| &m.resolution_rad) < 0.02, "{name}");
        assert!((1.0..6.3).contains(&value(|m| &m.range_rad)), "{name}");
        assert!((50.0..100.0).contains(&value(|m| &m.shutdown_c)), "{name}");
    }
}

/// A value without a source equals the default of a kind that leaves the value out.
#[test]
fn guesses_of_gears_are_the_defaults() {
    for model in models() {
        let silent = ServoModel {
            gear_stiffness_nm_rad: None,
            gear_damping_nm_s: None,
            output_friction_share: None,
            ..model.clone()
        };
        for (of, guessed, default) in [
            (&model.gear_stiffness_nm_rad, model.gear_stiffness(), silent.gear_stiffness()),
            (&model.gear_damping_nm_s, model.gear_damping(), silent.gear_damping()),
            (
                &model.output_friction_share,
                model.output_friction_share(),
                silent.output_friction_share(),
            ),
        ] {
            // The files have at least three digits.
            let is_guess = of.as_ref().is_some_and(SourcedValue::is_guess);
            assert!(!is_guess || (guessed / default - 1.0).abs() < 5e-3, "{}", model.name);
        }
    }
}

#[test]
fn cautions_of_the_sources_are_kept() {
    let model = |name| ServoModel::built_in(name).unwrap();
    // The identified model of the STS3215 stalls at 3.35 N m, far above its rating.
    assert!(model("STS3215-7.4V").stall_torque_nm.value < 2.0);
    // The divisor of the XL330's P gain was observed as 256; with the manual's 128 it would be twice as stiff.
    assert!(model("XL330-M288-T").position_gain_nm_rad.value < 0.7);
    // No hobby servo has been measured: only figures of sellers have a source.
    for name in ["SG90", "MG90S", "MG996R", "DS3218"] {
        let model = model(name);
        for value in [&model.rotor_inertia_kg_m2, &model.friction_nm, &model.backlash_rad] {
            assert!(value.is_guess(), "{name}");
        }
    }
    assert_eq!(ServoModel::built_in("XL330"), None);
}

#[test]
fn the_page_of_servos_is_what_the_files_say() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/servos.md");
    let page = page();
    if std::env::var_os("INSTA_UPDATE").is_some_and(|update| update == "always") {
        std::fs::write(path, &page).unwrap();
    }
    let written = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        written == page,
        "docs/servos.md is not what crates/rig/models say: INSTA_UPDATE=always writes it"
    );
}

fn cell(sourced: &SourcedValue) -> String {
    format!("{}{}", sourced.value, if sourced.is_guess() { " ?" } else { "" })
}

fn page() -> String {
    let models = models();
    let mut page = "# Servos\n\n\
        These kinds of servo are built in: write their name as the `model` of a `[[servo]]` of your rig. A kind that\n\
        is not here goes into the rig's own `[[servo_model]]`, with the same keys and a source for every value.\n\n\
        Values are at the output shaft, at the voltage in the first row. A question mark is a guess: nobody has\n\
        measured or stated it. Measure your own before you rely on it. A servo's own position counts from the middle\n\
        of its range; that of a hobby servo from its pulse of position zero. `pulse_us` and `travel_deg` of a\n\
        `[[servo]]` have the pulses that you measured.\n\n"
        .to_owned();
    let mut line = |cells: Vec<String>| writeln!(page, "| {} |", cells.join(" | ")).unwrap();
    let names = models.iter().map(|model| model.name.clone());
    line([String::new(), "unit".to_owned()].into_iter().chain(names).collect());
    line(vec!["---".to_owned(); models.len() + 2]);
    for (what, unit, of) in VALUES {
        let numbers = models.iter().map(|model| cell(of(model)));
        line([what.to_owned(), unit.to_owned()].into_iter().chain(numbers).collect());
    }
    for (what, of) in PULSES {
        let numbers = models.iter().map(|model| of(model).as_ref().map_or("-".to_owned(), cell));
        line([what.to_owned(), "us".to_owned()].into_iter().chain(numbers).collect());
    }
    page += "\n## Sources\n\n\
        ROBOTIS e-manual: emanual.robotis.com. Rhoban/bam, hshi74/toddlerbot, Open_Duck_Playground: repositories of\n\
        identified models, at the named commits.\n";
    for model in &models {
        writeln!(page, "\n### {}\n\n| value | source |\n| --- | --- |", model.name).unwrap();
        for (what, _, of) in VALUES {
            writeln!(page, "| {what} | {} |", of(model).source).unwrap();
        }
        for (what, of) in PULSES {
            let Some(sourced) = of(model) else { continue };
            writeln!(page, "| {what} | {} |", sourced.source).unwrap();
        }
    }
    page
}
