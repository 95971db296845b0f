//! Reports: an evaluation as one HTML page that needs only a browser, and its pictures as files.
//!
//! - `page` and `tables` write the page of an evaluation; [`chart`] and [`scene`] draw; script and style are in
//!   `assets/`.
//! - [`rig`], [`feasibility`] and [`recording`] are pages of a rig that the reader can move, of the demands of a
//!   show on it, and of how the show was played. `traces` packs the data over time.
//! - [`weights`], [`moments`] and [`blend`] draw joints' weights, found poses, and the transition between two
//!   clips.
//! - `comparison` is the paper's Figure 4; `text` contains the wording for the figure and for other rigs.

mod animation;
pub mod blend;
pub mod chart;
mod comparison;
pub mod feasibility;
pub mod file;
mod head;
mod joint_table;
mod labels;
pub mod moments;
mod page;
mod palette;
mod pareto;
mod pictures;
mod playback;
mod png;
pub mod recording;
mod report;
mod results;
pub mod rig;
pub mod scene;
mod still;
mod sweep;
mod tables;
mod text;
mod traces;
mod view;
pub mod weights;

pub use comparison::Comparison;
pub use playback::Playback;
pub use report::Report;
pub use sweep::{Grid, Sweep, SweepError};

#[cfg(test)]
mod tests;
