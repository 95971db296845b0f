//! Maps values to positions on a chart, and finds round numbers for the labels.

/// An axis of a chart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Axis {
    /// Values at both ends.
    values: [f64; 2],
    /// Positions of both ends.
    places: [f64; 2],
    logarithmic: bool,
}

impl Axis {
    /// Creates an axis from zero to a round number above `largest`.
    pub(crate) fn from_zero(largest: f64, places: [f64; 2]) -> Self {
        let largest = if largest > 0.0 && largest.is_finite() { largest } else { 1.0 };
        let step = round_step(largest);
        let steps = libm::ceil(largest / step * (1.0 - 1e-9));
        Self { values: [0.0, steps * step], places, logarithmic: false }
    }

    /// Creates an axis from a round number below `low` to a round number above `high`. If `low` is at most half of
    /// `high`, the axis begins at zero.
    pub(crate) fn around([low, high]: [f64; 2], places: [f64; 2]) -> Self {
        if !(low > 0.5 * high && low < high) {
            return Self::from_zero(high, places);
        }
        let step = round_step(high - low);
        let values = [libm::floor(low / step + 1e-9) * step, libm::ceil(high / step - 1e-9) * step];
        Self { values, places, logarithmic: false }
    }

    /// Creates an axis with exactly these ends.
    pub(crate) fn exact(values: [f64; 2], places: [f64; 2]) -> Self {
        Self { values, places, logarithmic: false }
    }

    /// Creates a logarithmic axis between two positive values.
    pub(crate) fn logarithmic(values: [f64; 2], places: [f64; 2]) -> Self {
        Self { values, places, logarithmic: true }
    }

    /// Returns the position of a value, limited to the ends.
    pub(crate) fn at(&self, value: f64) -> f64 {
        let [low, high] = self.values.map(|value| self.straight(value));
        let share = if high > low { (self.straight(value) - low) / (high - low) } else { 0.0 };
        let [from, to] = self.places;
        from + share.clamp(0.0, 1.0) * (to - from)
    }

    fn straight(&self, value: f64) -> f64 {
        if self.logarithmic { libm::log10(value) } else { value }
    }

    /// Returns round values within the ends, with their labels.
    pub(crate) fn ticks(&self) -> Vec<(f64, String)> {
        let [low, high] = self.values;
        if self.logarithmic {
            return logarithmic_ticks(low, high);
        }
        let step = round_step(high - low);
        let decimals = decimals(step);
        let mut ticks = Vec::new();
        // Avoids a negative zero in the labels.
        let mut index = libm::ceil(low / step - 1e-9) + 0.0;
        while index * step <= high + 1e-9 * step {
            ticks.push((index * step, format!("{:.decimals$}", index * step)));
            index += 1.0;
        }
        ticks
    }
}

/// Returns the length of a step: 1, 2 or 5 times a power of ten, so that `length` contains two to five steps.
fn round_step(length: f64) -> f64 {
    let rough = length / 5.0;
    let power = libm::pow(10.0, libm::floor(libm::log10(rough)));
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= rough * 0.999);
    factor.unwrap_or(10.0) * power
}

fn decimals(step: f64) -> usize {
    [1.0, 0.1, 0.01, 0.001, 0.0001].iter().position(|unit| step >= unit * 0.999).unwrap_or(5)
}

/// Returns powers of ten. If `high / low` is below 1000, also returns 2 and 5 times each; if it is below 4, returns
/// equal steps.
fn logarithmic_ticks(low: f64, high: f64) -> Vec<(f64, String)> {
    if high / low < 4.0 {
        return Axis::exact([low, high], [0.0, 1.0]).ticks();
    }
    let factors: &[f64] = if high / low < 1e3 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let mut ticks = Vec::new();
    for decade in -6..=6 {
        for factor in factors {
            let value = factor * libm::pow(10.0, f64::from(decade));
            if value >= low * (1.0 - 1e-9) && value <= high * (1.0 + 1e-9) {
                let decimals = usize::try_from(-decade).unwrap_or(0);
                ticks.push((value, format!("{value:.decimals$}")));
            }
        }
    }
    ticks
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.ticks().into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round() {
        let places = [0.0, 100.0];
        assert_eq!(
            labels(&Axis::from_zero(0.9, places)),
            ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]
        );
        assert_eq!(labels(&Axis::from_zero(10.0, places)), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(labels(&Axis::from_zero(0.0, places)).last().unwrap(), "1.0");
        assert_eq!(
            labels(&Axis::around([2.47, 3.76], places)),
            ["2.0", "2.5", "3.0", "3.5", "4.0"]
        );
        assert_eq!(labels(&Axis::around([0.4, 0.9], places))[0], "0.0");
        assert_eq!(labels(&Axis::around([3.0, 3.0], places))[0], "0");
        assert_eq!(labels(&Axis::logarithmic([0.5, 6.0], places)), ["0.5", "1", "2", "5"]);
        assert_eq!(labels(&Axis::logarithmic([0.79, 1.12], places)), ["0.8", "0.9", "1.0", "1.1"]);
        assert_eq!(labels(&Axis::logarithmic([1e-3, 1e1], places)).len(), 5);
    }

    #[test]
    fn places_are_between_the_ends() {
        let axis = Axis::from_zero(10.0, [100.0, 0.0]);
        for (value, place) in [(0.0, 100.0), (2.5, 75.0), (99.0, 0.0)] {
            assert!((axis.at(value) - place).abs() < 1e-12, "{value}: {}", axis.at(value));
        }
        let axis = Axis::logarithmic([0.01, 100.0], [0.0, 40.0]);
        assert!((axis.at(1.0) - 20.0).abs() < 1e-12);
        assert!(axis.at(0.0).abs() < 1e-12, "zero is below every power of ten");
    }
}
