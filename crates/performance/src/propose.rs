//! Proposes a mapping of a clip's joints to a rig's joints.

use anyhow::Context as _;
use sinew_retarget::Landmark;
use sinew_retarget::mapping::Mapping;
use sinew_retarget::performer::Performer;
use sinew_retarget::rig::RigMatch;
use sinew_retarget::solve::{Settings, best_tilt};

use super::clip::PreparedClip;
use super::rig::LoadedRig;

/// Proposes a mapping of a clip to a rig, with the confidence and the reason of each pair. Also returns the rig's
/// limbs, and the joints that belong to no limb.
///
/// # Errors
/// No arm, leg or head was found in the rig.
pub fn propose_mapping(
    rig: &LoadedRig,
    clip: &PreparedClip,
) -> anyhow::Result<(Mapping, RigMatch)> {
    let mechanism = &rig.mechanism;
    let of_rig = RigMatch::of(mechanism).with_context(|| rig.description.name.clone())?;
    let joints = clip.joints();
    let names = [rig.description.name.as_str(), clip.clip.name.as_str()];
    let of_clip = |landmark: Landmark| {
        let found = clip.matched.get(landmark);
        found.map_or((0.0, "nothing".to_owned()), |found| (found.confidence, found.reason.clone()))
    };
    let skeleton = &clip.clip.skeleton;
    let mut mapping = Mapping::propose(names, mechanism, &of_rig, skeleton, &joints, of_clip);
    if let Ok(performer) = Performer::of(&clip.clip, &joints) {
        mapping.performance.tilt_rad =
            best_tilt(mechanism, &of_rig, &clip.clip, &performer, &Settings::of(&of_rig));
    }
    Ok((mapping, of_rig))
}
