//! Options for facts that files do not contain: the unit of length, and the axis that points up.

use sinew_figure::measured::UnitOverrides;
use sinew_mocap::Up;
use sinew_rig::import::Options;

/// Facts that files do not contain.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub(super) struct UnitArgs {
    /// Unit of length of the file, in metres: 0.01 for centimetres. Default: the unit in the file, the unit of other
    /// files with the same known skeleton, or a guess by the body's height.
    #[arg(long, value_name = "M", value_parser = unit, allow_negative_numbers = true)]
    metres_per_unit: Option<f64>,

    /// Axis of the file that points up: x, y or z. Default: found from the file's format, or from the body's posture.
    #[arg(long, value_name = "AXIS")]
    up: Option<Up>,
}

impl UnitArgs {
    /// Returns the unit and axis for reading a clip.
    pub(super) const fn overrides(&self) -> UnitOverrides {
        UnitOverrides { metres_per_unit: self.metres_per_unit, up: self.up }
    }

    /// Returns the unit and axis for importing a rig.
    pub(super) fn import(&self) -> Options {
        Options {
            metres_per_unit: self.metres_per_unit,
            up: self.up.map(Up::axis),
            ..Options::default()
        }
    }

    /// Returns the name of an option that is given.
    pub(super) fn given(&self) -> Option<&'static str> {
        let unit = self.metres_per_unit.is_some().then_some("--metres-per-unit");
        unit.or(self.up.is_some().then_some("--up"))
    }
}

fn unit(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(metres) if (1e-6..=1e3).contains(&metres) => Ok(metres),
        _ => Err("expected a length in m from 1e-6 to 1000".into()),
    }
}
