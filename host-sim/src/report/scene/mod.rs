//! Figures in space as SVG: the stills of the report. The page's script draws the same in motion.

mod camera;
mod mannequin;
mod moving;
mod outline;
mod posed;
mod stage;

pub use camera::Camera;
pub(super) use mannequin::{MEASURED_GIRTH, PARTS, Part, TRUNK};
pub use mannequin::{Mannequin, POINT_COUNT, Points, reach_m, side_view_rad};
pub(super) use moving::gradients;
pub use posed::posed;
pub use stage::{STAGE_HEIGHT, STAGE_WIDTH, Stage, WHITE};
