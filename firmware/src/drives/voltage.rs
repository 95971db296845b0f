//! Servos in PWM mode: the voltage that drives the current for the effort.

use sinew_core::tracker::Timing;
use sinew_rig::servo::Servo;
use sinew_servo_bus::Command;

use super::{
    Class, Condition, CurrentDrive, CurrentSettings, Encoder, Limit, Refused, ServoCommand,
    ShaftTarget,
};
use crate::SettingError;

/// Smallest plausible part of the expected supply. A lower reading is not used: division by it would give full duty.
const LEAST_SUPPLY: f32 = 0.5;

/// Settings of a servo in PWM mode.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct VoltageSettings {
    /// The settings of current mode: encoder, feed-forward of friction, maximum current in the winding, limits by
    /// heat.
    pub current: CurrentSettings,
    /// Resistance of motor and bridge: supply voltage divided by stall current, ohm.
    pub resistance_ohm: f32,
    /// Back-EMF per speed of the servo's own shaft: supply voltage divided by speed without load, V s/rad.
    pub back_emf_v_s: f32,
    /// Supply voltage that is assumed until the servo reports it, V.
    pub supply_v: f32,
}

/// Voltage control. The duty is a voltage divided by the supply voltage. The voltage is the current of a
/// [`CurrentDrive`] multiplied by the winding's resistance, plus the back-EMF at the wanted speed.
///
/// The back-EMF of the *measured* speed is not compensated: a joint that is faster than its target is braked by the
/// motor itself, without delay by the bus.
///
/// The last reading of speed limits the motor's current to that of current mode. The duty is limited to the part of
/// the supply that the servo's own torque and speed need. If the servo is hot, its current fades to zero: it gets the
/// back-EMF of the measured speed, and coasts. Without fresh readings the whole voltage fades, and beyond an end of
/// the range it is zero: the winding is shorted, and brakes. O(1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VoltageDrive {
    effort: CurrentDrive,
    resistance_ohm: f32,
    back_emf_v_s: f32,
    supply_v: f32,
    /// Maximum voltage at standstill, V.
    most_v: f32,
    most_duty: f32,
}

impl VoltageDrive {
    /// Minimum control rate, Hz: the same as in current mode, since the tracker closes the same loop.
    pub const LEAST_HZ: f32 = Class::Voltage.least_hz();

    /// Creates the drive of a servo. `timing` is the tracker's timing, see [`CurrentDrive::new`].
    ///
    /// # Errors
    /// [`Refused`], as in [`CurrentDrive::new`].
    pub fn new(servo: &Servo, settings: &VoltageSettings, timing: Timing) -> Result<Self, Refused> {
        let effort = CurrentDrive::of_class(Class::Voltage, servo, &settings.current, timing)?;
        SettingError::check("resistance_ohm", settings.resistance_ohm, [1e-3, 1e3])?;
        SettingError::check("back_emf_v_s", settings.back_emf_v_s, [0.0, 1e3])?;
        SettingError::check("supply_v", settings.supply_v, [1.0, 100.0])?;
        let VoltageSettings { resistance_ohm, back_emf_v_s, supply_v, .. } = *settings;
        let own = servo.settings();
        // The servo's own torque limits the current, too.
        let most_a = settings.current.current_a.min(own.torque_nm / own.torque_constant_nm_a);
        let most_v = resistance_ohm * most_a;
        let most_duty = ((most_v + back_emf_v_s * own.speed_rad_s) / supply_v).min(1.0);
        Ok(Self { effort, resistance_ohm, back_emf_v_s, supply_v, most_v, most_duty })
    }

    /// Restarts the drive: the current rises from zero.
    pub fn begin(&mut self) {
        self.effort.begin();
    }

    /// Computes the command of a tick. Numbers must be finite: [`Drives`](super::Drives) checks them.
    pub fn command(&mut self, target: &ShaftTarget, condition: &Condition) -> ServoCommand {
        let (current_a, mut limit) = self.effort.current(target, condition);
        let (share, cut) = self.effort.share(condition);
        // An old reading does not give the back-EMF, so the whole voltage is faded instead of the current.
        let [of_current, of_voltage] =
            if cut == Some(Limit::Stale) { [1.0, share] } else { [share, 1.0] };
        let wanted_rad_s = self.servo().settings().gear * target.velocity_rad_s;
        let mut volts =
            self.resistance_ohm * of_current * current_a + self.back_emf_v_s * wanted_rad_s;

        if let Some(read) = condition.feedback {
            // The current reaches its maximum if the voltage differs from the back-EMF by this much.
            let most_v = self.most_v * of_current;
            let emf_v = self.back_emf_v_s * read.velocity_rad_s;
            let [least_v, most_v] = [emf_v - most_v, emf_v + most_v];
            if volts < least_v || volts > most_v {
                (volts, limit) = (volts.max(least_v).min(most_v), Some(Limit::Current));
            }
        }
        let supply_v = condition.supply_v.unwrap_or(self.supply_v);
        let mut duty = volts / supply_v.max(LEAST_SUPPLY * self.supply_v);
        let most = self.most_duty;
        if duty.abs() > most {
            (duty, limit) = (duty.max(-most).min(most), Some(Limit::Voltage));
        }
        if self.effort.is_outwards(duty, condition) {
            (duty, limit) = (0.0, Some(Limit::Range));
        }
        ServoCommand { command: Command::Pwm(duty * of_voltage), limit: cut.or(limit) }
    }

    pub(super) fn servo(&self) -> &Servo {
        self.effort.servo()
    }

    pub(super) fn encoder(&self) -> Encoder {
        self.effort.encoder()
    }
}
