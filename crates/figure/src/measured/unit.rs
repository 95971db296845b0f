//! Finds the length of a file's unit.

use sinew_mocap::Recording;
use sinew_retarget::skeleton::{BODY_HEIGHT_M, SkeletonMatch};

use crate::mapping::Mapping;

/// The mapping with which a recording is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MappingSource<'a> {
    /// The mapping.
    pub mapping: &'a Mapping,
    /// Whether the user gave the mapping. Its unit is then the user's instruction, not only the usual unit of
    /// files with this skeleton.
    pub is_given: bool,
}

/// Finds the unit in metres and the reason for it. The first of these that exists is used: the user's unit, the file's
/// own, the given mapping's, the known skeleton's, a unit inferred from the body's height. The known skeleton's unit is
/// used only if it gives a plausible body and does not differ from the inferred unit.
///
/// # Errors
/// The reason why the unit cannot be determined.
pub(super) fn find(
    recording: &Recording,
    matched: &SkeletonMatch,
    by: Option<MappingSource<'_>>,
    given: Option<f64>,
) -> Result<(f64, String), String> {
    if let Some(metres) = given {
        return Ok((metres, "as you specified".to_owned()));
    }
    if let Some(metres) = recording.metres_per_unit {
        return Ok((metres, "as its format says".to_owned()));
    }
    let guess = matched.unit.as_ref();
    let by_height = guess.and_then(|unit| Some((unit.metres_per_unit?, unit.reason.clone())));
    if let Some(MappingSource { mapping, is_given }) = by {
        let metres = mapping.metres_per_unit;
        let why = if is_given { "as the mapping says" } else { "as other files of this skeleton" };
        // A guess by height can contradict the mapping only if there is a body.
        let is_believable =
            guess.is_none_or(|unit| BODY_HEIGHT_M.contains(&(metres * unit.height)));
        let same = by_height.as_ref().is_none_or(|(guess, _)| same_unit(*guess, metres));
        if is_given || is_believable && same {
            return Ok((metres, why.to_owned()));
        }
        if let Some((guess, reason)) = by_height {
            let height_m = metres * matched.unit.as_ref().map_or(0.0, |unit| unit.height);
            let other = format!(
                "{reason}; files of skeleton `{}` are in units of {} m, which made it {height_m:.2} m",
                mapping.name,
                short(metres)
            );
            return Ok((guess, other));
        }
        if is_believable {
            return Ok((metres, why.to_owned()));
        }
    }
    by_height.ok_or_else(|| match guess {
        Some(unit) => unit.reason.clone(),
        None => "no arms and legs show the body's height".to_owned(),
    })
}

/// Returns whether two lengths are one unit up to rounding: CMU's unit is written with six digits.
fn same_unit(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < 1e-3
}

/// Formats a length in metres with up to six decimals, without trailing zeros.
pub(super) fn short(metres: f64) -> String {
    let text = format!("{metres:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
