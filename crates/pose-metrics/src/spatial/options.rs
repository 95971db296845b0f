//! Options that select the distance of poses.

use anyhow::ensure;

use crate::spatial::{Measure, Metric};

/// The selected distance of poses.
#[derive(Debug, Clone, clap::Args)]
pub struct MeasureArgs {
    /// Quantity that the distance compares.
    #[arg(long, value_enum, default_value_t = Metric::Line)]
    metric: Metric,

    /// Weight joints by importance: the total length of the bones that they move.
    #[arg(long)]
    weighted: bool,

    /// Number of steps of a line or a geodesic, 1 to 1000. Default: 10, as in the paper.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    steps: Option<u16>,

    /// Joint relative to which poses are compared. Default: the skeleton's root, or the first joint below it that
    /// moves.
    #[arg(long, value_name = "JOINT")]
    pub root: Option<String>,
}

impl MeasureArgs {
    /// Returns the selected distance.
    ///
    /// # Errors
    /// If steps are given for a metric that has none.
    pub fn measure(&self) -> anyhow::Result<Measure> {
        ensure!(
            self.steps.is_none() || self.metric.is_length_of_curve(),
            "--steps: expected only with the metrics line and geodesic"
        );
        let measure = Measure::new(self.metric);
        let measure = Measure { steps: self.steps.unwrap_or(measure.steps), ..measure };
        Ok(if self.weighted { measure.weighted() } else { measure })
    }
}
