//! Faults as text, written by a person: `SERVO:WHAT[=HOW MUCH][@WHEN][+HOW LONG]`.

use std::str::FromStr;

use thiserror::Error;

use super::{Fault, FaultKind};

/// A fault as ordered by a person: `2:silent@3s`, `elbow:late=5ms@1s+500ms`.
///
/// ```
/// use sinew_servo_sim::fault::{FaultKind, FaultOrder};
/// let order: FaultOrder = "2:late=5ms@3s+0.5s".parse()?;
/// assert_eq!((order.servo.as_str(), order.at_s, order.for_s), ("2", 3.0, 0.5));
/// assert_eq!(order.kind, FaultKind::Late(5_000));
/// # Ok::<(), sinew_servo_sim::fault::FaultOrderError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FaultOrder {
    /// Id or name of the servo. The receiver of the order resolves it.
    pub servo: String,
    /// Time at which the fault begins, s.
    pub at_s: f64,
    /// Duration of the fault, s; infinite if it does not end.
    pub for_s: f64,
    /// Kind of the fault.
    pub kind: FaultKind,
}

/// The kinds of faults: name, default amount, and description.
const KINDS: [(&str, &str, &str); 12] = [
    ("silent", "", "does not answer"),
    ("late", "5ms", "answers later by this time"),
    ("wrong-crc", "", "its replies have a wrong checksum"),
    ("short", "4", "its replies end after this many bytes"),
    ("wrong-id", "252", "answers with another id"),
    ("stuck", "", "its gear is jammed"),
    ("hot", "90", "its case has this many deg C"),
    ("brown-out", "", "its supply is cut"),
    ("rebooted", "", "restarts"),
    ("torque-lost", "", "its torque switches off"),
    ("encoder-jump", "90", "its encoder reads this many deg more"),
    ("torque-stuck", "", "its torque stays on, whatever it receives"),
];

/// The reason why a fault text was refused.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("fault `{order}`: expected {expected}, found `{found}`")]
pub struct FaultOrderError {
    /// The whole text.
    pub order: String,
    /// Description of valid text.
    pub expected: String,
    /// Text that was found.
    pub found: String,
}

impl FaultOrder {
    /// Describes all kinds for a help text: `late=5ms (answers later by this time), ...`.
    pub fn known() -> String {
        let known = KINDS.iter().map(|(name, value, what)| {
            let equals = if value.is_empty() { "" } else { "=" };
            format!("{name}{equals}{value} ({what})")
        });
        known.collect::<Vec<_>>().join(", ")
    }

    /// Returns the fault for the servo with this index.
    pub fn of(&self, servo: usize) -> Fault {
        Fault { servo, at_s: self.at_s, for_s: self.for_s, kind: self.kind }
    }
}

impl FromStr for FaultOrder {
    type Err = FaultOrderError;

    fn from_str(order: &str) -> Result<Self, FaultOrderError> {
        let refused = |expected: &str, found: &str| FaultOrderError {
            order: order.to_owned(),
            expected: expected.to_owned(),
            found: found.to_owned(),
        };
        let (servo, rest) = order
            .split_once(':')
            .filter(|(servo, _)| !servo.is_empty())
            .ok_or_else(|| refused("SERVO:WHAT, such as 2:silent@3s", order))?;
        let (rest, long) = rest.split_once('+').map_or((rest, None), |(a, b)| (a, Some(b)));
        let (rest, start) = rest.split_once('@').map_or((rest, None), |(a, b)| (a, Some(b)));
        let (name, value) = rest.split_once('=').map_or((rest, None), |(a, b)| (a, Some(b)));
        let time = |text: &str| {
            seconds(text).ok_or_else(|| refused("a time such as 3s, 250ms or 800us", text))
        };
        let Some((name, default, _)) = KINDS.iter().find(|(known, ..)| *known == name) else {
            return Err(refused(&format!("one of: {}", Self::known()), name));
        };
        if let Some(value) = value.filter(|_| default.is_empty()) {
            return Err(refused(&format!("`{name}` without a value"), value));
        }
        let value = value.unwrap_or(default);
        let within = |least: f64, most: f64| {
            let number = value.parse::<f64>().ok().filter(|x| (least..=most).contains(x));
            number.ok_or_else(|| refused(&format!("a number from {least} to {most}"), value))
        };
        let whole = |most: u8| {
            let number = value.parse::<u8>().ok().filter(|x| *x <= most);
            number.ok_or_else(|| refused(&format!("a whole number from 0 to {most}"), value))
        };
        let kind = match *name {
            "silent" => FaultKind::Silent,
            "late" => {
                FaultKind::Late(crate::device::codes::whole(time(value)? * 1e6).unsigned_abs())
            }
            "wrong-crc" => FaultKind::WrongCheck,
            "short" => FaultKind::Short(whole(u8::MAX)?.into()),
            "wrong-id" => FaultKind::WrongId(whole(252)?),
            "stuck" => FaultKind::Stuck,
            "hot" => FaultKind::Hot(within(-20.0, 200.0)?),
            "brown-out" => FaultKind::BrownOut,
            "rebooted" => FaultKind::Reboot,
            "torque-lost" => FaultKind::TorqueLost,
            "torque-stuck" => FaultKind::TorqueStuck,
            _ => FaultKind::EncoderJump(within(-3600.0, 3600.0)?.to_radians()),
        };
        Ok(Self {
            servo: servo.to_owned(),
            at_s: start.map_or(Ok(0.0), time)?,
            for_s: long.map_or(Ok(f64::INFINITY), time)?,
            kind,
        })
    }
}

/// Parses a time with its unit, and returns it in s. Returns `None` if the text is not a time from 0 to a day.
fn seconds(text: &str) -> Option<f64> {
    let units = [("us", 1e-6), ("ms", 1e-3), ("s", 1.0)];
    let (number, unit) =
        units.iter().find_map(|(name, unit)| Some((text.strip_suffix(name)?, unit)))?;
    let time = number.parse::<f64>().ok()? * unit;
    (0.0..=86_400.0).contains(&time).then_some(time)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(order: &str) -> FaultKind {
        order.parse::<FaultOrder>().unwrap().kind
    }

    #[test]
    fn every_kind_can_be_ordered() {
        assert_eq!(kind("2:silent"), FaultKind::Silent);
        assert_eq!(kind("2:late"), FaultKind::Late(5_000));
        assert_eq!(kind("2:late=800us@1s"), FaultKind::Late(800));
        assert_eq!(kind("2:wrong-crc"), FaultKind::WrongCheck);
        assert_eq!(kind("2:short=9"), FaultKind::Short(9));
        assert_eq!(kind("2:wrong-id"), FaultKind::WrongId(252));
        assert_eq!(kind("2:stuck"), FaultKind::Stuck);
        assert_eq!(kind("2:hot=75"), FaultKind::Hot(75.0));
        assert_eq!(kind("2:brown-out+50ms"), FaultKind::BrownOut);
        assert_eq!(kind("2:rebooted"), FaultKind::Reboot);
        assert_eq!(kind("2:torque-lost"), FaultKind::TorqueLost);
        assert_eq!(kind("2:torque-stuck"), FaultKind::TorqueStuck);
        assert_eq!(kind("2:encoder-jump=-180"), FaultKind::EncoderJump(-std::f64::consts::PI));
        for (name, ..) in KINDS {
            kind(&format!("2:{name}"));
            assert!(FaultOrder::known().contains(name));
        }
    }

    #[test]
    fn when_and_how_long_stand_behind() {
        let order: FaultOrder = "neck yaw:stuck@250ms+1.5s".parse().unwrap();
        assert_eq!((order.servo.as_str(), order.at_s, order.for_s), ("neck yaw", 0.25, 1.5));
        let fault = order.of(3);
        assert!(fault.servo == 3 && fault.is_on(0.25) && fault.is_on(1.7) && !fault.is_on(1.8));
        let order: FaultOrder = "1:silent".parse().unwrap();
        assert!(order.of(0).is_on(0.0) && order.of(0).is_on(1e9));
    }

    #[test]
    fn what_is_no_fault_is_refused_with_what_would_be() {
        for (order, expected, found) in [
            ("silent", "SERVO:WHAT", "silent"),
            (":silent", "SERVO:WHAT", ":silent"),
            ("2:mute", "one of: silent (does not answer), late=5ms", "mute"),
            ("2:silent=3", "`silent` without a value", "3"),
            ("2:silent@3", "a time such as 3s", "3"),
            ("2:silent@-3s", "a time such as 3s", "-3s"),
            ("2:silent@nans", "a time such as 3s", "nans"),
            ("2:silent+infs", "a time such as 3s", "infs"),
            ("2:late=5", "a time such as 3s", "5"),
            ("2:hot=NaN", "a number from -20 to 200", "NaN"),
            ("2:hot=inf", "a number from -20 to 200", "inf"),
            ("2:wrong-id=253", "a whole number from 0 to 252", "253"),
            ("2:short=-1", "a whole number from 0 to 255", "-1"),
        ] {
            let message = order.parse::<FaultOrder>().unwrap_err().to_string();
            assert!(message.contains(expected), "{order}: {message}");
            assert!(message.ends_with(&format!("found `{found}`")), "{order}: {message}");
        }
    }
}
