//! Facts about motions.

use std::path::Path;

use glam::DVec3;

use sinew_figure::measured::{self, MappingSource, Measured, UnitOverrides};
use sinew_figure::pipeline::tpose;
use sinew_figure::{limb_landmark, mapping};
use sinew_mocap::damage::{check_bones, take_out_jumps};
use sinew_mocap::{Recording, flips, format, gaps};
use sinew_retarget::skeleton::SkeletonMatch;

use super::inspected::{Common, Inspected, Kind};
use super::maker;

/// The longest plausible bone, m: as long as the tallest figure.
const BONE_MAX_M: f64 = 3.0;
/// The longest gap that other commands fill, s.
const GAP_MAX_S: f64 = 0.5;

pub(super) fn motion(path: &Path, units: UnitOverrides) -> Result<Inspected, String> {
    let recording = format::read(path).map_err(|error| error.to_string())?;
    let matched = SkeletonMatch::of_recording(&recording);
    let known = mapping::choose(&recording.skeleton).ok();
    let by = known.map(|mapping| MappingSource { mapping, is_given: false });
    let measured = Measured::new(&recording, &matched, by, units);
    let common = Common {
        kind: Kind::Motion,
        format: format::name(path, &recording),
        maker: maker::by_text(path),
        skeleton: &recording.skeleton,
        measured: &measured,
        matched: &matched,
        extents: measured::extents(&recording, measured.up.axis),
    };
    let mut inspected = common.inspected();
    inspected.frames = Some(recording.frames.len());
    let known_s = known.and_then(|known| known.rate_hz).map(f64::recip);
    inspected.rate_hz = recording.frame_time_s.map(f64::recip);
    inspected.gaps = recording.frames.iter().flatten().filter(|sample| sample.is_none()).count();
    inspected.notes.extend(recording.notes.iter().cloned());
    if let Ok(recording) = measured.apply(recording) {
        in_metres(&mut inspected, recording, &matched, known_s);
    }
    Ok(inspected)
}

/// Adds the facts that need metres and y up: T-poses, bones, jumps, flips.
fn in_metres(
    inspected: &mut Inspected,
    mut recording: Recording,
    matched: &SkeletonMatch,
    known_s: Option<f64>,
) {
    let joint = |body: &str| matched.joint(limb_landmark(body)?);
    let rest_m = recording.skeleton.rest_positions_m();
    let at = |body: &str| joint(body).map_or(DVec3::NAN, |joint| rest_m[joint]);
    inspected.t_pose = if tpose::is_inserted(&recording, joint) {
        Some("frame 0, put before the recording")
    } else if tpose::is_t(at) {
        Some("at rest")
    } else {
        None
    };
    if let Err(long) = check_bones(&recording, BONE_MAX_M) {
        inspected.notes.push(format!("warning: {long}"));
    }
    let Some(frame_time_s) = recording.frame_time_s.or(known_s) else { return };
    let jumps = take_out_jumps(&mut recording, frame_time_s);
    if !jumps.is_empty() {
        inspected.notes.push(jumps.to_string());
    }
    match gaps::fill(recording, frame_time_s, GAP_MAX_S) {
        Ok((clip, _)) => {
            let found = flips::find(&clip, &vec![true; clip.skeleton.joints.len()]);
            inspected.flips = (!found.0.is_empty()).then(|| found.to_string());
        }
        Err(gap) => inspected.notes.push(gap.to_string()),
    }
}
