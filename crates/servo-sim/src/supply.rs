//! A common supply of several servos.

use std::str::FromStr;

use thiserror::Error;

use crate::model::Draw;

/// The error that a supply's text is invalid.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "expected `V`, `V,OHM` or `V,OHM,A`, such as 5,0.2,3: V 1 to 60, OHM 0.001 to 100, A 0.1 to 1000"
)]
pub struct SupplyTextError;

/// A supply with a cable, a current limit and a capacitor at the servos.
#[derive(Debug, Clone, PartialEq)]
pub struct Supply {
    /// Voltage without load, V.
    pub open_v: f64,
    /// Resistance of supply and cable, ohm: more than 0.
    pub resistance_ohm: f64,
    /// Maximum current, A; infinite for no limit. The supply accepts no returned current.
    pub limit_a: f64,
    /// Capacitance at the servos, F.
    pub capacitance_f: f64,
    voltage_v: f64,
    current_a: f64,
}

impl Supply {
    /// Creates a supply that has been on for a long time.
    pub fn new(open_v: f64, resistance_ohm: f64, limit_a: f64, capacitance_f: f64) -> Self {
        Self { open_v, resistance_ohm, limit_a, capacitance_f, voltage_v: open_v, current_a: 0.0 }
    }

    /// Creates a supply whose voltage hardly sags: 1 mohm, 10 mF.
    pub fn stiff(open_v: f64) -> Self {
        Self::new(open_v, 1e-3, f64::INFINITY, 1e-2)
    }

    /// Creates a supply whose voltage hardly sags up to its maximum current, A.
    pub fn limited(open_v: f64, limit_a: f64) -> Self {
        Self { limit_a, ..Self::stiff(open_v) }
    }

    /// Returns the voltage at the servos, V.
    pub fn voltage_v(&self) -> f64 {
        self.voltage_v
    }

    /// Returns the current of the supply, A.
    pub fn current_a(&self) -> f64 {
        self.current_a
    }

    /// Advances by `dt_s` with the total load of all servos. Uses implicit Euler, which is stable for any resistance.
    pub fn step(&mut self, dt_s: f64, draw: Draw) {
        let charge = self.capacitance_f / dt_s;
        // First-order estimate of the servos' current at another voltage.
        let fixed_a = draw.current_a - draw.conductance_a_v * self.voltage_v;
        let settled = |source_a: f64, source_a_v: f64| {
            (charge * self.voltage_v + source_a - fixed_a)
                / (charge + source_a_v + draw.conductance_a_v)
        };
        let voltage = settled(self.open_v / self.resistance_ohm, 1.0 / self.resistance_ohm);
        let current = (self.open_v - voltage) / self.resistance_ohm;
        if (0.0..=self.limit_a).contains(&current) {
            (self.voltage_v, self.current_a) = (voltage, current);
        } else {
            self.current_a = current.clamp(0.0, self.limit_a);
            self.voltage_v = settled(self.current_a, 0.0).max(0.0);
        }
    }
}

/// Parses `V`, `V,OHM` or `V,OHM,A`, with 1 mF at the servos: a typical capacitor of controllers.
impl FromStr for Supply {
    type Err = SupplyTextError;

    fn from_str(text: &str) -> Result<Self, SupplyTextError> {
        let number = |text: &str, [least, most]: [f64; 2]| {
            let number: f64 = text.trim().parse().map_err(|_| SupplyTextError)?;
            // NaN is refused, because it is not in the range.
            if (least..=most).contains(&number) { Ok(number) } else { Err(SupplyTextError) }
        };
        let parts: Vec<&str> = text.split(',').collect();
        let (volts, ohms, amps) = match parts[..] {
            [volts] => (volts, None, None),
            [volts, ohms] => (volts, Some(ohms), None),
            [volts, ohms, amps] => (volts, Some(ohms), Some(amps)),
            _ => return Err(SupplyTextError),
        };
        Ok(Self::new(
            number(volts, [1.0, 60.0])?,
            ohms.map_or(Ok(1e-3), |ohms| number(ohms, [1e-3, 100.0]))?,
            amps.map_or(Ok(f64::INFINITY), |amps| number(amps, [0.1, 1000.0]))?,
            1e-3,
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_sags_by_its_resistance_and_folds_at_its_limit() {
        let mut supply = Supply::new(5.0, 0.2, 10.0, 1e-3);
        for _ in 0..1_000 {
            supply.step(2.5e-4, Draw { current_a: 4.0, conductance_a_v: 0.0 });
        }
        assert!((supply.voltage_v() - 4.2).abs() < 1e-9);
        // Twenty resistors of 4 ohm: 5 V / (0.2 + 0.2 ohm) would be 12.5 A; limited to 10 A, they have 2 V.
        for _ in 0..1_000 {
            let voltage = supply.voltage_v();
            supply.step(2.5e-4, Draw { current_a: voltage * 5.0, conductance_a_v: 5.0 });
        }
        assert!((supply.voltage_v() - 2.0).abs() < 1e-6, "{}", supply.voltage_v());
        assert!((supply.current_a() - 10.0).abs() < 1e-6);
    }

    #[test]
    fn it_takes_nothing_back() {
        let mut supply = Supply::new(5.0, 0.2, 10.0, 1e-3);
        supply.step(2.5e-4, Draw { current_a: -1.0, conductance_a_v: 0.0 });
        assert!(supply.voltage_v() > 5.0 && supply.current_a() == 0.0);
    }

    #[test]
    fn its_text_is_volts_ohms_and_amperes() {
        let supply: Supply = "7.4, 0.2,10".parse().unwrap();
        assert_eq!(supply, Supply::new(7.4, 0.2, 10.0, 1e-3));
        assert_eq!("12".parse(), Ok(Supply::new(12.0, 1e-3, f64::INFINITY, 1e-3)));
        for wrong in ["", "5,", "nan", "5,0", "5,0.1,inf", "0.5", "5,0.1,3,4", "5 V"] {
            assert_eq!(wrong.parse::<Supply>(), Err(SupplyTextError), "{wrong}");
        }
    }
}
