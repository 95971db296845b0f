//! A simulated plant that differs from the rig's file, for tests of robustness.

use std::str::FromStr;

use sinew_rig::Mechanism;
use thiserror::Error;

use crate::model::Parameters;

/// The differences between a simulated plant and the model of its controller. Default: no differences.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variation {
    /// Factor on the stiffness of gears.
    pub stiffness: f64,
    /// Factor on the play of gears.
    pub play: f64,
    /// Factor on the damping between the two ends of gears.
    pub damping: f64,
    /// Factor on the dry friction of servos: Coulomb friction, additional friction at rest, and friction by load.
    pub friction: f64,
    /// Share of the dry friction at the output shaft, 0 to 1; `None` for the value of each kind.
    pub output_friction: Option<f64>,
    /// Factor on the inertia of rotors.
    pub rotor: f64,
    /// Factor on the torque constant of motors, which is also their back-EMF constant.
    pub torque: f64,
    /// Factor on the masses and inertias of bodies.
    pub masses: f64,
    /// Additional age of servo readings, in ticks of the controller.
    pub delay_ticks: u8,
}

/// One difference, as written by a person: `NAME=NUMBER`.
///
/// ```
/// use sinew_servo_sim::variation::{Change, Variation};
/// let changes: Vec<Change> = vec!["stiffness=0.5".parse()?, "play=2".parse()?];
/// let variation = Variation::of(&changes)?;
/// assert_eq!((variation.stiffness, variation.play, variation.damping), (0.5, 2.0, 1.0));
/// # Ok::<(), sinew_servo_sim::variation::ChangeError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    name: &'static str,
    number: f64,
}

/// The reason why a difference was refused.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("plant `{change}`: expected {expected}, found `{found}`")]
pub struct ChangeError {
    /// The whole text of the difference.
    pub change: String,
    /// Description of valid text.
    pub expected: String,
    /// Text that was found.
    pub found: String,
}

/// Names of the differences, with their meanings.
const NAMES: [(&str, &str); 9] = [
    ("stiffness", "of gears"),
    ("play", "of gears"),
    ("damping", "of gears"),
    ("friction", "dry friction of servos"),
    ("output-friction", "part of it at the output shaft, 0 to 1"),
    ("rotor", "inertia of rotors"),
    ("torque", "torque constant of motors"),
    ("masses", "masses and inertias of bodies"),
    ("delay", "ticks by which readings are older, 0 to 20"),
];
/// Minimum and maximum factor.
const FACTORS: [f64; 2] = [0.01, 100.0];
const MOST_DELAY_TICKS: u8 = 20;

impl Default for Variation {
    fn default() -> Self {
        Self {
            stiffness: 1.0,
            play: 1.0,
            damping: 1.0,
            friction: 1.0,
            output_friction: None,
            rotor: 1.0,
            torque: 1.0,
            masses: 1.0,
            delay_ticks: 0,
        }
    }
}

impl Variation {
    /// Combines differences.
    ///
    /// # Errors
    /// [`ChangeError`] if a name occurs twice.
    pub fn of(changes: &[Change]) -> Result<Self, ChangeError> {
        let mut variation = Self::default();
        for (index, change) in changes.iter().enumerate() {
            if let Some(before) = changes[..index].iter().find(|before| before.name == change.name)
            {
                return Err(ChangeError {
                    change: change.to_string(),
                    expected: format!("`{}` once", change.name),
                    found: format!("{before}, {change}"),
                });
            }
            variation.take(*change);
        }
        Ok(variation)
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a delay is a whole number from 0 to 20"
    )]
    fn take(&mut self, Change { name, number }: Change) {
        match name {
            "stiffness" => self.stiffness = number,
            "play" => self.play = number,
            "damping" => self.damping = number,
            "friction" => self.friction = number,
            "output-friction" => self.output_friction = Some(number),
            "rotor" => self.rotor = number,
            "torque" => self.torque = number,
            "masses" => self.masses = number,
            _ => self.delay_ticks = number as u8,
        }
    }

    /// Applies the differences to the parameters of a servo. `tick_s` is the controller's tick.
    pub fn change_servo(&self, kind: &mut Parameters, tick_s: f64) {
        kind.gear_stiffness_nm_rad *= self.stiffness;
        kind.backlash_rad *= self.play;
        kind.gear_damping_nm_s *= self.damping;
        for friction in [&mut kind.friction_nm, &mut kind.stribeck_nm, &mut kind.load_friction] {
            *friction *= self.friction;
        }
        kind.output_friction_share = self.output_friction.unwrap_or(kind.output_friction_share);
        kind.rotor_inertia_kg_m2 *= self.rotor;
        kind.torque_constant_nm_a *= self.torque;
        kind.reading_delay_s += f64::from(self.delay_ticks) * tick_s;
    }

    /// Applies the differences to a rig's bodies.
    pub fn change_bodies(&self, mechanism: &mut Mechanism) {
        for body in &mut mechanism.bodies {
            body.mass_kg *= self.masses;
            body.inertia_kg_m2 *= self.masses;
        }
    }
}

impl Change {
    /// Describes all names for a help text: `stiffness (of gears), ...`.
    pub fn known() -> String {
        let known = NAMES.iter().map(|(name, what)| format!("{name} ({what})"));
        known.collect::<Vec<_>>().join(", ")
    }
}

impl std::fmt::Display for Change {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}={}", self.name, self.number)
    }
}

impl FromStr for Change {
    type Err = ChangeError;

    fn from_str(change: &str) -> Result<Self, ChangeError> {
        let refused = |expected: &str, found: &str| ChangeError {
            change: change.to_owned(),
            expected: expected.to_owned(),
            found: found.to_owned(),
        };
        let (name, value) = change
            .split_once('=')
            .ok_or_else(|| refused("NAME=FACTOR, such as stiffness=0.5", change))?;
        let Some((name, _)) = NAMES.iter().find(|(known, _)| *known == name) else {
            return Err(refused(&format!("one of: {}", Self::known()), name));
        };
        let number = |expected: &str, fits: &dyn Fn(f64) -> bool| {
            let number = value.parse::<f64>().ok().filter(|number| fits(*number));
            number.ok_or_else(|| refused(expected, value))
        };
        let number = match *name {
            "output-friction" => {
                number("a part from 0 to 1", &|number| (0.0..=1.0).contains(&number))?
            }
            "delay" => {
                let ticks = value.parse::<u8>().ok().filter(|ticks| *ticks <= MOST_DELAY_TICKS);
                let expected = format!("a whole number of ticks from 0 to {MOST_DELAY_TICKS}");
                ticks.ok_or_else(|| refused(&expected, value))?.into()
            }
            _ => {
                let [least, most] = FACTORS;
                let expected = format!("a factor from {least} to {most}");
                number(&expected, &|number| (least..=most).contains(&number))?
            }
        };
        Ok(Self { name, number })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_changes_its_own_number() {
        let kind = Parameters::built_in("XL330-M288-T").unwrap();
        let changed = |change: &str| {
            let variation = Variation::of(&[change.parse().unwrap()]).unwrap();
            let mut changed = kind.clone();
            variation.change_servo(&mut changed, 0.002);
            (changed, variation.masses)
        };
        assert_eq!(changed("masses=1.2"), (kind.clone(), 1.2));
        let half = |change: &str, set: &dyn Fn(&mut Parameters)| {
            let mut expected = kind.clone();
            set(&mut expected);
            assert_eq!(changed(change), (expected, 1.0), "{change}");
        };
        half("stiffness=0.5", &|kind| kind.gear_stiffness_nm_rad *= 0.5);
        half("play=0.5", &|kind| kind.backlash_rad *= 0.5);
        half("damping=0.5", &|kind| kind.gear_damping_nm_s *= 0.5);
        half("friction=0.5", &|kind| {
            kind.friction_nm *= 0.5;
            kind.stribeck_nm *= 0.5;
            kind.load_friction *= 0.5;
        });
        half("output-friction=0.5", &|kind| kind.output_friction_share = 0.5);
        half("rotor=0.5", &|kind| kind.rotor_inertia_kg_m2 *= 0.5);
        half("torque=0.5", &|kind| kind.torque_constant_nm_a *= 0.5);
        half("delay=2", &|kind| kind.reading_delay_s = 0.004);
    }

    #[test]
    fn bodies_are_heavier() {
        let mut mechanism = sinew_rig::new::arm(3).unwrap().mechanism().unwrap();
        let before = mechanism.clone();
        Variation { masses: 1.5, ..Variation::default() }.change_bodies(&mut mechanism);
        for (body, before) in mechanism.bodies.iter().zip(&before.bodies) {
            assert!((body.mass_kg - 1.5 * before.mass_kg).abs() < 1e-12);
            let off = body.inertia_kg_m2 - before.inertia_kg_m2 * 1.5;
            assert!(off.to_cols_array().iter().all(|off| off.abs() < 1e-12));
        }
    }

    #[test]
    fn what_is_no_change_is_refused_with_what_would_be() {
        for (change, expected, found) in [
            ("stiffness", "NAME=FACTOR, such as stiffness=0.5", "stiffness"),
            ("stiffnes=2", "one of: stiffness (of gears), play", "stiffnes"),
            ("=2", "one of: stiffness", ""),
            ("stiffness=", "a factor from 0.01 to 100", ""),
            ("stiffness=NaN", "a factor from 0.01 to 100", "NaN"),
            ("play=0", "a factor from 0.01 to 100", "0"),
            ("masses=-1", "a factor from 0.01 to 100", "-1"),
            ("rotor=inf", "a factor from 0.01 to 100", "inf"),
            ("output-friction=1.1", "a part from 0 to 1", "1.1"),
            ("output-friction=NaN", "a part from 0 to 1", "NaN"),
            ("delay=0.5", "a whole number of ticks from 0 to 20", "0.5"),
            ("delay=21", "a whole number of ticks from 0 to 20", "21"),
        ] {
            let message = change.parse::<Change>().unwrap_err().to_string();
            assert!(message.contains(expected), "{change}: {message}");
            assert!(message.ends_with(&format!("found `{found}`")), "{change}: {message}");
        }
        let twice = ["play=2", "play=3"].map(|change| change.parse().unwrap());
        let message = Variation::of(&twice).unwrap_err().to_string();
        assert!(message.ends_with("expected `play` once, found `play=2, play=3`"), "{message}");
    }
}
