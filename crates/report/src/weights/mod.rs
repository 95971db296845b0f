//! Draws the weights of a character's joints: on the figure, and as bars.

mod bars;
mod caption;
mod figure;

use std::io;
use std::path::Path;

use maud::{Markup, html};
use sinew_pose_metrics::character::Character;
use sinew_pose_metrics::weights::Weighing;

use super::chart::px;
use super::file;
use bars::Bars;
use figure::View;

/// Minimum height of a figure.
const FIGURE_HEIGHT: f64 = 330.0;

/// Height of the title and the line below it.
const TOP: f64 = 48.0;

/// Writes the picture as SVG or PNG, selected by the file's extension.
///
/// # Errors
/// The error of the operating system; [`io::ErrorKind::InvalidInput`] for a file with another extension.
pub fn write(path: &Path, character: &Character, weighings: &[Weighing]) -> io::Result<()> {
    file::write(path, &picture(character, weighings))
}

/// Draws a figure per method, below each other, beside the bars of all joints.
fn picture(character: &Character, weighings: &[Weighing]) -> Markup {
    let bars = Bars::new(character, weighings, FIGURE_HEIGHT * weighings.len() as f64);
    // The bars of a few joints are lower than the figures.
    let figures = weighings.len() as f64;
    let figure_height = (bars.height() / figures.max(1.0)).max(FIGURE_HEIGHT);
    let view = View::new(character, figure_height);
    let width = libm::ceil(view.width() + bars.width());
    let height = libm::ceil(TOP + bars.height().max(figure_height * figures));
    let title = format!("{}: weights of {} joints", character.name(), character.joints().len());
    let largest = weighings.iter().flat_map(|w| &w.weights).copied().fold(0.0, f64::max);
    html! {
        svg xmlns="http://www.w3.org/2000/svg" class="chart" role="img"
            viewBox={ "0 0 " (px(width)) " " (px(height)) } aria-label=(title) {
            text class="chart-title" x="10" y="20" { (title) }
            text class="fine muted" x="10" y="38" {
                "a disc's area is its joint's weight; bars on a logarithmic scale; weights sum to 1"
            }
            (view.definitions())
            @for (index, weighing) in weighings.iter().enumerate() {
                g transform={ "translate(0 " (px(TOP + figure_height * index as f64)) ")" } {
                    (view.draw(weighing, largest))
                }
            }
            g transform={ "translate(" (px(view.width())) " " (px(TOP)) ")" } { (bars.draw()) }
        }
    }
}

#[cfg(test)]
mod tests;
