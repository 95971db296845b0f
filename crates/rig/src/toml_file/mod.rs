//! `rig.toml`: a rig as a text that people read and edit. `docs/rig-file.md` describes its keys.

mod error;
mod item;
mod pose;
mod reader;
mod schema;
#[cfg(test)]
mod tests;
mod value;
mod visitor;
mod writer;

pub use error::ReadError;

use toml::de::DeTable;

use crate::description::Description;
use crate::number::rounded_together;

/// First line of a written file.
const HEADER: &str =
    "# A rig for Sinew: m, kg, N m, degrees. What each key means: docs/rig-file.md\n";

/// Reads a rig, and refuses an invalid one, see [`Description::check`].
///
/// # Errors
/// [`ReadError`] with line, column, key, and a description of a valid value.
///
/// ```
/// let text = r#"
/// name = "lamp"
/// [[body]]
/// name = "foot"
/// [[body]]
/// name = "shade"
/// [[joint]]
/// name = "neck"
/// parent = "foot"
/// child = "shade"
/// axis = [0, 0, 1]
/// range_dge = [-90, 90]
/// "#;
/// let error = sinew_rig::toml_file::read(text).unwrap_err();
/// assert_eq!(
///     error.to_string(),
///     "line 12, column 1: joint[0].range_dge: expected the key range_deg, found an unknown one"
/// );
/// ```
pub fn read(text: &str) -> Result<Description, ReadError> {
    let table = DeTable::parse(text).map_err(|error| ReadError::syntax(text, &error))?;
    let mut rig = Description::default();
    reader::read(&table, |reader| schema::description(&mut rig, reader))
        .map_err(|wrong| wrong.in_text(text))?;
    rig.check().map_err(|error| ReadError::semantic(text, &table, &error))?;
    Ok(rig)
}

/// Writes a rig. Sections have the order of the documentation, defaults are left out, and numbers have at most 12
/// digits.
///
/// [`read`] returns the same rig, except for digits beyond the 12th.
pub fn write(rig: &Description) -> String {
    let mut rig = rig.clone();
    for inertia in rig.bodies.iter_mut().filter_map(|body| body.inertia_kg_m2.as_mut()) {
        // Removes products of inertia that are only rounding errors of a rotation.
        let all = [
            &mut inertia.xx,
            &mut inertia.xy,
            &mut inertia.xz,
            &mut inertia.yy,
            &mut inertia.yz,
            &mut inertia.zz,
        ];
        let rounded = rounded_together(&all.each_ref().map(|element| **element));
        for (element, rounded) in all.into_iter().zip(rounded) {
            *element = rounded;
        }
    }
    format!("{HEADER}{}", writer::write(|writer| schema::description(&mut rig, writer)))
}
