//! Finds the mapping of a recording: the given mapping, a known skeleton's mapping, or a proposal.

use std::borrow::Cow;
use std::fmt;

use sinew_mocap::Recording;
use sinew_retarget::skeleton::{MapHead, SkeletonMatch, figure_mapping};

use super::binding::Binding;
use super::file::{Error, Mapping};
use super::known::choose;

/// Minimum confidence of a proposal that is used without asking. Below it are animals, and humans whose skeleton
/// does not allow their joints to be distinguished.
const SURE: f64 = 0.45;

/// A recording's mapping, and its source.
#[derive(Debug, Clone, PartialEq)]
pub struct ChosenMapping<'a> {
    /// The mapping to use.
    pub mapping: Cow<'a, Mapping>,
    /// The confidence, if the mapping is a proposal.
    pub proposed: Option<Proposal>,
}

/// Confidence of a proposed mapping.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// Name of the least certain body.
    pub body: String,
    /// Confidence of that body: 0 is a guess, 1 certain.
    pub confidence: f64,
    /// Reason for the limited confidence.
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

/// Finds the mapping of `recording`: `given`, or else that of a known skeleton, or else a proposal.
///
/// # Errors
/// [`Error::NotProposed`] if no known skeleton fits and the joints of a human are not found with sufficient confidence;
/// [`Error::SeveralMatch`] if several known skeletons fit equally well.
pub fn find_mapping<'a>(
    recording: &Recording,
    given: Option<&'a Mapping>,
) -> Result<ChosenMapping<'a>, Error> {
    let as_it_is = |mapping| ChosenMapping { mapping: Cow::Borrowed(mapping), proposed: None };
    if let Some(mapping) = given {
        return Ok(as_it_is(mapping));
    }
    let unknown = match choose(&recording.skeleton) {
        // A skeleton with the same names may have other parents.
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
        // Without any evidence for the unit, metres are assumed. If that gives a wrong height, the recording is
        // refused.
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
            "not sure of {body}: {reason}. Check the output of `sinew clip map`, and give it with --mapping if it is \
             right"
        ));
    }
    let mapping = Mapping::try_from(proposal.map)?;
    Ok(ChosenMapping { mapping: Cow::Owned(mapping), proposed })
}
