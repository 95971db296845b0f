//! The 18-body figure of the paper: its bodies, how they move and what they weigh.

pub mod body;
pub mod builtin;
mod cut;
mod de_leva;
mod dimensions;
#[doc(hidden)]
pub mod fixture;
pub mod hanavan;
pub mod mapping;
pub mod measured;
pub mod model;
mod motion;
pub mod pipeline;
mod placement;
pub mod plant;
pub mod solids;

pub use body::{BODIES, BODY_COUNT, Body, Root, is_leaf};
pub use de_leva::mass_fraction as de_leva_mass_fraction;
pub use dimensions::Dimensions;
pub use hanavan::Subject;
pub use mapping::Mapping;
pub use model::{BodyModel, BodyModelError};
pub use motion::FigureMotion;
