//! Figures in space as SVG: the stills of the report. The page's script draws the same in motion.

mod camera;
mod mannequin;
mod moving;
mod outline;
mod posed;
mod stage;

pub(super) use camera::Camera;
pub(super) use mannequin::{
    MEASURED_GIRTH, Mannequin, PARTS, POINT_COUNT, Part, Points, TRUNK, reach_m, side_view_rad,
};
pub(super) use moving::gradients;
pub(super) use posed::posed;
pub(super) use stage::{STAGE_HEIGHT, STAGE_WIDTH, Stage, WHITE};
