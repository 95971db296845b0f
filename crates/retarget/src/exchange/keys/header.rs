//! The header of a table of keys.

use super::error::KeyError;
use crate::exchange::columns::{Column, HeaderUnits, Quantity, Unit};

/// The content of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Content {
    /// Times; a factor converts them to s.
    Time(f64),
    /// Easings of rows.
    Easing,
    /// A coordinate, by its index, and its unit.
    Coordinate(usize, Option<Unit>),
}

/// Returns the content of each column of a header.
pub(super) fn contents(
    header: &[String],
    columns: &[Column],
    units: Option<HeaderUnits>,
) -> Result<Vec<Content>, KeyError> {
    let mut contents = Vec::new();
    for (index, name) in header.iter().enumerate() {
        let content = content((index + 1, name), columns, units)?;
        let is_same = |other: &Content| match (other, content) {
            (Content::Coordinate(a, _), Content::Coordinate(b, _)) => *a == b,
            (Content::Time(_), Content::Time(_)) | (Content::Easing, Content::Easing) => true,
            _ => false,
        };
        if contents.iter().any(is_same) {
            return Err(KeyError::Twice(name.clone()));
        }
        contents.push(content);
    }
    if !contents.iter().any(|content| matches!(content, Content::Time(_))) {
        return Err(KeyError::NoTime(header.join(", ")));
    }
    Ok(contents)
}

fn content(
    (number, found): (usize, &str),
    columns: &[Column],
    units: Option<HeaderUnits>,
) -> Result<Content, KeyError> {
    match found.to_lowercase().as_str() {
        "time" | "time_s" => return Ok(Content::Time(1.0)),
        "time_ms" => return Ok(Content::Time(0.001)),
        "easing" => return Ok(Content::Easing),
        _ => {}
    }
    let place = |name: &str| columns.iter().position(|column| column.name == name);
    let with_unit = Unit::ALL.iter().find_map(|unit| {
        let name = found.strip_suffix(unit.name())?.strip_suffix('_')?;
        Some((*unit, place(name)?))
    });
    let repairs = |column: &Column| {
        let names: Vec<String> = Unit::ALL
            .iter()
            .filter(|unit| unit.quantity() == column.quantity)
            .map(|unit| format!("`{}_{unit}`", column.name))
            .collect();
        if names.is_empty() { format!("`{}`", column.name) } else { names.join(" or ") }
    };
    match (with_unit, place(found)) {
        (Some((unit, place)), _) if unit.quantity() == columns[place].quantity => {
            Ok(Content::Coordinate(place, Some(unit)))
        }
        (_, Some(place)) => match (columns[place].quantity, units) {
            (Quantity::Pure, _) => Ok(Content::Coordinate(place, None)),
            (quantity, Some(units)) => Ok(Content::Coordinate(place, units.of(quantity))),
            (_, None) => Err(KeyError::NoUnit {
                number,
                name: found.to_owned(),
                repairs: repairs(&columns[place]),
            }),
        },
        (Some((unit, place)), None) => Err(KeyError::WrongUnit {
            number,
            found: found.to_owned(),
            name: columns[place].name.clone(),
            unit: unit.name(),
            repairs: repairs(&columns[place]),
        }),
        (None, None) => Err(KeyError::Column {
            number,
            found: found.to_owned(),
            expected: columns.iter().map(Column::header).collect::<Vec<_>>().join(", "),
        }),
    }
}
