//! How a rig is controlled: the core's settings, with bodies by their names.

use serde::{Deserialize, Serialize};
use sinew_core::tracker::Settings;
use sinew_figure::BODIES;

/// How a rig is controlled.
pub type ControllerSettings = Settings<BodyName>;

/// A body of a rig, by its name. Default: the root, by the name that it has in the figure.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct BodyName(pub String);

impl Default for BodyName {
    fn default() -> Self {
        Self(BODIES[0].name.to_owned())
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the core computes in f32")]
pub(super) fn narrow(x: f64) -> f32 {
    x as f32
}
