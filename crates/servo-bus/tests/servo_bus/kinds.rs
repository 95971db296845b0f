//! Tests which model's registers belong to a servo kind as named in rig files.

use sinew_servo_bus::{dynamixel, feetech};

fn models(kind: &str) -> [Option<&'static str>; 2] {
    [
        dynamixel::table::Model::of_kind(kind).map(|model| model.name),
        feetech::table::Model::of_kind(kind).map(|model| model.name),
    ]
}

#[test]
fn an_ending_and_case_do_not_matter() {
    for (kind, model) in [
        ("XL330-M288-T", "XL330-M288"),
        ("xl430-w250-t", "XL430-W250"),
        ("XL430-W250-mine", "XL430-W250"),
        ("MX-28", "MX-28"),
        ("MX-64", "MX-64"),
    ] {
        assert_eq!(models(kind), [Some(model), None], "{kind}");
    }
    for (kind, model) in
        [("STS3215-7.4V", "STS3215"), ("sts3215-12v", "STS3215"), ("SCS0009", "SCS0009")]
    {
        assert_eq!(models(kind), [None, Some(model)], "{kind}");
    }
}

#[test]
fn other_names_have_no_registers() {
    for kind in ["MG90S", "XL330", "XL330-M288T", "STS32150", "MX", "-T", "", "é", "STS321é"] {
        assert_eq!(models(kind), [None, None], "{kind}");
    }
}

/// If one model were a kind of another, the result would depend on the order of the lists.
#[test]
fn no_model_is_a_kind_of_another() {
    let names = || {
        let feetech = feetech::table::MODELS.iter().map(|model| model.name);
        dynamixel::table::MODELS.iter().map(|model| model.name).chain(feetech)
    };
    for name in names() {
        assert_eq!(models(name).iter().flatten().collect::<Vec<_>>(), [&name]);
        for other in names().filter(|other| *other != name) {
            assert!(!name.to_lowercase().starts_with(&format!("{other}-").to_lowercase()));
        }
    }
}
