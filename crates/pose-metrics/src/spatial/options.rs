//! Options that say which distance of poses is meant.

use anyhow::ensure;

use crate::spatial::{Measure, Metric};

/// Which distance of poses is meant.
#[derive(Debug, Clone, clap::Args)]
pub struct MeasureArgs {
    /// What of two poses is compared.
    #[arg(long, value_enum, default_value_t = Metric::Line)]
    metric: Metric,

    /// Weigh joints by their importance: the length of all bones that hang on them.
    #[arg(long)]
    weighted: bool,

    /// Steps of a line or a geodesic. Default: 10, as in the paper.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    steps: Option<u16>,

    /// Joint that poses are seen from. Default: the skeleton's root, or the first joint below it that moves.
    #[arg(long, value_name = "JOINT")]
    pub root: Option<String>,
}

impl MeasureArgs {
    /// The distance.
    ///
    /// # Errors
    /// If steps are given for a metric that has none.
    pub fn measure(&self) -> anyhow::Result<Measure> {
        ensure!(
            self.steps.is_none() || self.metric.is_length_of_curve(),
            "--steps: expected with the metrics line and geodesic, which alone have steps"
        );
        let measure = Measure::new(self.metric);
        let measure = Measure { steps: self.steps.unwrap_or(measure.steps), ..measure };
        Ok(if self.weighted { measure.weighted() } else { measure })
    }
}
