//! Controller settings: the core's settings, with bodies by name.

use serde::{Deserialize, Serialize};
use sinew_core::tracker::Settings;
use sinew_figure::BODIES;

/// Settings of the controller of a rig, with bodies by name.
pub type ControllerSettings = Settings<BodyName>;

/// Name of a body of a rig. Default: the root, by its name in the figure.
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
