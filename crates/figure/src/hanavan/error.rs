//! What is wrong with a subject.

use std::fmt;
use std::path::PathBuf;

use sinew_host_util::parse_message;

/// A subject file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SubjectError {
    /// The file system refused.
    #[error("{}: cannot be read: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A key is missing, unknown, or has a value that cannot be.
    #[error("{}: {}", file.display(), parse_message(source))]
    Toml {
        /// The file.
        file: PathBuf,
        /// Line, column and what was expected.
        source: Box<toml::de::Error>,
    },
    /// The values do not go together.
    #[error("{}: {source}", file.display())]
    Inputs {
        /// The file.
        file: PathBuf,
        /// The values.
        source: InputError,
    },
}

/// Inputs that no body can have together.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InputError {
    /// A girth too small to go round a breadth: a semi-axis of the section would not be positive.
    #[error(
        "the {segment}: {girths} cannot go round {breadths}: expected a circumference{} above {least_m:.3}",
        if girths.0.len() > 1 { " (in the mean)" } else { "" }
    )]
    Girth {
        /// The segment.
        segment: &'static str,
        /// The circumferences whose mean it is.
        girths: Values,
        /// The breadths whose mean it is to go round.
        breadths: Values,
        /// What the mean circumference must exceed, in metres.
        least_m: f64,
    },
    /// A regression gives no mass.
    #[error(
        "the {segment} would weigh {mass_kg:.3} kg by the regression on {values}: expected values of an adult, \
         which give a mass above 0"
    )]
    Mass {
        /// The segment.
        segment: &'static str,
        /// The mass in kg.
        mass_kg: f64,
        /// What it is computed from.
        values: Values,
    },
    /// Mass and volume do not go together.
    #[error(
        "the {segment} would have a density of {density_kg_m3:.0} kg/m³ ({mass_kg:.3} kg in {:.3} litres) by \
         {values}: expected 850 to 1250; is one of them in another unit (metres are expected), or wrong?",
        1e3 * volume_m3
    )]
    Density {
        /// The segment.
        segment: &'static str,
        /// Its density.
        density_kg_m3: f64,
        /// Its mass by the regression.
        mass_kg: f64,
        /// Its volume.
        volume_m3: f64,
        /// What they are computed from.
        values: Values,
    },
    /// The regressions are for another body.
    #[error(
        "the segments' masses sum to {sum_kg:.3} kg, {:+.1} % from mass_kg = {mass_kg}: expected at most 10 %; \
         is mass_kg in kilograms, and are all values of one subject?",
        100.0 * (sum_kg / mass_kg - 1.0)
    )]
    Sum {
        /// The sum in kg.
        sum_kg: f64,
        /// The given total in kg.
        mass_kg: f64,
    },
}

/// Inputs by their keys.
#[derive(Debug, Clone, PartialEq)]
pub struct Values(pub Vec<(&'static str, f64)>);

impl Values {
    pub(super) fn mean(&self) -> f64 {
        self.0.iter().map(|(_, value)| value).sum::<f64>() / self.0.len() as f64
    }
}

impl fmt::Display for Values {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, (key, value)) in self.0.iter().enumerate() {
            let before = match index {
                0 => "",
                _ if index + 1 == self.0.len() => " and ",
                _ => ", ",
            };
            write!(f, "{before}{key} = {value}")?;
        }
        Ok(())
    }
}

/// Inputs by their keys: `values!(inputs; chest_breadth_m, hip_breadth_m)`.
macro_rules! values {
    ($inputs:expr; $($key:ident),+) => {
        $crate::hanavan::error::Values(vec![$((stringify!($key), $inputs.$key.get())),+])
    };
}
pub(super) use values;
