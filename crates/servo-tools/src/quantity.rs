//! Register values in units for people: degrees, per cent, milliseconds.

use std::fmt;

use sinew_servo_bus::table::Item;

/// A register value: in a unit for people, and in counts.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Quantity {
    /// Value in [`Self::unit`], rounded to the resolution of one count.
    pub value: f64,
    /// Unit: deg, deg/s, deg/s2, A, V, degC, %, ms, us, or empty for a plain number.
    pub unit: &'static str,
    /// Value in counts of the servo.
    pub raw: i32,
    #[serde(skip)]
    decimals: usize,
}

/// The display unit of a register, and the size of one count in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Name of the unit, as in [`Quantity::unit`].
    pub unit: &'static str,
    /// Size of one count in this unit.
    pub step: f64,
}

impl Scale {
    /// Returns the scale of a register.
    pub fn of(item: &Item) -> Self {
        let (symbol, count) = (item.unit.symbol, f64::from(item.unit.scale));
        let (unit, factor) = match symbol {
            "rad" => ("deg", 1.0_f64.to_degrees()),
            "rad/s" => ("deg/s", 1.0_f64.to_degrees()),
            "rad/s2" => ("deg/s2", 1.0_f64.to_degrees()),
            "1" => ("%", 100.0),
            "s" if count < 1e-4 => ("us", 1e6),
            "s" => ("ms", 1e3),
            other => (other, 1.0),
        };
        Self { unit, step: count * factor }
    }

    /// Returns the number of decimals that one count can resolve.
    fn decimals(self) -> usize {
        // Scales are f32: 0.01 is a little less than that.
        let mut decimals = 0;
        let mut step = self.step * (1.0 + 1e-6);
        while step < 1.0 && decimals < 9 {
            step *= 10.0;
            decimals += 1;
        }
        decimals
    }

    /// Converts counts to a quantity.
    pub fn quantity(self, raw: i32) -> Quantity {
        let decimals = self.decimals();
        let ten: f64 = (0..decimals).map(|_| 10.0).product();
        let value = (f64::from(raw) * self.step * ten).round() / ten;
        Quantity { value, unit: self.unit, raw, decimals }
    }

    /// Returns the counts nearest to a value, or `None` if no register can hold them.
    pub fn raw(self, value: f64) -> Option<i32> {
        let counts = (value / self.step).round();
        #[expect(clippy::cast_possible_truncation, reason = "it was compared with the ends")]
        (counts.abs() <= f64::from(i32::MAX)).then_some(counts as i32)
    }
}

/// Converts the counts of a register to a quantity.
pub fn quantity(item: &Item, raw: i32) -> Quantity {
    Scale::of(item).quantity(raw)
}

impl fmt::Display for Quantity {
    /// Writes the value with its unit, without the counts.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.*}", self.decimals, self.value)?;
        if self.unit.is_empty() { Ok(()) } else { write!(f, " {}", self.unit) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Table;

    #[test]
    fn registers_are_shown_in_units_of_people() {
        let table = Table::named_model("XL330-M288", 52).unwrap();
        let shown = |name: &str, raw| quantity(&table.named(name).unwrap(), raw).to_string();
        assert_eq!(shown("Goal Position", 2048), "180.00 deg");
        assert_eq!(shown("Goal Position", -1), "-0.09 deg");
        assert_eq!(shown("Velocity Limit", 100), "137 deg/s");
        assert_eq!(shown("PWM Limit", 885), "100.0 %");
        assert_eq!(shown("Current Limit", 1750), "1.750 A");
        assert_eq!(shown("Present Input Voltage", 50), "5.0 V");
        assert_eq!(shown("Return Delay Time", 250), "500 us");
        assert_eq!(shown("Bus Watchdog", 5), "100 ms");
        assert_eq!(shown("Operating Mode", 3), "3");
        let table = Table::named_model("STS3215", 0).unwrap();
        let shown = |name: &str, raw| quantity(&table.named(name).unwrap(), raw).to_string();
        assert_eq!(shown("Protective Torque", 20), "20 %");
        assert_eq!(shown("Torque Limit", 1000), "100.0 %");
    }

    #[test]
    fn what_is_shown_leads_back_to_the_same_count() {
        for model in ["XL330-M288", "XM540-W270", "STS3215", "SCS0009"] {
            for item in Table::named_model(model, 52).unwrap().items() {
                let scale = Scale::of(&item);
                for raw in [0, 1, 2, 7, 100, 885, 1023, 2047, 4095, -3] {
                    assert_eq!(
                        scale.raw(scale.quantity(raw).value),
                        Some(raw),
                        "{model} {}",
                        item.name
                    );
                }
            }
        }
        assert_eq!(Scale { unit: "", step: 1.0 }.raw(1e300), None);
        assert_eq!(Scale { unit: "", step: 1.0 }.raw(f64::NAN), None);
    }
}
