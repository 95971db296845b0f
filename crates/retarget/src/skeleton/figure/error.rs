//! Why a skeleton has no map on the figure.

use crate::Landmark;

/// Why a skeleton cannot be mapped on the figure.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FigureMappingError {
    /// Landmarks that the figure needs are not there.
    #[error("the figure of 18 bodies needs landmarks that the skeleton does not have: {}", list(.0))]
    Missing(Vec<(Landmark, String)>),
    /// Maps name joints, so that the names must tell them apart.
    #[error("two joints are called `{0}`: expected names that tell the joints of a map apart")]
    SameName(String),
}

fn list(missing: &[(Landmark, String)]) -> String {
    missing
        .iter()
        .map(|(landmark, reason)| format!("{} ({reason})", landmark.name()))
        .collect::<Vec<_>>()
        .join("; ")
}
