//! Writes calibration results to a rig file, and keeps the rest of its text unchanged.

use toml_edit::{Array, DocumentMut, Item, TableLike, Value};

use crate::ServiceError;
use sinew_rig::description::SourcedValue;

/// New values of a servo in a rig file; `None` keeps the old value.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ServoChange {
    /// Name of the servo.
    pub name: String,
    /// Range of the servo's own position, deg.
    pub range_deg: Option<[f64; 2]>,
    /// The servo's own position at which the drive is at zero, deg.
    pub offset_deg: Option<f64>,
    /// Value of the servo's register Homing Offset, deg.
    pub homing_offset_deg: Option<f64>,
    /// Direction of the servo relative to its drive, 1 or -1.
    pub direction: Option<i8>,
}

/// Returns the text with new ranges and offsets. Comments, order and all other keys are unchanged.
///
/// # Errors
/// [`ServiceError::Rig`] if the text is not a valid rig before or after the change, or a servo is missing.
pub fn edited(text: &str, changes: &[ServoChange]) -> Result<String, ServiceError> {
    let refused = |name: &str, what: String| ServiceError::Rig { name: name.to_owned(), what };
    let mut document: DocumentMut = text
        .parse()
        .map_err(|error: toml_edit::TomlError| refused("the rig file", error.to_string()))?;
    for change in changes {
        let servo = servo(&mut document, &change.name)
            .ok_or_else(|| refused(&change.name, "the rig file has no such servo".to_owned()))?;
        if let Some(range) = change.range_deg {
            let range: Array = range.map(short).into_iter().collect();
            set(servo, "range_deg", range.into());
        }
        if let Some(offset) = change.offset_deg {
            set(servo, "offset_deg", short(offset).into());
        }
        if let Some(offset) = change.homing_offset_deg {
            set(servo, "homing_offset_deg", short(offset).into());
        }
        if let Some(direction) = change.direction {
            set(servo, "direction", i64::from(direction).into());
        }
    }
    let text = document.to_string();
    // The result must be a valid rig: a new range may contradict other parts of the file.
    sinew_rig::toml_file::read(&text)
        .map_err(|error| refused("the rig file", error.to_string()))?;
    Ok(text)
}

/// Returns the text with a new stiffness (N m/rad) and damping (N m s) of the gear of a servo kind. A built-in kind is
/// first copied into the file completely, with its sources.
///
/// # Errors
/// [`ServiceError::Rig`] if the text is not a valid rig before or after the change, or the kind is unknown.
pub fn with_gear(
    text: &str,
    kind: &str,
    [stiffness, damping]: [SourcedValue; 2],
) -> Result<String, ServiceError> {
    let refused = |what: String| ServiceError::Rig { name: kind.to_owned(), what };
    let rig = sinew_rig::toml_file::read(text).map_err(|error| refused(error.to_string()))?;
    let mut document: DocumentMut =
        text.parse().map_err(|error: toml_edit::TomlError| refused(error.to_string()))?;
    if !rig.servo_models.iter().any(|model| model.name == kind) {
        let model = rig
            .servo_model(kind)
            .ok_or_else(|| refused("there is no such kind of servo".to_owned()))?;
        let mut table = toml_edit::Table::new();
        table.insert("name", toml_edit::value(kind));
        for (key, value) in model.values() {
            table.insert(key, sourced(value.value, &value.source));
        }
        let models = document
            .entry("servo_model")
            .or_insert_with(|| Item::ArrayOfTables(toml_edit::ArrayOfTables::new()));
        let models = models
            .as_array_of_tables_mut()
            .ok_or_else(|| refused("expected `[[servo_model]]` tables".to_owned()))?;
        models.push(table);
    }
    let table = named(&mut document, "servo_model", kind)
        .ok_or_else(|| refused("the rig file has no such kind of servo".to_owned()))?;
    table.insert("gear_stiffness_nm_rad", sourced(four_digits(stiffness.value), &stiffness.source));
    table.insert("gear_damping_nm_s", sourced(four_digits(damping.value), &damping.source));
    let text = document.to_string();
    sinew_rig::toml_file::read(&text).map_err(|error| refused(error.to_string()))?;
    Ok(text)
}

fn sourced(value: f64, source: &str) -> Item {
    let mut table = toml_edit::InlineTable::new();
    table.insert("value", value.into());
    table.insert("source", source.into());
    toml_edit::value(table)
}

/// Rounds to four digits: a tap test is not more accurate.
fn four_digits(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

fn servo<'d>(document: &'d mut DocumentMut, name: &str) -> Option<&'d mut dyn TableLike> {
    named(document, "servo", name)
}

fn named<'d>(
    document: &'d mut DocumentMut,
    key: &str,
    name: &str,
) -> Option<&'d mut dyn TableLike> {
    let is = |table: &dyn TableLike| table.get("name").and_then(Item::as_str) == Some(name);
    match document.get_mut(key)? {
        Item::ArrayOfTables(tables) => {
            tables.iter_mut().find(|table| is(*table)).map(|table| table as &mut dyn TableLike)
        }
        Item::Value(Value::Array(tables)) => tables
            .iter_mut()
            .filter_map(Value::as_inline_table_mut)
            .find(|table| is(*table))
            .map(|table| table as &mut dyn TableLike),
        _ => None,
    }
}

/// Sets a value, and keeps the comment after the old value.
fn set(table: &mut dyn TableLike, key: &str, mut value: Value) {
    if let Some(old) = table.get(key).and_then(Item::as_value) {
        *value.decor_mut() = old.decor().clone();
    }
    table.insert(key, Item::Value(value));
}

/// Rounds to 0.0001 deg, a thousandth of a servo's count: a conversion back to counts gives the same counts.
fn short(degrees: f64) -> f64 {
    // Adding zero avoids -0.
    (degrees * 1e4).round() / 1e4 + 0.0
}

#[cfg(test)]
mod tests {
    use sinew_rig::description::ServoModel;

    use super::*;

    const RIG: &str = r#"# My arm, built in May.
name = "arm"
[[body]]
name = "base"
[[body]]
name = "link"
[[joint]]
name = "bend"
parent = "base"
child = "link"
axis = [0, 0, 1]   # about z
[[drive]]
joints = ["bend"]
servos = ["one"]

[[servo]] # the one with the dent
name = "one"
model = "STS3215-7.4V"
id = 1
range_deg = [-90, 90] # by eye
direction = -1
"#;

    fn change() -> ServoChange {
        ServoChange {
            name: "one".to_owned(),
            range_deg: Some([-57.298_765, 80.0]),
            offset_deg: Some(-12.341),
            ..ServoChange::default()
        }
    }

    #[test]
    fn only_what_changes_is_changed() {
        let text = edited(RIG, &[change()]).unwrap();
        let expected = RIG.replace("[-90, 90]", "[-57.2988, 80.0]") + "offset_deg = -12.341\n";
        assert_eq!(text, expected);
        // Applying the same change again changes nothing.
        assert_eq!(edited(&text, &[change()]).unwrap(), text);
    }

    #[test]
    fn servos_in_one_line_are_found_too() {
        let (head, _) = RIG.split_once("[[servo]]").unwrap();
        let line = "servo = [{ name = \"one\", model = \"STS3215-7.4V\", id = 1 }]\n";
        let text = head.replacen("name = \"arm\"\n", &format!("name = \"arm\"\n{line}"), 1);
        let text = edited(&text, &[change()]).unwrap();
        let rig = sinew_rig::toml_file::read(&text).unwrap();
        assert_eq!(rig.servos[0].offset_rad, Some((-12.341_f64).to_radians()));
    }

    #[test]
    fn a_gear_that_was_measured_has_its_source() {
        let value = |value| SourcedValue { value, source: "tap test".to_owned() };
        let gear = |stiffness| [value(stiffness), value(0.5)];
        let text = with_gear(RIG, "STS3215-7.4V", gear(98.765_432)).unwrap();
        assert!(text.starts_with(RIG), "{text}");
        let before = ServoModel::built_in("STS3215-7.4V").unwrap();
        let expected = ServoModel {
            gear_stiffness_nm_rad: Some(value(98.77)),
            gear_damping_nm_s: Some(value(0.5)),
            ..before
        };
        let rig = sinew_rig::toml_file::read(&text).unwrap();
        assert_eq!(rig.servo_models, [expected]);
        // For a kind in the file, only the two values change.
        let again = with_gear(&text, "STS3215-7.4V", gear(50.0)).unwrap();
        assert_eq!(again, text.replace("98.77", "50.0"));
        assert!(with_gear(RIG, "XYZ", gear(1.0)).is_err());
    }

    #[test]
    fn what_would_be_no_rig_is_refused() {
        let nobody = ServoChange { name: "two".to_owned(), ..change() };
        assert!(edited(RIG, &[nobody]).unwrap_err().to_string().contains("no such servo"));
        let reversed = ServoChange { range_deg: Some([10.0, -10.0]), ..change() };
        assert!(edited(RIG, &[reversed]).unwrap_err().to_string().contains("range_deg"));
        assert!(edited("name =", &[]).is_err());
    }
}
