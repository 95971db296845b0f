//! Mannequins in space as SVG: the stills of the report. The page's script draws the same in motion.

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
