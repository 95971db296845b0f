//! The register values that a rig requires of its servos. One list serves to write the registers and to compare them.

use crate::counts::round;
use crate::dynamixel::table::{Only, address as dxl};
use crate::feetech::table::{address as feetech, phase};
use crate::table::{Item, Range};
use crate::{dynamixel as dynamixel_servos, feetech as feetech_servos};

/// Operating mode: the quantity that a servo controls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// Position within one turn.
    #[default]
    Position,
    /// Position with a current limit.
    CurrentPosition,
    /// Current, without position control.
    Current,
    /// PWM, without position or current control.
    Pwm,
}

/// The requirements of a rig for one servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoRequirements {
    /// Operating mode.
    pub mode: Mode,
    /// Minimum and maximum position, rad, zero where the encoder counts zero.
    pub range_rad: [f32; 2],
    /// Maximum torque that the rig needs, N m.
    pub torque_nm: f32,
    /// Stall torque of the servo, N m.
    pub stall_nm: f32,
    /// Friction torque of the servo, N m.
    pub friction_nm: f32,
    /// Torque for each ampere of current, N m/A.
    pub torque_constant_nm_a: f32,
    /// Temperature at which this kind of servo switches itself off, degC.
    pub shutdown_c: f32,
    /// Position P gain, as a ratio to the factory's: see [`p_gain`].
    pub gain_ratio: f32,
}

/// A register and its required value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// Register that must hold the value.
    pub item: Item,
    /// Required value, in counts.
    pub raw: i32,
    /// Bits of the value that matter: all, or those that change what goals and readings mean.
    pub mask: i32,
}

impl Setting {
    /// Returns the value to write to the register if it holds `found`. The result is `found` if that is already right.
    pub const fn wanted(&self, found: i32) -> i32 {
        (found & !self.mask) | (self.raw & self.mask)
    }
}

/// A rule for the required value of a register.
#[derive(Debug, Clone, Copy)]
enum RequiredValue {
    /// Exactly this value, in counts.
    Exact(i32),
    /// This value in some bits; the others are the servo's own.
    Bits {
        /// Required value.
        raw: i32,
        /// Bits that must hold it.
        mask: i32,
    },
    /// The factory's value.
    Factory,
    /// The factory's value, times the gain ratio.
    Gain,
    /// The number of the operating mode.
    Mode,
    /// The temperature at which the servo switches itself off.
    Shutdown,
    /// The current for the required torque; the factory's value if the rig needs the servo's full torque.
    Current,
    /// The required share of the servo's torque; full torque is this number of counts.
    TorqueShare(u16),
    /// The minimum position.
    Min,
    /// The maximum position.
    Max,
    /// This value, which counts only while torque is off. The bus itself writes it; a tool that sets up servos does
    /// not.
    TorqueOff(i32),
}

/// Dynamixel: return delay of 2 us. With the factory's 500 us, a bus of 6 servos has a third of the rate.
const DYNAMIXEL_DELAY: i32 = 1;
/// Dynamixel: watchdog time in 20 ms. A servo with torque on that receives nothing for this time stops by itself.
pub(crate) const DYNAMIXEL_WATCHDOG: u8 = 5;
/// Feetech: excess temperature, current and overload switch torque off, as in dumps of new STS3215.
const STS_UNLOADING: i32 = 44;
/// A value that no register holds, for a mode that the servo does not have: the comparison then always fails.
const NO_MODE: i32 = -1;
/// Tolerance at the ends of a range, in counts, for the rounding of f32 and of ranges written in degrees.
const SLACK: f32 = 0.02;

/// Requirements for a Dynamixel, by address. A register that a model lacks is skipped. Drive mode 0: not reversed (the
/// rig's `direction` reverses), not time-based, and not switched on by a goal. Startup 0: torque off at power-up, until
/// the rig is armed. Status level 2: all instructions are answered. A servo has this level after each power-on, and it
/// costs nothing, because the bus writes to all servos at once.
const DYNAMIXEL: [(u16, RequiredValue); 20] = [
    (dxl::RETURN_DELAY, RequiredValue::Exact(DYNAMIXEL_DELAY)),
    (dxl::DRIVE_MODE, RequiredValue::Exact(0)),
    (dxl::OPERATING_MODE, RequiredValue::Mode),
    (dxl::TEMPERATURE_LIMIT, RequiredValue::Shutdown),
    (dxl::MAX_VOLTAGE, RequiredValue::Factory),
    (dxl::MIN_VOLTAGE, RequiredValue::Factory),
    (dxl::PWM_LIMIT, RequiredValue::TorqueShare(dynamixel_servos::table::FULL_PWM)),
    (dxl::CURRENT_LIMIT, RequiredValue::Current),
    (dxl::MAX_POSITION, RequiredValue::Max),
    (dxl::MIN_POSITION, RequiredValue::Min),
    (dxl::STARTUP, RequiredValue::Exact(0)),
    (dxl::SHUTDOWN, RequiredValue::Factory),
    (dxl::TORQUE_ENABLE, RequiredValue::TorqueOff(0)),
    (dxl::STATUS_LEVEL, RequiredValue::Factory),
    (dxl::POSITION_D, RequiredValue::Factory),
    (dxl::POSITION_I, RequiredValue::Factory),
    (dxl::POSITION_P, RequiredValue::Gain),
    (dxl::FEEDFORWARD_2ND, RequiredValue::Factory),
    (dxl::FEEDFORWARD_1ST, RequiredValue::Factory),
    (dxl::BUS_WATCHDOG, RequiredValue::TorqueOff(DYNAMIXEL_WATCHDOG as i32)),
];

/// Feetech: a count of speed is a count of position per second, goals without a speed are fastest, positions stay
/// within a turn, and nothing is reversed (the rig's `direction` reverses).
const STS_PHASE: RequiredValue =
    RequiredValue::Bits { raw: phase::SHIPPED, mask: phase::MEANING as i32 };

/// Requirements for an STS, by address. The maximum supply is not compared, because it differs by type.
const STS: [(u8, RequiredValue); 14] = [
    (feetech::RETURN_DELAY, RequiredValue::Exact(0)),
    (feetech::MIN_POSITION, RequiredValue::Min),
    (feetech::MAX_POSITION, RequiredValue::Max),
    (feetech::MAX_TEMPERATURE, RequiredValue::Shutdown),
    (feetech::MIN_VOLTAGE, RequiredValue::Factory),
    (feetech::MAX_TORQUE, RequiredValue::TorqueShare(1000)),
    (feetech::PHASE, STS_PHASE),
    (feetech::UNLOADING, RequiredValue::Exact(STS_UNLOADING)),
    (feetech::POSITION_P, RequiredValue::Gain),
    (feetech::POSITION_D, RequiredValue::Factory),
    (feetech::POSITION_I, RequiredValue::Factory),
    (feetech::OPERATING_MODE, RequiredValue::Mode),
    (feetech::TORQUE_ENABLE, RequiredValue::TorqueOff(0)),
    (feetech::TORQUE_LIMIT, RequiredValue::TorqueShare(1000)),
];

/// Requirements for an SCS, by address. The factory settings of SCS servos are not known, and they have no mode
/// register.
const SCS: [(u8, RequiredValue); 6] = [
    (feetech::RETURN_DELAY, RequiredValue::Exact(0)),
    (feetech::MIN_POSITION, RequiredValue::Min),
    (feetech::MAX_POSITION, RequiredValue::Max),
    (feetech::MAX_TEMPERATURE, RequiredValue::Shutdown),
    (feetech::MAX_TORQUE, RequiredValue::TorqueShare(1000)),
    (feetech::TORQUE_ENABLE, RequiredValue::TorqueOff(0)),
];

// The lists above with their registers, built at compile time: a board needs only these, not whole tables with all
// names.
static DYNAMIXEL_ITEMS: [(Only, Item, RequiredValue); DYNAMIXEL.len()] = dynamixel_items(DYNAMIXEL);
static STS_ITEMS: [(Item, RequiredValue); STS.len()] =
    feetech_items(feetech_servos::Family::Sts, STS);
static SCS_ITEMS: [(Item, RequiredValue); SCS.len()] =
    feetech_items(feetech_servos::Family::Scs, SCS);

#[expect(clippy::indexing_slicing, clippy::arithmetic_side_effects, reason = "at build time")]
const fn dynamixel_items<const N: usize>(
    list: [(u16, RequiredValue); N],
) -> [(Only, Item, RequiredValue); N] {
    let (only, item) = dynamixel_servos::table::of_all(list[0].0);
    let mut items = [(only, item, list[0].1); N];
    let mut index = 1;
    while index < N {
        let (address, must) = list[index];
        let (only, item) = dynamixel_servos::table::of_all(address);
        items[index] = (only, item, must);
        index += 1;
    }
    items
}

#[expect(clippy::indexing_slicing, clippy::arithmetic_side_effects, reason = "at build time")]
const fn feetech_items<const N: usize>(
    family: feetech_servos::Family,
    list: [(u8, RequiredValue); N],
) -> [(Item, RequiredValue); N] {
    let mut items = [(family.item(list[0].0), list[0].1); N];
    let mut index = 1;
    while index < N {
        let (address, must) = list[index];
        items[index] = (family.item(address), must);
        index += 1;
    }
    items
}

/// Returns the requirements for a Dynamixel, by address: mode, return delay, status level, limits, shutdown, gains.
///
/// A register that neither the rig nor the kind specifies must hold its factory value. Id, baud rate and homing offset
/// are not compared.
pub fn dynamixel(
    table: dynamixel_servos::table::Table,
    requirements: ServoRequirements,
) -> impl Iterator<Item = Setting> + Clone {
    dynamixel_of(table, requirements, false)
}

/// Returns the requirements like [`dynamixel()`], plus those that apply before arming: torque is off, and the
/// watchdog is set.
pub(crate) fn dynamixel_limp(
    table: dynamixel_servos::table::Table,
    requirements: ServoRequirements,
) -> impl Iterator<Item = Setting> + Clone {
    dynamixel_of(table, requirements, true)
}

fn dynamixel_of(
    table: dynamixel_servos::table::Table,
    requirements: ServoRequirements,
    is_limp: bool,
) -> impl Iterator<Item = Setting> + Clone {
    let mode = match requirements.mode {
        Mode::Current => 0,
        Mode::Position => 3,
        Mode::CurrentPosition => 5,
        Mode::Pwm => 16,
    };
    // A servo that measures current is limited by its current. A servo in PWM mode is limited by the controller, since
    // its PWM determines both torque and speed.
    let is_full = table.model.current.is_some() || requirements.mode == Mode::Pwm;
    let share = if is_full { 1.0 } else { requirements.share() };
    DYNAMIXEL_ITEMS.iter().filter(move |(_, _, must)| must.counts(is_limp)).filter_map(
        move |(only, item, must)| {
            Some(requirements.setting(table.own(*only, item)?, *must, mode, share))
        },
    )
}

/// Returns the requirements for a Feetech, by address, like [`dynamixel`].
pub fn feetech(
    family: feetech_servos::Family,
    requirements: ServoRequirements,
) -> impl Iterator<Item = Setting> + Clone {
    feetech_of(family, requirements, false)
}

/// Returns the requirements like [`feetech()`], plus the requirement that applies before arming: torque is off.
pub(crate) fn feetech_limp(
    family: feetech_servos::Family,
    requirements: ServoRequirements,
) -> impl Iterator<Item = Setting> + Clone {
    feetech_of(family, requirements, true)
}

fn feetech_of(
    family: feetech_servos::Family,
    requirements: ServoRequirements,
    is_limp: bool,
) -> impl Iterator<Item = Setting> + Clone {
    let mode = match requirements.mode {
        Mode::Position => 0,
        Mode::Pwm => 2,
        Mode::CurrentPosition | Mode::Current => NO_MODE,
    };
    let items: &[(Item, RequiredValue)] = match family {
        feetech_servos::Family::Sts => &STS_ITEMS,
        feetech_servos::Family::Scs => &SCS_ITEMS,
    };
    items
        .iter()
        .filter(move |(_, must)| must.counts(is_limp))
        .map(move |(item, must)| requirements.setting(*item, *must, mode, requirements.share()))
}

/// Returns the value of a P gain register for a ratio to the factory's value.
pub fn p_gain(item: Item, ratio: f32) -> i32 {
    let bounds = match item.range {
        Range::Between(_, most) => [1, most],
        _ => [1, i32::MAX],
    };
    round(item.initial as f32 * ratio, bounds)
}

impl RequiredValue {
    /// Returns whether the rule applies. Registers that the bus itself writes are compared only while torque is off.
    fn counts(self, is_limp: bool) -> bool {
        is_limp || !matches!(self, Self::TorqueOff(_))
    }
}

impl ServoRequirements {
    /// Returns the required share of the servo's torque, 0 to 1.
    fn share(&self) -> f32 {
        (self.torque_nm / self.stall_nm).clamp(0.0, 1.0)
    }

    /// Computes the value of a register. A number beyond the register's range is limited to its end.
    fn setting(&self, item: Item, must: RequiredValue, mode: i32, share: f32) -> Setting {
        let scale = item.unit.scale;
        let whole = |value: f32| round(value, [0, i32::MAX]);
        let raw = match must {
            RequiredValue::Exact(raw)
            | RequiredValue::TorqueOff(raw)
            | RequiredValue::Bits { raw, .. } => raw,
            RequiredValue::Mode => mode,
            RequiredValue::Shutdown => whole(self.shutdown_c / scale),
            RequiredValue::Current if self.share() < 1.0 => {
                whole((self.torque_nm + self.friction_nm) / self.torque_constant_nm_a / scale)
            }
            RequiredValue::Factory | RequiredValue::Current => item.initial,
            RequiredValue::Gain => p_gain(item, self.gain_ratio),
            RequiredValue::TorqueShare(full) => whole(f32::from(full) * share),
            // Rounded inwards.
            RequiredValue::Min => whole(self.range_rad[0] / scale + (0.5 - SLACK)),
            RequiredValue::Max => whole(self.range_rad[1] / scale - (0.5 - SLACK)),
        };
        let raw = match item.range {
            Range::Between(least, most) if raw != NO_MODE => raw.max(least).min(most),
            _ => raw,
        };
        let mask = if let RequiredValue::Bits { mask, .. } = must { mask } else { !0 };
        Setting { item, raw, mask }
    }
}
