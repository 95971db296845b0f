//! Draws mannequins in space as SVG, for the report's still pictures. The page's script draws the animated ones.

mod camera;
#[cfg(test)]
pub(super) mod fixture;
mod ground;
mod human;
mod mannequin;
mod moving;
mod outline;
mod posed;
mod rig;
mod stage;

pub use camera::Camera;
pub use ground::Ground;
pub(super) use human::feet_m;
pub use human::{reach_m, side_view_rad};
pub(super) use mannequin::{MEASURED_GIRTH, Part};
pub use mannequin::{Mannequin, Points};
pub(super) use moving::gradients;
pub use posed::posed;
pub use stage::{STAGE_HEIGHT, STAGE_WIDTH, Stage, WHITE};
