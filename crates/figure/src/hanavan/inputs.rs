//! What is measured on a subject: TOML text to checked numbers.

use serde::{Deserialize, Serialize};

/// A length of a human body: finite, above 0 and at most [`Metres::LARGEST`].
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct Metres(f64);

impl Metres {
    /// More than any length or girth of a human body, and less than any one in centimetres.
    pub const LARGEST: f64 = 3.0;

    /// The length in metres.
    pub fn get(self) -> f64 {
        self.0
    }

    /// The length in centimetres, which published regressions are in.
    pub(super) fn cm(self) -> f64 {
        100.0 * self.0
    }
}

impl From<Metres> for f64 {
    fn from(value: Metres) -> Self {
        value.0
    }
}

impl TryFrom<f64> for Metres {
    type Error = String;

    fn try_from(value: f64) -> Result<Self, String> {
        let found = format!("expected metres above 0 and at most {}, found {value}", Self::LARGEST);
        match value {
            _ if value > 0.0 && value <= Self::LARGEST => Ok(Self(value)),
            _ if value > Self::LARGEST && value.is_finite() => {
                Err(format!("{found}: is it in centimetres or millimetres?"))
            }
            _ => Err(found),
        }
    }
}

/// Mass of a human body: finite, above 0 and at most [`Kilograms::LARGEST`].
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct Kilograms(f64);

impl Kilograms {
    /// More than anybody weighs, and less than anybody does in grams.
    pub const LARGEST: f64 = 700.0;

    /// The mass in kg.
    pub fn get(self) -> f64 {
        self.0
    }
}

impl From<Kilograms> for f64 {
    fn from(value: Kilograms) -> Self {
        value.0
    }
}

impl TryFrom<f64> for Kilograms {
    type Error = String;

    fn try_from(value: f64) -> Result<Self, String> {
        if value > 0.0 && value <= Self::LARGEST {
            return Ok(Self(value));
        }
        Err(format!("expected kilograms above 0 and at most {}, found {value}", Self::LARGEST))
    }
}

/// The 41 inputs of the modified Hanavan model, total mass, and what to do with the sum of the masses.
///
/// P1 to P41 are the model's numbers of the inputs. What each one is and how to measure it is said in the
/// built-in subject's file, `subjects/reference.toml`. The names are inferred from the equations' use of the
/// numbers. `None` only where no equation uses the number.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Inputs {
    /// Name of the subject.
    pub name: String,
    /// Total mass.
    pub mass_kg: Kilograms,
    /// Whether the masses are scaled to sum to the total mass.
    #[serde(default)]
    pub normalise: bool,

    /// P1. Not used.
    pub hand_length_m: Option<Metres>,
    /// P2.
    pub wrist_to_knuckle_m: Metres,
    /// P3.
    pub forearm_length_m: Metres,
    /// P4. Not used.
    pub upper_arm_length_bent_m: Option<Metres>,
    /// P5.
    pub upper_arm_length_m: Metres,
    /// P6.
    pub foot_length_m: Metres,
    /// P7.
    pub shank_length_m: Metres,
    /// P8.
    pub thigh_length_m: Metres,
    /// P9.
    pub head_length_m: Metres,
    /// P10. Not used.
    pub neck_length_m: Option<Metres>,
    /// P11.
    pub upper_trunk_length_m: Metres,
    /// P12.
    pub mid_trunk_length_m: Metres,
    /// P13.
    pub lower_trunk_length_m: Metres,
    /// P14.
    pub fist_circumference_m: Metres,
    /// P15.
    pub wrist_circumference_m: Metres,
    /// P16.
    pub forearm_circumference_m: Metres,
    /// P17.
    pub elbow_circumference_m: Metres,
    /// P18.
    pub axillary_arm_circumference_m: Metres,
    /// P19.
    pub heel_circumference_m: Metres,
    /// P20.
    pub ball_circumference_m: Metres,
    /// P21.
    pub toe_circumference_m: Metres,
    /// P22.
    pub ankle_circumference_m: Metres,
    /// P23.
    pub calf_circumference_m: Metres,
    /// P24.
    pub knee_circumference_m: Metres,
    /// P25.
    pub upper_thigh_circumference_m: Metres,
    /// P26.
    pub head_circumference_m: Metres,
    /// P27.
    pub chest_circumference_m: Metres,
    /// P28.
    pub xyphion_circumference_m: Metres,
    /// P29.
    pub omphalion_circumference_m: Metres,
    /// P30.
    pub hip_circumference_m: Metres,
    /// P31. Not used.
    pub hand_breadth_m: Option<Metres>,
    /// P32.
    pub wrist_breadth_m: Metres,
    /// P33.
    pub foot_breadth_m: Metres,
    /// P34.
    pub toe_breadth_m: Metres,
    /// P35.
    pub upper_thigh_depth_m: Metres,
    /// P36.
    pub chest_breadth_m: Metres,
    /// P37.
    pub xyphion_breadth_m: Metres,
    /// P38.
    pub omphalion_breadth_m: Metres,
    /// P39.
    pub hip_breadth_m: Metres,
    /// P40. Not used.
    pub iliac_breadth_m: Option<Metres>,
    /// P41.
    pub trunk_length_m: Metres,
}

impl Inputs {
    /// Thigh and shank.
    pub(super) fn leg_m(&self) -> f64 {
        self.thigh_length_m.get() + self.shank_length_m.get()
    }
}
