//! Reads motions of a rig's own joints from files.

use std::path::Path;

use anyhow::Context as _;
use sinew_mocap::read;
use sinew_retarget::exchange::{blender, servos, table};
use sinew_retarget::feasibility::RigMotion;

use super::rig::LoadedRig;

/// A kind of file with a motion of a rig's own joints. Such a motion needs no retargeting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OwnMotion {
    /// Positions of servos, in the format of the Blender servo animation add-on.
    ServoPositions,
    /// Joint coordinates, in the format of `sinew record` and `sinew clip export`.
    Coordinates,
}

impl OwnMotion {
    /// Returns the kind of a file by its extension; `None` for a clip.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()? {
            "json" => Some(Self::ServoPositions),
            "csv" => Some(Self::Coordinates),
            _ => None,
        }
    }

    /// Returns the name of the kind.
    pub fn name(self) -> &'static str {
        match self {
            Self::ServoPositions => "positions of servos",
            Self::Coordinates => "joint coordinates",
        }
    }

    /// Reads the motion and its start time, s.
    ///
    /// # Errors
    /// The file is not a motion of this rig.
    pub fn read(self, rig: &LoadedRig, path: &Path) -> anyhow::Result<(RigMotion, f64)> {
        let motion = || -> anyhow::Result<(RigMotion, f64)> {
            let text = read::text(path)?;
            match self {
                Self::ServoPositions => {
                    let (tracks, fps) = blender::read(&text, &rig.description)?;
                    let dt_s = fps.recip();
                    let motion = servos::motion(&rig.description, &rig.mechanism, &tracks, dt_s)?;
                    Ok((motion, 0.0))
                }
                Self::Coordinates => Ok(table::read(&rig.mechanism, &text)?),
            }
        };
        motion().with_context(|| path.display().to_string())
    }
}
