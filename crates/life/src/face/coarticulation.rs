//! Weights of visemes over time: each mouth shape is influenced by its neighbours.
//!
//! The rule follows Cohen and Massaro (1993). Each mouth shape has a dominance that falls with the distance in time,
//! and each weight is a share of the sum of dominances. Lips that close have a high dominance; otherwise they would
//! stay open.

use super::RATE_HZ;
use super::error::FaceError;
use super::names::{MouthSet, VISEMES, is_same};
use super::track::{Cue, Weights};

/// Distance in time at which a dominance has fallen to 1/e, s; and the maximum of this distance as a share of the mouth
/// shape's duration.
const REACH_S: f64 = 0.06;
const REACH_SHARE: f64 = 0.35;
/// Dominance of lips that close or touch the teeth, and of silence. All other mouth shapes have dominance 1.
const CLOSED: f64 = 4.0;
const SILENCE: f64 = 0.7;

impl Weights {
    /// Returns weights of visemes for mouth cues. `shapes`: names of the rig's shapes. A shape with the name of the cue
    /// has priority over the shape of the cue's viseme. `end_s`: end of the last cue.
    ///
    /// # Errors
    /// [`FaceError`] if a mouth is unknown, or the rig has no shape for it.
    pub fn of_cues(cues: &[Cue], end_s: f64, shapes: &[&str]) -> Result<Self, FaceError> {
        let set = MouthSet::of(cues.iter().map(|cue| cue.mouth.as_str()));
        let mut names: Vec<String> = Vec::new();
        let mut segments: Vec<Segment> = Vec::new();
        for (index, cue) in cues.iter().enumerate() {
            let (name, dominance) = shape(cue, set, shapes)?;
            let shape = names.iter().position(|known| *known == name).unwrap_or(names.len());
            if shape == names.len() {
                names.push(name);
            }
            let end = cues.get(index + 1).map_or(end_s, |next| next.start_s);
            segments.push(Segment { span_s: [cue.start_s, end], shape, dominance });
        }
        // A cue without a duration is not visible.
        segments.retain(|segment| segment.span_s[1] > segment.span_s[0]);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below 7200 s")]
        let last = (end_s * RATE_HZ).ceil() as usize;
        let times_s: Vec<f64> = (0..=last).map(|row| row as f64 / RATE_HZ).collect();
        let rows = times_s.iter().map(|time_s| weights(&segments, *time_s, names.len())).collect();
        Self { names, times_s, rows }.checked()
    }
}

/// A mouth shape that is visible for some time.
struct Segment {
    span_s: [f64; 2],
    shape: usize,
    dominance: f64,
}

/// Returns the name of the rig's shape for a cue, and its dominance.
fn shape(cue: &Cue, set: MouthSet, shapes: &[&str]) -> Result<(String, f64), FaceError> {
    let viseme = set.viseme(&cue.mouth);
    let dominance = match viseme {
        Some("PP" | "FF") => CLOSED,
        Some("sil") => SILENCE,
        _ => 1.0,
    };
    // A letter may be the name of another viseme: `E` of Rhubarb is not the viseme `E`.
    let is_other = |name: &str| VISEMES.contains(&name) && viseme != Some(name);
    let own = shapes.iter().find(|name| **name == cue.mouth && !is_other(name));
    let of_viseme = || viseme.and_then(|viseme| shapes.iter().find(|name| is_same(name, viseme)));
    let place = || cue.place.clone();
    match (own.or_else(of_viseme), viseme) {
        (Some(name), _) => Ok(((*name).to_owned(), dominance)),
        (None, Some(viseme)) => {
            Err(FaceError::NoViseme { place: place(), viseme, cue: cue.mouth.clone() })
        }
        (None, None) => Err(FaceError::Value {
            place: place(),
            item: "the mouth".to_owned(),
            expected: format!("one of {}", set.names()),
            found: cue.mouth.clone(),
        }),
    }
}

/// Returns the weights at a time: the shares of the present mouth shape and of its two neighbours.
fn weights(segments: &[Segment], time_s: f64, shapes: usize) -> Vec<f64> {
    let mut weights = vec![0.0; shapes];
    let next = segments.partition_point(|segment| segment.span_s[0] <= time_s);
    let at = next.saturating_sub(1);
    let Some(own) = segments.get(at) else { return weights };
    let [start_s, end_s] = own.span_s;
    let reach_s = REACH_S.min(REACH_SHARE * (end_s - start_s));
    let fallen = |away_s: f64| {
        let share = away_s.max(0.0) / reach_s;
        libm::exp(-share * share)
    };
    let mut add = |index: Option<usize>, share: f64| {
        let Some(segment) = index.and_then(|index| segments.get(index)) else { return 0.0 };
        weights[segment.shape] += segment.dominance * share;
        segment.dominance * share
    };
    let sum = add(Some(at), 1.0)
        + add(at.checked_sub(1), fallen(time_s - start_s))
        + add(at.checked_add(1), fallen(end_s - time_s));
    for weight in &mut weights {
        *weight /= sum;
    }
    weights
}
