//! Charts as SVG. Colours are CSS classes of `assets/chart.css`: one picture can be used on a light page, on a
//! dark page, and as a file of its own.

mod axis;
mod course;
mod distribution;
mod frame;
mod groups;
mod heat_map;
mod histogram;
mod intervals;
mod joints;
mod legend;
mod pareto;
mod path;
mod plane;
mod quantity;
mod ratios;
mod strips;

pub(super) use axis::Axis;
pub(super) use course::{Statistic, course};
pub(super) use distribution::distribution;
pub(super) use frame::WIDTH;
pub use groups::{Kinds, groups};
pub use heat_map::heat_map;
pub use histogram::{Histograms, Panel};
pub use intervals::{Interval, Row, intervals};
pub(super) use joints::{ROW, joints, room};
pub(super) use legend::{legend, legend_lines};
pub(super) use pareto::{Joined, ParetoChart, Reference, Spot};
pub(super) use path::line;
pub use path::px;
pub use plane::{Plane, planes};
pub(super) use quantity::Quantity;
pub(super) use ratios::{Ratio, ratios};
pub use strips::{Pair, strips};
