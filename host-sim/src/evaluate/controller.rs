//! How the figure is controlled: the core's settings, with bodies by their names.

use serde::{Deserialize, Serialize};
use sinew_core::tracker::Settings;

use crate::figure::BODIES;

/// How the figure is controlled.
pub type ControllerSettings = Settings<BodyName>;

/// A body of the figure, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(try_from = "String", into = "&'static str")]
pub struct BodyName(pub usize);

impl TryFrom<String> for BodyName {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        BODIES.iter().position(|body| body.name == name).map(Self).ok_or_else(|| {
            let names: Vec<_> = BODIES.iter().map(|body| body.name).collect();
            format!("expected a body of the figure ({}), found `{name}`", names.join(", "))
        })
    }
}

impl From<BodyName> for &'static str {
    fn from(BodyName(body): BodyName) -> Self {
        BODIES[body].name
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the core computes in f32")]
pub(super) fn narrow(x: f64) -> f32 {
    x as f32
}
