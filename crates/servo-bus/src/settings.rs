//! What servos must hold in their registers: the one list of it, for whoever writes it and whoever compares it.

use crate::counts::round;
use crate::dynamixel::table::{Only, address as dxl};
use crate::feetech::table::address as feetech;
use crate::table::{Item, Range};
use crate::{dynamixel as dynamixel_servos, feetech as feetech_servos};

/// What a servo controls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// Position within a turn.
    #[default]
    Position,
    /// Position with a limit of current.
    CurrentPosition,
    /// Current.
    Current,
    /// PWM.
    Pwm,
}

/// What a rig asks of a servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoRequirements {
    /// What it controls.
    pub mode: Mode,
    /// Least and most position, rad: zero where its encoder counts zero.
    pub range_rad: [f32; 2],
    /// The most torque that it is asked for, N m.
    pub torque_nm: f32,
    /// Its torque at stall, N m.
    pub stall_nm: f32,
    /// What its friction takes, N m.
    pub friction_nm: f32,
    /// Torque per current, N m/A.
    pub torque_constant_nm_a: f32,
    /// Where its kind switches itself off, degC.
    pub shutdown_c: f32,
    /// Its P gain of position over the factory's: see [`p_gain`].
    pub gain_ratio: f32,
}

/// A register, and what it must hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// The register.
    pub item: Item,
    /// What it must hold.
    pub raw: i32,
}

/// What a register must hold.
#[derive(Debug, Clone, Copy)]
enum RequiredValue {
    /// This.
    Exact(i32),
    /// What the factory sets.
    Factory,
    /// The factory's value, times the ratio of the gain.
    Gain,
    /// The number of the mode.
    Mode,
    /// The temperature at which it switches itself off.
    Shutdown,
    /// The current of the torque that is asked for; as the factory sets it where that is all it has.
    Current,
    /// The part of its torque that is asked for, in so many counts.
    TorqueShare(u16),
    /// The least position.
    Min,
    /// The most position.
    Max,
    /// This while torque is off: the bus itself writes it, whoever sets a servo up does not.
    TorqueOff(i32),
}

/// Dynamixel: the servo answers after 2 us. The factory's 500 us make a bus of 6 a third as fast.
const DYNAMIXEL_DELAY: i32 = 1;
/// Dynamixel: a servo with torque that hears nothing for this many times 20 ms stops by itself.
pub(crate) const DYNAMIXEL_WATCHDOG: u8 = 5;
/// Feetech: heat, current and overload make it let go, as dumps of new STS3215 have it.
const STS_UNLOADING: i32 = 44;
/// What no register holds: a mode that a servo does not have is never the one it is in.
const NO_MODE: i32 = -1;
/// A range may end so much of a count beyond one: the rounding of f32, and of whoever wrote the range in degrees.
const SLACK: f32 = 0.02;

/// By address. A model without a register has one less. Drive mode 0: neither turned round (the rig's `direction` does
/// that), nor timed, nor on by a goal. Startup 0: limp at power-up, until somebody arms it. Status level 2, all is
/// answered: the level that a servo has after each power-on, and it costs nothing, for the bus writes to all at once.
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

/// By address. The highest supply differs by type: it is left alone.
const STS: [(u8, RequiredValue); 13] = [
    (feetech::RETURN_DELAY, RequiredValue::Exact(0)),
    (feetech::MIN_POSITION, RequiredValue::Min),
    (feetech::MAX_POSITION, RequiredValue::Max),
    (feetech::MAX_TEMPERATURE, RequiredValue::Shutdown),
    (feetech::MIN_VOLTAGE, RequiredValue::Factory),
    (feetech::MAX_TORQUE, RequiredValue::TorqueShare(1000)),
    (feetech::UNLOADING, RequiredValue::Exact(STS_UNLOADING)),
    (feetech::POSITION_P, RequiredValue::Gain),
    (feetech::POSITION_D, RequiredValue::Factory),
    (feetech::POSITION_I, RequiredValue::Factory),
    (feetech::OPERATING_MODE, RequiredValue::Mode),
    (feetech::TORQUE_ENABLE, RequiredValue::TorqueOff(0)),
    (feetech::TORQUE_LIMIT, RequiredValue::TorqueShare(1000)),
];

/// By address. What the factory sets in an SCS is not known, and it has no register for its mode.
const SCS: [(u8, RequiredValue); 6] = [
    (feetech::RETURN_DELAY, RequiredValue::Exact(0)),
    (feetech::MIN_POSITION, RequiredValue::Min),
    (feetech::MAX_POSITION, RequiredValue::Max),
    (feetech::MAX_TEMPERATURE, RequiredValue::Shutdown),
    (feetech::MAX_TORQUE, RequiredValue::TorqueShare(1000)),
    (feetech::TORQUE_ENABLE, RequiredValue::TorqueOff(0)),
];

// The same with their items, put together at build time: a board has these, and not the whole tables with all names.
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

/// What a Dynamixel must hold, by address: mode, return delay, status level, limits, shutdown, gains.
///
/// What neither rig nor kind says is as the factory sets it. Id, baud and homing offset are left alone.
pub fn dynamixel(
    table: dynamixel_servos::table::Table,
    requirements: ServoRequirements,
) -> impl Iterator<Item = Setting> + Clone {
    dynamixel_of(table, requirements, false)
}

/// The same, and what it holds besides before it is armed: torque off, and its watchdog set.
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
    // A servo that measures current is limited there; one in PWM mode by whoever commands it, since its PWM is both
    // torque and speed.
    let is_full = table.model.current.is_some() || requirements.mode == Mode::Pwm;
    let share = if is_full { 1.0 } else { requirements.share() };
    DYNAMIXEL_ITEMS.iter().filter(move |(_, _, must)| must.counts(is_limp)).filter_map(
        move |(only, item, must)| {
            Some(requirements.setting(table.own(*only, item)?, *must, mode, share))
        },
    )
}

/// What a Feetech must hold, by address, as [`dynamixel`] has it.
pub fn feetech(
    family: feetech_servos::Family,
    requirements: ServoRequirements,
) -> impl Iterator<Item = Setting> + Clone {
    feetech_of(family, requirements, false)
}

/// The same, and torque off, which it must be before it is armed.
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

/// Returns what a register of a P gain holds for a ratio to what the factory sets.
pub fn p_gain(item: Item, ratio: f32) -> i32 {
    let bounds = match item.range {
        Range::Between(_, most) => [1, most],
        _ => [1, i32::MAX],
    };
    round(item.initial as f32 * ratio, bounds)
}

impl RequiredValue {
    /// Whether it is asked for: what a bus writes itself is only while torque is off.
    fn counts(self, is_limp: bool) -> bool {
        is_limp || !matches!(self, Self::TorqueOff(_))
    }
}

impl ServoRequirements {
    /// What part of its torque is asked for.
    fn share(&self) -> f32 {
        (self.torque_nm / self.stall_nm).clamp(0.0, 1.0)
    }

    /// A number beyond a register's range is held at the end.
    fn setting(&self, item: Item, must: RequiredValue, mode: i32, share: f32) -> Setting {
        let scale = item.unit.scale;
        let whole = |value: f32| round(value, [0, i32::MAX]);
        let raw = match must {
            RequiredValue::Exact(raw) | RequiredValue::TorqueOff(raw) => raw,
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
        Setting { item, raw }
    }
}
