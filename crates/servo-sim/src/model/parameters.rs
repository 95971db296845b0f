//! Parameters of a servo kind: from `sinew-rig`, from the files of `models/`, and computed from both.

use serde::Deserialize;
use sinew_rig::description::{Pulses, ServoModel, SourcedValue};
use thiserror::Error;

const COMMON: &str = include_str!("../../models/common.toml");
/// Files with values of single kinds. Missing values are taken from the common file.
const FILES: [(&str, &str); 6] = [
    ("XL330-M288-T", include_str!("../../models/xl330-m288-t.toml")),
    ("XL430-W250-T", include_str!("../../models/xl430-w250-t.toml")),
    ("XM430-W350-T", include_str!("../../models/xm430-w350-t.toml")),
    ("MX-64", include_str!("../../models/mx-64.toml")),
    ("STS3215-7.4V", include_str!("../../models/sts3215-7.4v.toml")),
    ("STS3215-12V", include_str!("../../models/sts3215-12v.toml")),
];

/// The reason why parameters could not be determined.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ParametersError {
    /// No kind has this name.
    #[error("there is no servo called {0}; there are {known}", known = known())]
    Unknown(String),
    /// A file of `models/` is invalid.
    #[error("models/{name}: {message}")]
    File {
        /// Name of the file.
        name: String,
        /// Cause of the error.
        message: String,
    },
    /// The maker's figures contradict each other.
    #[error("{name}: {what}")]
    Contradiction {
        /// Name of the kind.
        name: String,
        /// Description of the contradiction.
        what: &'static str,
    },
}

fn known() -> String {
    ServoModel::built_in_names().collect::<Vec<_>>().join(", ")
}

/// Keys of a file in `models/`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Extra {
    stribeck_nm: SourcedValue,
    stribeck_rad_s: SourcedValue,
    loop_hz: SourcedValue,
    winding_share: SourcedValue,
    winding_time_s: SourcedValue,
    standby_a: SourcedValue,
    brown_out_v: SourcedValue,
    boot_s: SourcedValue,
    position_p_divisor: Option<SourcedValue>,
    load_friction: Option<SourcedValue>,
    speed_cap_rad_s: Option<SourcedValue>,
}

/// All parameters of a simulated servo, at its output shaft.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    /// The maker's name for this kind of servo, such as `XL330-M288-T`.
    pub name: String,
    /// Voltage of the maker's figures, V.
    pub voltage_v: f64,
    /// Torque per current of the motor before friction, N m/A; equal to its back-EMF constant, V s/rad.
    pub torque_constant_nm_a: f64,
    /// Resistance of motor and driver at 25 °C, ohm.
    pub resistance_ohm: f64,
    /// Inertia of the rotor, kg m².
    pub rotor_inertia_kg_m2: f64,
    /// Coulomb friction of both ends of the gear without load, N m.
    pub friction_nm: f64,
    /// Additional friction at rest, N m.
    pub stribeck_nm: f64,
    /// Speed at which the additional friction has fallen to 1/e, rad/s.
    pub stribeck_rad_s: f64,
    /// Friction per torque at either end of the gear.
    pub load_friction: f64,
    /// Viscous friction of the rotor, N m s.
    pub damping_nm_s: f64,
    /// Play of the gear from end to end, rad.
    pub backlash_rad: f64,
    /// Stiffness of the gear, N m/rad.
    pub gear_stiffness_nm_rad: f64,
    /// Damping between the two ends of the gear, N m s.
    pub gear_damping_nm_s: f64,
    /// Share of the dry friction at the output shaft, 0 to 1. Viscous friction acts only on the rotor.
    pub output_friction_share: f64,
    /// Resolution of the position, rad.
    pub resolution_rad: f64,
    /// Range of the position, rad.
    pub range_rad: f64,
    /// Pulses of the servo, which are used only if it is driven by pulses.
    pub pulses: Pulses,
    /// Maximum speed that the firmware commands, rad/s; `None` for no limit.
    pub speed_cap_rad_s: Option<f64>,
    /// Torque per position error with factory gains, N m/rad.
    pub position_gain_nm_rad: f64,
    /// Divisor of Position P Gain of a Dynamixel.
    pub position_p_divisor: f64,
    /// Rate of the firmware's control loop, Hz.
    pub loop_hz: f64,
    /// Thermal resistance from case to air, K/W.
    pub case_k_w: f64,
    /// Time constant of the case's warming, s.
    pub case_time_s: f64,
    /// Thermal resistance from winding to case, K/W.
    pub winding_k_w: f64,
    /// Time constant of the winding's warming, s.
    pub winding_time_s: f64,
    /// Temperature of the case at which the servo shuts down, °C.
    pub shutdown_c: f64,
    /// Age of reported readings, s, in addition to the time since the last tick.
    pub reading_delay_s: f64,
    /// Supply current without motion, A.
    pub standby_a: f64,
    /// Supply voltage below which the firmware stops, V.
    pub brown_out_v: f64,
    /// Time that the servo takes to start, s.
    pub boot_s: f64,
    /// Names of the parameters that are guesses: neither measured nor stated.
    pub guesses: Vec<&'static str>,
}

impl Parameters {
    /// Returns the parameters of a built-in kind by name, see [`ServoModel::built_in`].
    ///
    /// # Errors
    /// [`ParametersError::Unknown`] lists the known kinds.
    pub fn built_in(name: &str) -> Result<Self, ParametersError> {
        let unknown = || ParametersError::Unknown(name.to_owned());
        Self::of_model(&ServoModel::built_in(name).ok_or_else(unknown)?)
    }

    /// Returns the parameters of a kind that a rig describes. Missing values are taken from the built-in kind with the
    /// same name, otherwise from the common file.
    ///
    /// # Errors
    /// [`ParametersError::Contradiction`] if no motor can have these figures.
    pub fn of_model(model: &ServoModel) -> Result<Self, ParametersError> {
        Self::of(model, &Extra::built_in(&model.name)?)
    }

    /// Computes the parameters that follow from the maker's figures:
    /// - resistance: voltage over stall current;
    /// - torque constant: the voltage at no-load speed is back-EMF plus friction;
    /// - friction per load: from the torque that is missing at stall.
    ///
    /// If the firmware limits the speed, the no-load speed does not describe the motor. The torque constant then
    /// follows from the stall torque, with a friction per load from the file.
    fn of(model: &ServoModel, extra: &Extra) -> Result<Self, ParametersError> {
        let contradiction =
            |what| Err(ParametersError::Contradiction { name: model.name.clone(), what });
        let [volts, amps] = [model.voltage_v.value, model.stall_current_a.value];
        let [stall_nm, coulomb_nm] = [model.stall_torque_nm.value, model.friction_nm.value];
        let stiction_nm = coulomb_nm + extra.stribeck_nm.value;
        let damping = &model.damping_nm_s;
        let resistance = volts / amps;
        let (constant, load_friction) = if let Some(load) = &extra.load_friction {
            let motor_nm = (stall_nm * (1.0 + load.value) + stiction_nm) / (1.0 - load.value);
            (motor_nm / amps, load.value)
        } else {
            let Some(motor) = model.motor(stiction_nm) else {
                return contradiction("friction is too large for its no-load speed");
            };
            (motor.torque_constant_nm_a, motor.load_friction)
        };
        if !(0.0..0.6).contains(&load_friction) {
            return contradiction("its stall torque does not go with its current and its speed");
        }
        let case_k_w = model.thermal_resistance_k_w.value;
        Ok(Self {
            name: model.name.clone(),
            voltage_v: volts,
            torque_constant_nm_a: constant,
            resistance_ohm: resistance,
            rotor_inertia_kg_m2: model.rotor_inertia_kg_m2.value,
            friction_nm: coulomb_nm,
            stribeck_nm: extra.stribeck_nm.value,
            stribeck_rad_s: extra.stribeck_rad_s.value,
            load_friction,
            damping_nm_s: damping.value,
            backlash_rad: model.backlash_rad.value,
            gear_stiffness_nm_rad: model.gear_stiffness(),
            gear_damping_nm_s: model.gear_damping(),
            output_friction_share: model.output_friction_share(),
            resolution_rad: model.resolution_rad.value,
            range_rad: model.range_rad.value,
            pulses: Pulses::of_model(model),
            speed_cap_rad_s: extra.speed_cap_rad_s.as_ref().map(|cap| cap.value),
            position_gain_nm_rad: model.position_gain_nm_rad.value,
            position_p_divisor: extra.position_p_divisor.as_ref().map_or(128.0, |p| p.value),
            loop_hz: extra.loop_hz.value,
            case_k_w,
            case_time_s: model.thermal_time_s.value,
            winding_k_w: case_k_w * extra.winding_share.value,
            winding_time_s: extra.winding_time_s.value,
            shutdown_c: model.shutdown_c.value,
            reading_delay_s: 0.0,
            standby_a: extra.standby_a.value,
            brown_out_v: extra.brown_out_v.value,
            boot_s: extra.boot_s.value,
            guesses: guesses(model, extra),
        })
    }
}

impl Extra {
    fn built_in(name: &str) -> Result<Self, ParametersError> {
        let failed = |error: toml::de::Error| ParametersError::File {
            name: name.to_owned(),
            message: error.to_string(),
        };
        let own = FILES.iter().find(|(known, _)| *known == name).map_or("", |(_, file)| file);
        let mut table: toml::Table = toml::from_str(COMMON).map_err(failed)?;
        table.extend(toml::from_str::<toml::Table>(own).map_err(failed)?);
        table.try_into().map_err(failed)
    }
}

fn guesses(model: &ServoModel, extra: &Extra) -> Vec<&'static str> {
    let own = extra.load_friction.as_ref();
    let by_rule = SourcedValue { source: "guess: by rule".to_owned(), ..SourcedValue::default() };
    let [stiffness, damping, share] =
        [&model.gear_stiffness_nm_rad, &model.gear_damping_nm_s, &model.output_friction_share]
            .map(|given| given.as_ref().unwrap_or(&by_rule));
    [
        ("voltage_v", Some(&model.voltage_v)),
        ("stall_torque_nm", Some(&model.stall_torque_nm)),
        ("stall_current_a", Some(&model.stall_current_a)),
        ("no_load_speed_rad_s", Some(&model.no_load_speed_rad_s)),
        ("position_gain_nm_rad", Some(&model.position_gain_nm_rad)),
        ("rotor_inertia_kg_m2", Some(&model.rotor_inertia_kg_m2)),
        ("friction_nm", Some(&model.friction_nm)),
        ("damping_nm_s", Some(&model.damping_nm_s)),
        ("load_friction", own),
        ("stribeck_nm", Some(&extra.stribeck_nm)),
        ("stribeck_rad_s", Some(&extra.stribeck_rad_s)),
        ("resolution_rad", Some(&model.resolution_rad)),
        ("backlash_rad", Some(&model.backlash_rad)),
        ("gear_stiffness_nm_rad", Some(stiffness)),
        ("gear_damping_nm_s", Some(damping)),
        ("output_friction_share", Some(share)),
        ("range_rad", Some(&model.range_rad)),
        ("speed_cap_rad_s", extra.speed_cap_rad_s.as_ref()),
        ("loop_hz", Some(&extra.loop_hz)),
        ("thermal_resistance_k_w", Some(&model.thermal_resistance_k_w)),
        ("thermal_time_s", Some(&model.thermal_time_s)),
        ("winding_share", Some(&extra.winding_share)),
        ("winding_time_s", Some(&extra.winding_time_s)),
        ("shutdown_c", Some(&model.shutdown_c)),
        ("standby_a", Some(&extra.standby_a)),
        ("brown_out_v", Some(&extra.brown_out_v)),
        ("boot_s", Some(&extra.boot_s)),
    ]
    .into_iter()
    .filter_map(|(name, value)| value.filter(|value| value.is_guess()).map(|_| name))
    .collect()
}
