//! Servos, and what their kinds can do.

use serde::{Deserialize, Serialize};

use crate::servo::{Address, SignalLoss};

/// One servo.
#[derive(Debug, Clone, PartialEq)]
pub struct Servo {
    /// What people call it; unique among servos.
    pub name: String,
    /// A kind of servo, see [`ServoModel::built_in`].
    pub model: String,
    /// The bus that it hangs on.
    pub bus: String,
    /// Where on the bus.
    pub address: Address,
    /// 1 if its positive turn is the drive's, -1 if it is mirrored.
    pub direction: i8,
    /// Its own position where the drive has zero.
    pub offset_rad: Option<f64>,
    /// Turns of the servo for a turn of the output that the drive sees. Default: 1.
    pub gear: f64,
    /// How far it may go, by its own position: one pair. Empty: as its kind.
    pub range_rad: Vec<[f64; 2]>,
    /// The most torque that it is asked for, N m. Default: as its kind.
    pub torque_nm: Option<f64>,
    /// The largest speed that it is asked for.
    pub speed_rad_s: Option<f64>,
    /// The largest acceleration that it is asked for.
    pub acceleration_rad_s2: Option<f64>,
    /// Value of its register of the P gain of position, in its own numbers. Default: by
    /// [`Stiffness`](crate::stiffness::Stiffness).
    pub p_gain: Option<u16>,
    /// What it does when commands stop.
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
            gear: 1.0,
            range_rad: Vec::new(),
            torque_nm: None,
            speed_rad_s: None,
            acceleration_rad_s2: None,
            p_gain: None,
            on_signal_loss: SignalLoss::Limp,
        }
    }
}

/// What a kind of servo can do, at its output shaft.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ServoModel {
    /// What its maker calls it.
    pub name: String,
    /// Voltage that the values are for, V.
    pub voltage_v: SourcedValue,
    /// Torque per current, N m/A.
    pub torque_constant_nm_a: SourcedValue,
    /// Torque at standstill and full voltage, N m.
    pub stall_torque_nm: SourcedValue,
    /// Current at standstill, A.
    pub stall_current_a: SourcedValue,
    /// Torque that it holds for long without overheating, N m.
    pub continuous_torque_nm: SourcedValue,
    /// Speed without load, rad/s.
    pub no_load_speed_rad_s: SourcedValue,
    /// Torque per position error of its own controller, N m/rad; zero if it has none.
    pub position_gain_nm_rad: SourcedValue,
    /// Inertia of the rotor as the gear shows it, kg m².
    pub rotor_inertia_kg_m2: SourcedValue,
    /// Coulomb friction, N m.
    pub friction_nm: SourcedValue,
    /// Viscous friction, N m s.
    pub damping_nm_s: SourcedValue,
    /// Least step of its position, rad.
    pub resolution_rad: SourcedValue,
    /// Play of the gear, from end to end, rad.
    pub backlash_rad: SourcedValue,
    /// How far it turns, from end to end, rad.
    pub range_rad: SourcedValue,
    /// Warming of the motor per power lost in it, K/W.
    pub thermal_resistance_k_w: SourcedValue,
    /// Time constant of that, s.
    pub thermal_time_s: SourcedValue,
    /// Temperature at which it shuts down, °C.
    pub shutdown_c: SourcedValue,
    /// Stiffness of the gear between rotor and output, N m/rad; see [`Self::gear_stiffness`].
    pub gear_stiffness_nm_rad: Option<SourcedValue>,
    /// Damping of the gear between rotor and output, N m s; see [`Self::gear_damping`].
    pub gear_damping_nm_s: Option<SourcedValue>,
    /// Part of the Coulomb friction that is at the output, 0 to 1; see [`Self::output_friction_share`].
    pub output_friction_share: Option<SourcedValue>,
}

/// How far a gear winds up at stall torque, rad.
const WINDUP_RAD: f64 = 0.0175;
/// Damping of a gear, as a part of the critical one.
const DAMPING_RATIO: f64 = 0.3;
/// Part of the friction that is at the output.
const OUTPUT_SHARE: f64 = 0.3;

impl ServoModel {
    /// Returns the stiffness of the gear between rotor and output, N m/rad. Without a value of its own the gear winds
    /// up by 0.0175 rad, 1 deg, at stall torque.
    pub fn gear_stiffness(&self) -> f64 {
        let given = self.gear_stiffness_nm_rad.as_ref();
        given.map_or(self.stall_torque_nm.value / WINDUP_RAD, |given| given.value)
    }

    /// Returns the damping of the gear between rotor and output, N m s. Without a value of its own it is 0.3 of the
    /// critical damping between the rotor and a load of the rotor's inertia J: `2 * 0.3 * sqrt(stiffness * J / 2)`.
    pub fn gear_damping(&self) -> f64 {
        self.gear_damping_nm_s.as_ref().map_or_else(
            || {
                let both_kg_m2 = 0.5 * self.rotor_inertia_kg_m2.value;
                2.0 * DAMPING_RATIO * (self.gear_stiffness() * both_kg_m2).sqrt()
            },
            |given| given.value,
        )
    }

    /// Returns what the winding damps the rotor by where the servo is driven by voltage, N m s: torque constant times
    /// back-EMF, which is the same number, over the resistance.
    pub fn winding_damping(&self) -> f64 {
        let resistance_ohm = self.voltage_v.value / self.stall_current_a.value;
        self.torque_constant_nm_a.value * self.torque_constant_nm_a.value / resistance_ohm
    }

    /// Returns the part of the Coulomb friction that is at the output shaft, after the gear; the rest is at the rotor.
    /// Without a value of its own it is 0.3.
    pub fn output_friction_share(&self) -> f64 {
        self.output_friction_share.as_ref().map_or(OUTPUT_SHARE, |given| given.value)
    }

    /// Returns how far the output turns from the middle of the gear's play to an end of it, rad.
    pub fn half_play_rad(&self) -> f64 {
        0.5 * self.backlash_rad.value
    }

    /// Returns what follows of the motor from the maker's figures, if they go together: at no-load speed the supply
    /// gives back-EMF and what friction takes, and at stall friction that grows with the load takes what is missing.
    /// `stiction_nm` is the friction at rest, without load.
    pub fn motor(&self, stiction_nm: f64) -> Option<MotorFigures> {
        let [volts, amps] = [self.voltage_v.value, self.stall_current_a.value];
        let [stall_nm, speed] = [self.stall_torque_nm.value, self.no_load_speed_rad_s.value];
        let resistance_ohm = volts / amps;
        // k w + R f / k = V, where friction f is overcome by the motor alone: f / (1 - load friction). The motor's
        // share is found with it, in a few rounds.
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

    /// Returns the values that a kind may leave out, each with its key.
    pub(crate) fn optional_values_mut(&mut self) -> [(&'static str, &mut Option<SourcedValue>); 3] {
        [
            ("gear_stiffness_nm_rad", &mut self.gear_stiffness_nm_rad),
            ("gear_damping_nm_s", &mut self.gear_damping_nm_s),
            ("output_friction_share", &mut self.output_friction_share),
        ]
    }

    /// Returns the values that every kind has, each with its key.
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

/// Figures of a motor that follow from its maker's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorFigures {
    /// Torque per current before friction, N m/A; also its back-EMF, V s/rad.
    pub torque_constant_nm_a: f64,
    /// Friction per torque that goes into the gear at either end.
    pub load_friction: f64,
}

/// Each makes the error smaller by the load friction's share of the drag, which is below a half.
const ROUNDS: usize = 60;

/// A value, and where it is from.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SourcedValue {
    /// In the unit of the field's name.
    pub value: f64,
    /// Who measured or states it; "guess: ..." if nobody does.
    pub source: String,
}

impl SourcedValue {
    /// Whether nobody has measured or stated it.
    pub fn is_guess(&self) -> bool {
        self.source.starts_with("guess")
    }
}
