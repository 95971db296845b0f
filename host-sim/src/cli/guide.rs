//! The path along which a scripted hand leads a rig.

use std::path::Path;

use anyhow::Context as _;
use sinew_performance::rig::LoadedRig;
use sinew_performance::teach::GuideTrajectory;
use sinew_retarget::exchange::keys;

/// Reads the path of a scripted hand from a file, or returns the built-in path.
pub(super) fn read_guide(rig: &LoadedRig, file: Option<&Path>) -> anyhow::Result<GuideTrajectory> {
    let Some(path) = file else { return Ok(GuideTrajectory::built_in(&rig.mechanism)?) };
    let of_file = || path.display().to_string();
    let text = sinew_mocap::read::text(path).with_context(of_file)?;
    let read = keys::read(&rig.mechanism, &text, None).with_context(of_file)?;
    Ok(GuideTrajectory::along(&rig.mechanism, &read.motion)?)
}
