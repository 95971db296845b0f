//! The reason why a skeleton cannot be mapped onto the figure.

use crate::Landmark;

/// The reason why a skeleton cannot be mapped onto the figure.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FigureMappingError {
    /// Landmarks that the figure needs are missing, each with the reason.
    #[error("the figure of 18 bodies needs landmarks that the skeleton does not have: {}", list(.0))]
    Missing(Vec<(Landmark, String)>),
    /// Two joints have the same name. A map refers to joints by name, so names must be unique.
    #[error("two joints are called `{0}`: expected names that distinguish the joints of a map")]
    SameName(String),
}

fn list(missing: &[(Landmark, String)]) -> String {
    missing
        .iter()
        .map(|(landmark, reason)| format!("{} ({reason})", landmark.name()))
        .collect::<Vec<_>>()
        .join("; ")
}
