//! Reads motions of a rig's own joints from files.

use std::path::Path;

use anyhow::{Context as _, bail};
use sinew_mocap::read;
use sinew_retarget::exchange::keys::{self, KeyError, KeyedMotion};
use sinew_retarget::exchange::{HeaderUnits, blender, servos};
use sinew_retarget::feasibility::RigMotion;
use sinew_show::{Rate, Show};

use super::bake::{ShowPlayback, rig_hash};
use super::rig::LoadedRig;

/// A kind of file with a motion of a rig's own joints. Such a motion needs no retargeting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OwnMotion {
    /// Positions of servos, in the format of the Blender servo animation add-on.
    ServoPositions,
    /// Joint coordinates: keys, or the recordings of `sinew record` and `sinew clip export`.
    Coordinates,
    /// A show of the rig.
    Show,
}

impl OwnMotion {
    /// Returns the kind of a file by its extension; `None` for a clip.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()? {
            "json" => Some(Self::ServoPositions),
            "csv" => Some(Self::Coordinates),
            "show" => Some(Self::Show),
            _ => None,
        }
    }

    /// Returns the name of the kind.
    pub fn name(self) -> &'static str {
        match self {
            Self::ServoPositions => "positions of servos",
            Self::Coordinates => "joint coordinates",
            Self::Show => "a show",
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
            match self {
                Self::ServoPositions => {
                    let text = read::text(path)?;
                    let (tracks, fps) = blender::read(&text, &rig.description)?;
                    let dt_s = fps.recip();
                    let motion = servos::motion(&rig.description, &rig.mechanism, &tracks, dt_s)?;
                    Ok(whole(motion, false))
                }
                Self::Coordinates => match keys::read(&rig.mechanism, &read::text(path)?, units) {
                    Err(why @ KeyError::NoUnit { .. }) => {
                        bail!("{why}, or give `--unit deg` or `--unit rad` for all such columns")
                    }
                    read => Ok(read?),
                },
                Self::Show => of_show(rig, &read::bytes(path)?),
            }
        };
        motion().with_context(|| path.display().to_string())
    }
}

/// Reads a show of a rig as its motion, with a row for each sample of the show.
fn of_show(rig: &LoadedRig, bytes: &[u8]) -> anyhow::Result<KeyedMotion> {
    let show = Show::open(bytes)?;
    let (here, _) = rig_hash(&rig.description, &rig.mechanism);
    if here != 0 && show.rig() != 0 {
        show.check_rig(here)?;
    }
    show.check_joints(rig.mechanism.bodies.iter().map(|link| link.joint.kind()))?;
    let Rate { samples, seconds } = show.rate();
    let motion = ShowPlayback::new(bytes)?.motion(f64::from(seconds) / f64::from(samples));
    Ok(whole(motion, show.is_loop()))
}

/// Returns a motion that moves all of the rig's coordinates.
fn whole(motion: RigMotion, is_loop: bool) -> KeyedMotion {
    KeyedMotion { motion, start_s: 0.0, keys: None, jumps: Vec::new(), given: None, is_loop }
}
