//! Servos, and the data of their kinds.

use serde::{Deserialize, Serialize};

use crate::servo::{Address, SignalLoss};

/// A servo of the rig.
#[derive(Debug, Clone, PartialEq)]
pub struct Servo {
    /// Name of the servo; unique among servos.
    pub name: String,
    /// Name of the servo's kind, see [`ServoModel::built_in`].
    pub model: String,
    /// Name of the bus that it is connected to.
    pub bus: String,
    /// Address on the bus.
    pub address: Address,
    /// 1 if positive turns of servo and drive agree, -1 if they are opposite.
    pub direction: i8,
    /// Servo's own position when the drive is at zero, rad. Default: 0.
    pub offset_rad: Option<f64>,
    /// Value of the servo's register Homing Offset, rad. `None`: the value in the servo is kept.
    pub homing_offset_rad: Option<f64>,
    /// Turns of the servo for one turn of the output that the drive uses. Default: 1.
    pub gear: f64,
    /// Measured pulses of a hobby servo at its least position, at position zero, and at its greatest position, us.
    /// Default: the pulses of its kind.
    pub pulse_us: Option<[f64; 3]>,
    /// Measured angle between the first and the last of these pulses, rad. Default: the pulses' difference times the
    /// angle per us of the kind.
    pub travel_rad: Option<f64>,
    /// Permitted range of the servo's own position: one pair. If it is empty, the range is that of the servo's
    /// kind.
    pub range_rad: Vec<[f64; 2]>,
    /// Maximum commanded torque, N m. Default: stall torque of its kind.
    pub torque_nm: Option<f64>,
    /// Maximum commanded speed, rad/s. Default: no-load speed of its kind.
    pub speed_rad_s: Option<f64>,
    /// Maximum commanded acceleration, rad/s². Default: no limit.
    pub acceleration_rad_s2: Option<f64>,
    /// Value of the register of the position P gain, in the unit of the register. Default: derived from
    /// [`Stiffness`](crate::stiffness::Stiffness).
    pub p_gain: Option<u16>,
    /// Action of the servo when commands stop.
    pub on_signal_loss: SignalLoss,
}

impl Default for Servo {
    fn default() -> Self {
        Self {
            name: String::new(),
            model: String::new(),
            bus: "main".to_owned(),
            address: Address::Id(0),
            direction: 1,
            offset_rad: None,
            homing_offset_rad: None,
            gear: 1.0,
            pulse_us: None,
            travel_rad: None,
            range_rad: Vec::new(),
            torque_nm: None,
            speed_rad_s: None,
            acceleration_rad_s2: None,
            p_gain: None,
            on_signal_loss: SignalLoss::Limp,
        }
    }
}

/// Data of a kind of servo, at its output shaft.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ServoModel {
    /// The maker's name for this kind of servo, such as `XL330-M288-T`.
    pub name: String,
    /// Voltage at which the values are valid, V.
    pub voltage_v: SourcedValue,
    /// Torque per current, N m/A.
    pub torque_constant_nm_a: SourcedValue,
    /// Torque at standstill and full voltage, N m.
    pub stall_torque_nm: SourcedValue,
    /// Current at standstill, A.
    pub stall_current_a: SourcedValue,
    /// Torque that the servo holds continuously without overheating, N m.
    pub continuous_torque_nm: SourcedValue,
    /// Speed without load, rad/s.
    pub no_load_speed_rad_s: SourcedValue,
    /// Torque per position error of its own controller, N m/rad; zero without such a controller.
    pub position_gain_nm_rad: SourcedValue,
    /// Inertia of the rotor, seen through the gear, kg m².
    pub rotor_inertia_kg_m2: SourcedValue,
    /// Coulomb friction, N m.
    pub friction_nm: SourcedValue,
    /// Viscous friction, N m s.
    pub damping_nm_s: SourcedValue,
    /// Smallest step of the servo's position, rad.
    pub resolution_rad: SourcedValue,
    /// Play of the gear from end to end, rad.
    pub backlash_rad: SourcedValue,
    /// Range of the output from end to end, rad.
    pub range_rad: SourcedValue,
    /// Temperature rise of the motor per power lost in it, K/W.
    pub thermal_resistance_k_w: SourcedValue,
    /// Time constant of the temperature rise, s.
    pub thermal_time_s: SourcedValue,
    /// Temperature at which the servo shuts down, °C.
    pub shutdown_c: SourcedValue,
    /// Stiffness of the gear between rotor and output, N m/rad; see [`Self::gear_stiffness`].
    pub gear_stiffness_nm_rad: Option<SourcedValue>,
    /// Damping of the gear between rotor and output, N m s; see [`Self::gear_damping`].
    pub gear_damping_nm_s: Option<SourcedValue>,
    /// Share of the Coulomb friction that acts at the output, 0 to 1; see [`Self::output_friction_share`].
    pub output_friction_share: Option<SourcedValue>,
    /// Pulse of a hobby servo at its least position, us. [`Pulses`](super::Pulses) has the default.
    pub pulse_least_us: Option<SourcedValue>,
    /// Pulse of a hobby servo at position zero, us.
    pub pulse_middle_us: Option<SourcedValue>,
    /// Pulse of a hobby servo at its greatest position, us.
    pub pulse_most_us: Option<SourcedValue>,
}

/// Default twist of a gear at stall torque, rad.
const WINDUP_RAD: f64 = 0.0175;
/// Default damping of a gear, as a share of the critical damping.
const DAMPING_RATIO: f64 = 0.3;
/// Default share of the Coulomb friction that acts at the output.
const OUTPUT_SHARE: f64 = 0.3;

impl ServoModel {
    /// Returns the stiffness of the gear between rotor and output, N m/rad. Default: a twist of 0.0175 rad (1 deg)
    /// at stall torque.
    pub fn gear_stiffness(&self) -> f64 {
        let given = self.gear_stiffness_nm_rad.as_ref();
        given.map_or(self.stall_torque_nm.value / WINDUP_RAD, |given| given.value)
    }

    /// Returns the damping of the gear between rotor and output, N m s. Default: 0.3 of the critical damping
    /// between the rotor and a load of the rotor's inertia J: `2 * 0.3 * sqrt(stiffness * J / 2)`.
    pub fn gear_damping(&self) -> f64 {
        self.gear_damping_nm_s.as_ref().map_or_else(
            || {
                let both_kg_m2 = 0.5 * self.rotor_inertia_kg_m2.value;
                2.0 * DAMPING_RATIO * (self.gear_stiffness() * both_kg_m2).sqrt()
            },
            |given| given.value,
        )
    }

    /// Returns the damping of the rotor by the winding when the servo is driven by voltage, N m s: torque constant
    /// times back-EMF constant (the same number) over the resistance.
    pub fn winding_damping(&self) -> f64 {
        let resistance_ohm = self.voltage_v.value / self.stall_current_a.value;
        self.torque_constant_nm_a.value * self.torque_constant_nm_a.value / resistance_ohm
    }

    /// Returns the share of the Coulomb friction that acts at the output shaft, after the gear; the rest acts at
    /// the rotor. Default: 0.3.
    pub fn output_friction_share(&self) -> f64 {
        self.output_friction_share.as_ref().map_or(OUTPUT_SHARE, |given| given.value)
    }

    /// Returns the angle from the middle of the gear's play to an end of the play, at the output, rad.
    pub fn half_play_rad(&self) -> f64 {
        0.5 * self.backlash_rad.value
    }

    /// Derives the motor's constants from the maker's figures; `None` if the figures contradict each other. At no-load
    /// speed, back-EMF and friction use the whole supply voltage. At stall, the output has less torque than the stall
    /// current makes: the difference is friction, which grows with the load. `stiction_nm` is the friction at rest,
    /// without load.
    pub fn motor(&self, stiction_nm: f64) -> Option<MotorFigures> {
        let [volts, amps] = [self.voltage_v.value, self.stall_current_a.value];
        let [stall_nm, speed] = [self.stall_torque_nm.value, self.no_load_speed_rad_s.value];
        let resistance_ohm = volts / amps;
        // k w + R f / k = V, where the motor alone overcomes the friction f: f / (1 - load friction). The load
        // friction is found with it, by iteration.
        let drag_nm = self.friction_nm.value + self.damping_nm_s.value * speed;
        let (mut constant, mut load) = (volts / speed, 0.0);
        for _ in 0..ROUNDS {
            let square = volts * volts - 4.0 * speed * resistance_ohm * drag_nm / (1.0 - load);
            if square < 0.0 {
                return None;
            }
            constant = (volts + square.sqrt()) / (2.0 * speed);
            load = (constant * amps - stiction_nm - stall_nm) / (constant * amps + stall_nm);
        }
        Some(MotorFigures { torque_constant_nm_a: constant, load_friction: load })
    }

    /// Returns all values that the kind has, each with its key.
    pub fn values(&self) -> Vec<(&'static str, SourcedValue)> {
        let mut copy = self.clone();
        let needed: Vec<_> =
            copy.values_mut().into_iter().map(|(key, value)| (key, value.clone())).collect();
        let optional = copy.optional_values_mut();
        let given = optional.into_iter().filter_map(|(key, value)| Some((key, value.clone()?)));
        needed.into_iter().chain(given).collect()
    }

    /// Returns the optional values, each with its key.
    pub(crate) fn optional_values_mut(&mut self) -> [(&'static str, &mut Option<SourcedValue>); 6] {
        [
            ("gear_stiffness_nm_rad", &mut self.gear_stiffness_nm_rad),
            ("gear_damping_nm_s", &mut self.gear_damping_nm_s),
            ("output_friction_share", &mut self.output_friction_share),
            ("pulse_least_us", &mut self.pulse_least_us),
            ("pulse_middle_us", &mut self.pulse_middle_us),
            ("pulse_most_us", &mut self.pulse_most_us),
        ]
    }

    /// Returns the required values, each with its key.
    pub(crate) fn values_mut(&mut self) -> [(&'static str, &mut SourcedValue); 16] {
        [
            ("voltage_v", &mut self.voltage_v),
            ("torque_constant_nm_a", &mut self.torque_constant_nm_a),
            ("stall_torque_nm", &mut self.stall_torque_nm),
            ("stall_current_a", &mut self.stall_current_a),
            ("continuous_torque_nm", &mut self.continuous_torque_nm),
            ("no_load_speed_rad_s", &mut self.no_load_speed_rad_s),
            ("position_gain_nm_rad", &mut self.position_gain_nm_rad),
            ("rotor_inertia_kg_m2", &mut self.rotor_inertia_kg_m2),
            ("friction_nm", &mut self.friction_nm),
            ("damping_nm_s", &mut self.damping_nm_s),
            ("resolution_rad", &mut self.resolution_rad),
            ("backlash_rad", &mut self.backlash_rad),
            ("range_rad", &mut self.range_rad),
            ("thermal_resistance_k_w", &mut self.thermal_resistance_k_w),
            ("thermal_time_s", &mut self.thermal_time_s),
            ("shutdown_c", &mut self.shutdown_c),
        ]
    }
}

/// Constants of a motor, derived from its maker's figures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorFigures {
    /// Torque per current before friction, N m/A; also the back-EMF constant, V s/rad.
    pub torque_constant_nm_a: f64,
    /// Friction per torque that enters the gear, from either end.
    pub load_friction: f64,
}

/// Number of iterations. Each reduces the error by the load friction's share of the drag, which is below 0.5.
const ROUNDS: usize = 60;

/// A value and its source.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SourcedValue {
    /// Value in the unit of the field's name.
    pub value: f64,
    /// Source that measured or states the value; "guess: ..." without a source.
    pub source: String,
}

impl SourcedValue {
    /// Returns whether the value has no source.
    pub fn is_guess(&self) -> bool {
        self.source.starts_with("guess")
    }
}
