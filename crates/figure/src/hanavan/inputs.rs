//! Measurements of a subject, parsed from TOML into checked numbers.

use serde::{Deserialize, Serialize};

/// A length of a human body: finite, above 0 and at most [`Metres::LARGEST`].
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct Metres(f64);

impl Metres {
    /// Upper bound: more than any length or girth of a human body in metres, and less than any of them in
    /// centimetres.
    pub const LARGEST: f64 = 3.0;

    /// Returns the length in metres.
    pub fn get(self) -> f64 {
        self.0
    }

    /// Returns the length in centimetres, the unit of the published regressions.
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
    /// Upper bound: more than any person's weight in kilograms, and less than any person's weight in grams.
    pub const LARGEST: f64 = 700.0;

    /// Returns the mass in kg.
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

/// The 41 inputs of the modified Hanavan model, the total mass, and whether masses are scaled to sum to it.
///
/// P1 to P41 are the model's numbers of the inputs. The built-in subject's file, `subjects/reference.toml`,
/// describes each input and how to measure it. The names are inferred from the equations' use of the numbers. An
/// input may be `None` only if no equation uses its number.
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

    /// P1. No equation uses it.
    pub hand_length_m: Option<Metres>,
    /// P2: distance from the wrist to the knuckles.
    pub wrist_to_knuckle_m: Metres,
    /// P3: length of the forearm.
    pub forearm_length_m: Metres,
    /// P4. No equation uses it.
    pub upper_arm_length_bent_m: Option<Metres>,
    /// P5: length of the upper arm.
    pub upper_arm_length_m: Metres,
    /// P6: length of the foot.
    pub foot_length_m: Metres,
    /// P7: length of the shank.
    pub shank_length_m: Metres,
    /// P8: length of the thigh.
    pub thigh_length_m: Metres,
    /// P9: length of the head.
    pub head_length_m: Metres,
    /// P10. No equation uses it.
    pub neck_length_m: Option<Metres>,
    /// P11: length of the upper trunk.
    pub upper_trunk_length_m: Metres,
    /// P12: length of the middle trunk.
    pub mid_trunk_length_m: Metres,
    /// P13: length of the lower trunk.
    pub lower_trunk_length_m: Metres,
    /// P14: circumference of the fist.
    pub fist_circumference_m: Metres,
    /// P15: circumference of the wrist.
    pub wrist_circumference_m: Metres,
    /// P16: circumference of the forearm.
    pub forearm_circumference_m: Metres,
    /// P17: circumference of the elbow.
    pub elbow_circumference_m: Metres,
    /// P18: circumference of the arm at the armpit.
    pub axillary_arm_circumference_m: Metres,
    /// P19: circumference of the heel.
    pub heel_circumference_m: Metres,
    /// P20: circumference of the ball of the foot.
    pub ball_circumference_m: Metres,
    /// P21: circumference of the toes.
    pub toe_circumference_m: Metres,
    /// P22: circumference of the ankle.
    pub ankle_circumference_m: Metres,
    /// P23: circumference of the calf.
    pub calf_circumference_m: Metres,
    /// P24: circumference of the knee.
    pub knee_circumference_m: Metres,
    /// P25: circumference of the upper thigh.
    pub upper_thigh_circumference_m: Metres,
    /// P26: circumference of the head.
    pub head_circumference_m: Metres,
    /// P27: circumference of the chest.
    pub chest_circumference_m: Metres,
    /// P28: circumference of the trunk at the xyphion.
    pub xyphion_circumference_m: Metres,
    /// P29: circumference of the trunk at the omphalion.
    pub omphalion_circumference_m: Metres,
    /// P30: circumference of the hips.
    pub hip_circumference_m: Metres,
    /// P31. No equation uses it.
    pub hand_breadth_m: Option<Metres>,
    /// P32: breadth of the wrist.
    pub wrist_breadth_m: Metres,
    /// P33: breadth of the foot.
    pub foot_breadth_m: Metres,
    /// P34: breadth of the toes.
    pub toe_breadth_m: Metres,
    /// P35: depth of the upper thigh.
    pub upper_thigh_depth_m: Metres,
    /// P36: breadth of the chest.
    pub chest_breadth_m: Metres,
    /// P37: breadth of the trunk at the xyphion.
    pub xyphion_breadth_m: Metres,
    /// P38: breadth of the trunk at the omphalion.
    pub omphalion_breadth_m: Metres,
    /// P39: breadth of the hips.
    pub hip_breadth_m: Metres,
    /// P40. No equation uses it.
    pub iliac_breadth_m: Option<Metres>,
    /// P41: length of the trunk.
    pub trunk_length_m: Metres,
}

impl Inputs {
    /// Returns the length of thigh and shank together.
    pub(super) fn leg_m(&self) -> f64 {
        self.thigh_length_m.get() + self.shank_length_m.get()
    }
}
