//! Errors of a subject's measurements.

use std::fmt;
use std::path::PathBuf;

use sinew_host_util::parse_message;

/// A subject file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SubjectError {
    /// A file that could not be read.
    #[error("{}: cannot be read: {source}", file.display())]
    Io {
        /// Path of the file.
        file: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A key that is missing or unknown, or that has an invalid value.
    #[error("{}: {}", file.display(), parse_message(source))]
    Toml {
        /// Path of the file.
        file: PathBuf,
        /// Line, column and expectation, from the TOML parser.
        source: Box<toml::de::Error>,
    },
    /// Values that contradict one another.
    #[error("{}: {source}", file.display())]
    Inputs {
        /// Path of the file.
        file: PathBuf,
        /// Error with the contradictory values.
        source: InputError,
    },
}

/// Inputs that are impossible in combination.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InputError {
    /// A girth too small for a breadth: a semi-axis of the section would not be positive.
    #[error(
        "the {segment}: {girths} cannot go round {breadths}: expected a circumference{} above {least_m:.3}",
        if girths.0.len() > 1 { " (in the mean)" } else { "" }
    )]
    Girth {
        /// Name of the segment.
        segment: &'static str,
        /// Circumferences whose mean is the girth.
        girths: Values,
        /// Breadths whose mean the girth must enclose.
        breadths: Values,
        /// Lower bound of the mean circumference, in metres.
        least_m: f64,
    },
    /// A regression whose mass is not positive.
    #[error(
        "the {segment} would weigh {mass_kg:.3} kg by the regression on {values}: expected values of an adult, \
         which give a mass above 0"
    )]
    Mass {
        /// Name of the segment.
        segment: &'static str,
        /// Mass by the regression, in kg.
        mass_kg: f64,
        /// Inputs of the regression.
        values: Values,
    },
    /// A mass and a volume that give an impossible density.
    #[error(
        "the {segment} would have a density of {density_kg_m3:.0} kg/m³ ({mass_kg:.3} kg in {:.3} litres) by \
         {values}: expected 850 to 1250; is one of them in another unit (metres are expected), or wrong?",
        1e3 * volume_m3
    )]
    Density {
        /// Name of the segment.
        segment: &'static str,
        /// Density of the segment.
        density_kg_m3: f64,
        /// Mass of the segment by the regression.
        mass_kg: f64,
        /// Volume of the segment.
        volume_m3: f64,
        /// Inputs of mass and volume.
        values: Values,
    },
    /// Masses by regression whose sum differs too much from the subject's mass.
    #[error(
        "the segments' masses sum to {sum_kg:.3} kg, {:+.1} % from mass_kg = {mass_kg}: expected at most 10 %; \
         is mass_kg in kilograms, and are all values of one subject?",
        100.0 * (sum_kg / mass_kg - 1.0)
    )]
    Sum {
        /// Sum of the masses in kg.
        sum_kg: f64,
        /// Given total mass in kg.
        mass_kg: f64,
    },
}

/// Inputs with their keys.
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

/// Collects inputs with their keys: `values!(inputs; chest_breadth_m, hip_breadth_m)`.
macro_rules! values {
    ($inputs:expr; $($key:ident),+) => {
        $crate::hanavan::error::Values(vec![$((stringify!($key), $inputs.$key.get())),+])
    };
}
pub(super) use values;
