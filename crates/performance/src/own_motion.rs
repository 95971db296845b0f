//! Reads motions of a rig's own joints from files.

use std::path::Path;

use anyhow::{Context as _, bail};
use sinew_mocap::read;
use sinew_retarget::exchange::keys::{self, KeyError, KeyedMotion};
use sinew_retarget::exchange::{HeaderUnits, blender, servos};

use super::rig::LoadedRig;

/// A kind of file with a motion of a rig's own joints. Such a motion needs no retargeting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OwnMotion {
    /// Positions of servos, in the format of the Blender servo animation add-on.
    ServoPositions,
    /// Joint coordinates: keys, or the recordings of `sinew record` and `sinew clip export`.
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

    /// Reads the motion. `units` are those of columns of coordinates whose header has none.
    ///
    /// # Errors
    /// The file cannot be read, or is not a motion of this rig.
    pub fn read(
        self,
        rig: &LoadedRig,
        path: &Path,
        units: Option<HeaderUnits>,
    ) -> anyhow::Result<KeyedMotion> {
        let motion = || -> anyhow::Result<KeyedMotion> {
            let text = read::text(path)?;
            match self {
                Self::ServoPositions => {
                    let (tracks, fps) = blender::read(&text, &rig.description)?;
                    let dt_s = fps.recip();
                    let motion = servos::motion(&rig.description, &rig.mechanism, &tracks, dt_s)?;
                    let given = (0..rig.mechanism.home().len()).collect();
                    let jumps = Vec::new();
                    Ok(KeyedMotion { motion, start_s: 0.0, keys: None, jumps, given })
                }
                Self::Coordinates => match keys::read(&rig.mechanism, &text, units) {
                    Err(why @ KeyError::NoUnit { .. }) => {
                        bail!("{why}, or give `--unit deg` or `--unit rad` for all such columns")
                    }
                    read => Ok(read?),
                },
            }
        };
        motion().with_context(|| path.display().to_string())
    }
}
