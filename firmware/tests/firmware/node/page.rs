//! Checks the settings on the page `docs/link.md`: numbers, names, defaults and bounds must be those of the code.

use std::fmt::Write;

use sinew_firmware::controller::ControllerSettings;
use sinew_firmware::node::{
    NodeSettings, RIG_SCHEMA, SETTING_NAMES, SETTING_TEXTS, SETTINGS_SCHEMA, SHOW_SCHEMA,
    SettingsError,
};
use sinew_firmware::supervisor::{Fault, TABLE};

use super::test_rig::{Kind, setup};

const PAGE: &str = include_str!("../../../../docs/link.md");

fn assert_on_page(text: &str) {
    assert!(PAGE.contains(text), "docs/link.md lacks this:\n{text}");
}

/// Each setting is shown with the board's default and its bounds, while all others have their defaults.
#[test]
fn settings_are_on_the_page_of_the_link() {
    // The tick of 2.5 ms is the rig's.
    let settings = NodeSettings::new(ControllerSettings::default(), setup(Kind::Current).schedule);
    let mut table = String::from(
        "| number | setting | default | least | most | what |\n|---:|---|---:|---:|---:|---|\n",
    );
    for ((key, name), what) in (1..).zip(SETTING_NAMES).zip(SETTING_TEXTS) {
        let Err(SettingsError::Value(bounds)) = settings.with(key, f32::NAN) else {
            panic!("{name} may be NaN")
        };
        assert_eq!(bounds.what, name);
        let [own, least, most] = [settings.get(key).unwrap(), bounds.least, bounds.most];
        let [own, least, most] =
            [own, least, most].map(|number| (f64::from(number) * 1e4).round() / 1e4);
        writeln!(table, "| {key} | `{name}` | {own} | {least} | {most} | {what} |").unwrap();
    }
    assert_on_page(&table);
}

#[test]
fn schema_versions_are_on_the_page_of_the_link() {
    let rows = [("0 Settings", SETTINGS_SCHEMA), ("1 Rig", RIG_SCHEMA), ("2 Show", SHOW_SCHEMA)];
    let mut table = String::from("| kind | schema version |\n|---|---:|\n");
    for (kind, version) in rows {
        writeln!(table, "| {kind} | {version} |").unwrap();
    }
    assert_on_page(&table);
}

/// A user reads these numbers in a summary or a refusal.
#[test]
fn faults_are_on_the_page_of_the_link() {
    let list = TABLE.iter().map(|row| format!("{} {}", row.fault.number(), row.fault.name()));
    let list = list.collect::<Vec<_>>().join("; ");
    assert!(
        Fault::COUNT == TABLE.len() && PAGE.replace('\n', " ").contains(&list),
        "docs/link.md lacks: {list}"
    );
}
