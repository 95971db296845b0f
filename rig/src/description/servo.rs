//! Servos, and what their kinds can do.

use serde::{Deserialize, Serialize};

use super::angle::{degree_pairs, degrees};

/// One servo.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Servo {
    /// What people call it; unique among servos.
    pub name: String,
    /// A kind of servo, see [`ServoModel::built_in`].
    pub model: String,
    /// The bus that it hangs on.
    #[serde(default = "main")]
    pub bus: String,
    /// Where on the bus.
    #[serde(flatten)]
    pub address: Address,
    /// 1 if its positive turn is the drive's, -1 if it is mirrored.
    #[serde(default = "forward")]
    pub direction: i8,
    /// Its own position where the drive has zero.
    #[serde(
        rename = "offset_deg",
        with = "degrees",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub offset_rad: Option<f64>,
    /// Turns of the servo for a turn of the output that the drive sees. Default: 1.
    #[serde(default = "one")]
    pub gear: f64,
    /// How far it may go, by its own position: one pair. Empty: as its kind.
    #[serde(
        rename = "range_deg",
        with = "degree_pairs",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    pub range_rad: Vec<[f64; 2]>,
    /// The most torque that it is asked for, N m. Default: as its kind.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_nm: Option<f64>,
    /// The largest speed that it is asked for.
    #[serde(
        rename = "speed_deg_s",
        with = "degrees",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub speed_rad_s: Option<f64>,
    /// The largest acceleration that it is asked for.
    #[serde(
        rename = "acceleration_deg_s2",
        with = "degrees",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub acceleration_rad_s2: Option<f64>,
    /// What it does when commands stop.
    #[serde(default)]
    pub on_signal_loss: SignalLoss,
}

/// Where a servo is on its bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Address {
    /// Id of a bus servo, 0 to 252.
    Id(u8),
    /// Channel of a PWM driver, 0 to 15.
    Channel(u8),
}

/// What a servo does when commands stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SignalLoss {
    /// Torque off.
    #[default]
    Limp,
    /// Stays where it is.
    Hold,
    /// Goes home, slowly.
    Home,
}

/// What a kind of servo can do, at its output shaft.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ServoModel {
    /// What its maker calls it.
    pub name: String,
    /// Voltage that the values are for, V.
    pub voltage_v: Sourced,
    /// Torque per current, N m/A.
    pub torque_constant_nm_a: Sourced,
    /// Torque at standstill and full voltage, N m.
    pub stall_torque_nm: Sourced,
    /// Current at standstill, A.
    pub stall_current_a: Sourced,
    /// Torque that it holds for long without overheating, N m.
    pub continuous_torque_nm: Sourced,
    /// Speed without load, rad/s.
    pub no_load_speed_rad_s: Sourced,
    /// Torque per position error of its own controller, N m/rad; zero if it has none.
    pub position_gain_nm_rad: Sourced,
    /// Inertia of the rotor as the gear shows it, kg m².
    pub rotor_inertia_kg_m2: Sourced,
    /// Coulomb friction, N m.
    pub friction_nm: Sourced,
    /// Viscous friction, N m s.
    pub damping_nm_s: Sourced,
    /// Least step of its position, rad.
    pub resolution_rad: Sourced,
    /// Play of the gear, from end to end, rad.
    pub backlash_rad: Sourced,
    /// How far it turns, from end to end, rad.
    pub range_rad: Sourced,
    /// Warming of the motor per power lost in it, K/W.
    pub thermal_resistance_k_w: Sourced,
    /// Time constant of that, s.
    pub thermal_time_s: Sourced,
    /// Temperature at which it shuts down, °C.
    pub shutdown_c: Sourced,
}

impl ServoModel {
    /// All values, each with its key.
    pub fn values(&self) -> [(&'static str, &Sourced); 16] {
        [
            ("voltage_v", &self.voltage_v),
            ("torque_constant_nm_a", &self.torque_constant_nm_a),
            ("stall_torque_nm", &self.stall_torque_nm),
            ("stall_current_a", &self.stall_current_a),
            ("continuous_torque_nm", &self.continuous_torque_nm),
            ("no_load_speed_rad_s", &self.no_load_speed_rad_s),
            ("position_gain_nm_rad", &self.position_gain_nm_rad),
            ("rotor_inertia_kg_m2", &self.rotor_inertia_kg_m2),
            ("friction_nm", &self.friction_nm),
            ("damping_nm_s", &self.damping_nm_s),
            ("resolution_rad", &self.resolution_rad),
            ("backlash_rad", &self.backlash_rad),
            ("range_rad", &self.range_rad),
            ("thermal_resistance_k_w", &self.thermal_resistance_k_w),
            ("thermal_time_s", &self.thermal_time_s),
            ("shutdown_c", &self.shutdown_c),
        ]
    }
}

/// A value, and where it is from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sourced {
    /// In the unit of the field's name.
    pub value: f64,
    /// Who measured or states it; "guess: ..." if nobody does.
    pub source: String,
}

impl Sourced {
    /// Whether nobody has measured or stated it.
    pub fn is_guess(&self) -> bool {
        self.source.starts_with("guess")
    }
}

fn main() -> String {
    "main".to_owned()
}

fn forward() -> i8 {
    1
}

fn one() -> f64 {
    1.0
}
