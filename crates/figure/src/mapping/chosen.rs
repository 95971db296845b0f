//! The mapping of a recording: the one given, a known one, or a proposal.

use std::borrow::Cow;
use std::fmt;

use sinew_mocap::Recording;
use sinew_retarget::skeleton::{MapHead, SkeletonMatch, figure_mapping};

use super::binding::Binding;
use super::file::{Error, Mapping};
use super::known::choose;

/// What is less sure is not taken without asking: animals, and humans that lack what tells their joints apart.
const SURE: f64 = 0.45;

/// A recording's mapping, and where it is from.
#[derive(Debug, Clone, PartialEq)]
pub struct ChosenMapping<'a> {
    /// The mapping.
    pub mapping: Cow<'a, Mapping>,
    /// How sure it is, if nobody wrote it.
    pub proposed: Option<Proposal>,
}

/// How sure a proposal is.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// The least sure body.
    pub body: String,
    /// 0 is a guess, 1 certain.
    pub confidence: f64,
    /// Why it is no surer.
    pub reason: String,
}

impl fmt::Display for Proposal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { body, confidence, reason } = self;
        write!(
            f,
            "mapped as `sinew clip map` proposes, as no known skeleton has its joints; least sure: {body}, {:.0} %: {reason}",
            100.0 * confidence
        )
    }
}

/// The mapping of `recording`: `given`, else that of a known skeleton, else a proposal.
///
/// # Errors
/// [`Error::NotProposed`] if no known skeleton fits and the joints of a human are not found, or not surely;
/// [`Error::SeveralMatch`].
pub fn find_mapping<'a>(
    recording: &Recording,
    given: Option<&'a Mapping>,
) -> Result<ChosenMapping<'a>, Error> {
    let as_it_is = |mapping| ChosenMapping { mapping: Cow::Borrowed(mapping), proposed: None };
    if let Some(mapping) = given {
        return Ok(as_it_is(mapping));
    }
    let unknown = match choose(&recording.skeleton) {
        // A skeleton of the same names may hang together in another way.
        Ok(mapping) => match Binding::new(mapping, &recording.skeleton) {
            Ok(_) => return Ok(as_it_is(mapping)),
            Err(error) => error,
        },
        Err(error @ Error::NoneMatches { .. }) => error,
        Err(error) => return Err(error),
    };
    propose(recording).map_err(|why| Error::NotProposed { unknown: Box::new(unknown), why })
}

fn propose(recording: &Recording) -> Result<ChosenMapping<'static>, String> {
    let matched = SkeletonMatch::of_recording(recording);
    let by_height = matched.unit.as_ref().and_then(|unit| unit.metres_per_unit);
    let head = MapHead {
        name: &recording.name,
        // Where nothing tells the unit, the height that comes of metres is refused.
        metres_per_unit: recording.metres_per_unit.or(by_height).unwrap_or(1.0),
        rate_hz: None,
    };
    let proposal =
        figure_mapping(&recording.skeleton, &matched, head).map_err(|error| error.to_string())?;
    let least = proposal.notes.iter().min_by(|a, b| a.confidence.total_cmp(&b.confidence));
    let proposed = least.map(|least| Proposal {
        body: least.body.clone(),
        confidence: least.confidence,
        reason: least.reason.clone(),
    });
    if let Some(Proposal { body, reason, .. }) =
        proposed.as_ref().filter(|least| least.confidence < SURE)
    {
        return Err(format!(
            "not sure of {body}: {reason}. Look at what `sinew clip map` prints, and give it with --mapping if it is right"
        ));
    }
    let mapping = Mapping::try_from(proposal.map)?;
    Ok(ChosenMapping { mapping: Cow::Owned(mapping), proposed })
}
