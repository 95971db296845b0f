//! The registers of all models, by address.

use crate::table::Range::{Any, Between, PlusMinus, Within};
use crate::table::{Item, MemoryMap, RAD_S_PER_RPM, Sign, TORQUE_ENABLE, Unit};

/// Addresses that this crate itself uses.
pub mod address {
    /// Address of the model number.
    pub const MODEL_NUMBER: u16 = 0;
    /// Address of the firmware version.
    pub const FIRMWARE: u16 = 6;
    /// Address of the id.
    pub const ID: u16 = 7;
    /// Address of the baud rate code.
    pub const BAUD: u16 = 8;
    /// Address of the return delay, in 2 us.
    pub const RETURN_DELAY: u16 = 9;
    /// Address of the drive mode: direction, type of profile, torque on by a goal.
    pub const DRIVE_MODE: u16 = 10;
    /// Address of the operating mode.
    pub const OPERATING_MODE: u16 = 11;
    /// Address of a second id, which a servo obeys but does not answer.
    pub const SECONDARY_ID: u16 = 12;
    /// Address of the temperature limit.
    pub const TEMPERATURE_LIMIT: u16 = 31;
    /// Address of the maximum supply voltage.
    pub const MAX_VOLTAGE: u16 = 32;
    /// Address of the minimum supply voltage.
    pub const MIN_VOLTAGE: u16 = 34;
    /// Address of the PWM limit.
    pub const PWM_LIMIT: u16 = 36;
    /// Address of the current limit.
    pub const CURRENT_LIMIT: u16 = 38;
    /// Address of the velocity limit.
    pub const VELOCITY_LIMIT: u16 = 44;
    /// Address of the maximum position.
    pub const MAX_POSITION: u16 = 48;
    /// Address of the minimum position.
    pub const MIN_POSITION: u16 = 52;
    /// Address of the behaviour at power-up.
    pub const STARTUP: u16 = 60;
    /// Address of the mask of hardware errors that switch torque off.
    pub const SHUTDOWN: u16 = 63;
    /// Address of the torque switch.
    pub const TORQUE_ENABLE: u16 = 64;
    /// Address of the status level, which decides what is answered: 0 only pings, 1 pings and reads, 2 all.
    pub const STATUS_LEVEL: u16 = 68;
    /// Address of the flag that a registered write waits for an action.
    pub const REGISTERED: u16 = 69;
    /// Address of the hardware errors, bit by bit.
    pub const HARDWARE_ERROR: u16 = 70;
    /// Address of the position D gain.
    pub const POSITION_D: u16 = 80;
    /// Address of the position I gain.
    pub const POSITION_I: u16 = 82;
    /// Address of the position P gain.
    pub const POSITION_P: u16 = 84;
    /// Address of the feedforward gain for acceleration.
    pub const FEEDFORWARD_2ND: u16 = 88;
    /// Address of the feedforward gain for speed.
    pub const FEEDFORWARD_1ST: u16 = 90;
    /// Address of the bus watchdog, in 20 ms; -1 when it has expired.
    pub const BUS_WATCHDOG: u16 = 98;
    /// Address of the goal PWM.
    pub const GOAL_PWM: u16 = 100;
    /// Address of the goal current.
    pub const GOAL_CURRENT: u16 = 102;
    /// Address of the goal velocity.
    pub const GOAL_VELOCITY: u16 = 104;
    /// Address of the profile velocity. The goal position follows it in memory.
    pub const PROFILE_VELOCITY: u16 = 112;
    /// Address of the goal position.
    pub const GOAL_POSITION: u16 = 116;
    /// Address of the flag that the servo moves.
    pub const MOVING: u16 = 122;
    /// Address of the present current, or load in models without a current sensor.
    pub const PRESENT_CURRENT: u16 = 126;
    /// Address of the present velocity.
    pub const PRESENT_VELOCITY: u16 = 128;
    /// Address of the present position.
    pub const PRESENT_POSITION: u16 = 132;
    /// Address of the present supply voltage.
    pub const PRESENT_VOLTAGE: u16 = 144;
    /// Address of the present temperature.
    pub const PRESENT_TEMPERATURE: u16 = 146;
}

/// Bits of the register Drive Mode. Source: e-manual, Drive Mode.
pub mod drive_mode {
    /// Clockwise counts as positive.
    pub const REVERSE: i32 = 1;
    /// The servo follows another one as the slave of a dual joint: MX-106 only.
    pub const SLAVE: i32 = 1 << 1;
    /// Profile velocity and acceleration are times, ms.
    pub const TIME_BASED: i32 = 1 << 2;
    /// A new goal switches torque on.
    pub const ON_BY_GOAL: i32 = 1 << 3;
}

/// The models that have a register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Only {
    All,
    /// Models that measure current.
    Current,
    /// Models that do not measure current: they report load instead.
    Load,
    X330,
    X540,
    /// All models of the X series.
    X,
    Mx,
}

/// Full PWM in counts: the whole supply voltage.
pub(crate) const FULL_PWM: u16 = 885;
pub(in crate::dynamixel) const PWM_COUNTS: i32 = FULL_PWM as i32;
pub(in crate::dynamixel) const POSITION: Unit =
    Unit { symbol: "rad", scale: core::f32::consts::TAU / 4096.0 };
pub(in crate::dynamixel) const VELOCITY: Unit =
    Unit { symbol: "rad/s", scale: 0.229 * RAD_S_PER_RPM };
const ACCELERATION: Unit = Unit { symbol: "rad/s2", scale: 214.577 * RAD_S_PER_RPM / 60.0 };
const PWM: Unit = Unit { symbol: "1", scale: 1.0 / PWM_COUNTS as f32 };
const TWO_MICROSECONDS: Unit = Unit { symbol: "s", scale: 2e-6 };
const MILLISECOND: Unit = Unit { symbol: "s", scale: 1e-3 };
const TWENTY_MILLISECONDS: Unit = Unit { symbol: "s", scale: 0.02 };

const MAP: MemoryMap = MemoryMap { ram_from: address::TORQUE_ENABLE };

const fn signed(item: Item) -> Item {
    Item { sign: Sign::TwosComplement, ..item }
}

/// All registers, with values common to all models. [`super::Table`] fills in what differs by model.
pub(super) const ITEMS: &[(Only, Item)] = &[
    (Only::All, MAP.read(0, 2, "Model Number", Unit::NONE)),
    (Only::All, MAP.read(2, 4, "Model Information", Unit::NONE)),
    (Only::All, MAP.read(6, 1, "Firmware Version", Unit::NONE)),
    (Only::All, MAP.write(7, 1, "ID", Unit::NONE, Between(0, 252), 1)),
    (Only::All, MAP.write(8, 1, "Baud Rate", Unit::NONE, Between(0, 7), 1)),
    (Only::All, MAP.write(9, 1, "Return Delay Time", TWO_MICROSECONDS, Between(0, 254), 250)),
    (Only::All, MAP.write(10, 1, "Drive Mode", Unit::NONE, Between(0, 13), 0)),
    (Only::All, MAP.write(11, 1, "Operating Mode", Unit::NONE, Between(0, 16), 3)),
    (Only::All, MAP.write(12, 1, "Secondary(Shadow) ID", Unit::NONE, Between(0, 255), 255)),
    (Only::All, MAP.write(13, 1, "Protocol Type", Unit::NONE, Between(1, 22), 2)),
    (
        Only::All,
        signed(MAP.write(20, 4, "Homing Offset", POSITION, Between(-1_044_479, 1_044_479), 0)),
    ),
    (Only::All, MAP.write(24, 4, "Moving Threshold", VELOCITY, Between(0, 1_023), 10)),
    (Only::All, MAP.write(31, 1, "Temperature Limit", Unit::CELSIUS, Between(0, 100), 80)),
    (Only::All, MAP.write(32, 2, "Max Voltage Limit", Unit::DECIVOLT, Any, 0)),
    (Only::All, MAP.write(34, 2, "Min Voltage Limit", Unit::DECIVOLT, Any, 0)),
    (Only::All, MAP.write(36, 2, "PWM Limit", PWM, Between(0, PWM_COUNTS), PWM_COUNTS)),
    (Only::Current, MAP.write(38, 2, "Current Limit", Unit::NONE, Any, 0)),
    (Only::Mx, MAP.write(40, 4, "Acceleration Limit", ACCELERATION, Between(0, 32_767), 32767)),
    (Only::All, MAP.write(44, 4, "Velocity Limit", VELOCITY, Between(0, 1_023), 0)),
    (Only::All, MAP.write(48, 4, "Max Position Limit", POSITION, Between(0, 4_095), 4095)),
    (Only::All, MAP.write(52, 4, "Min Position Limit", POSITION, Between(0, 4_095), 0)),
    (Only::X540, MAP.write(56, 1, "External Port Mode 1", Unit::NONE, Between(0, 3), 3)),
    (Only::X540, MAP.write(57, 1, "External Port Mode 2", Unit::NONE, Between(0, 3), 3)),
    (Only::X540, MAP.write(58, 1, "External Port Mode 3", Unit::NONE, Between(0, 3), 3)),
    (Only::X, MAP.write(60, 1, "Startup Configuration", Unit::NONE, Between(0, 3), 0)),
    (Only::X330, MAP.write(62, 1, "PWM Slope", Unit::NONE, Between(1, 255), 140)),
    (Only::All, MAP.write(63, 1, "Shutdown", Unit::NONE, Any, 52)),
    (Only::All, MAP.write(64, 1, TORQUE_ENABLE, Unit::NONE, Between(0, 1), 0)),
    (Only::All, MAP.write(65, 1, "LED", Unit::NONE, Between(0, 1), 0)),
    (Only::All, MAP.write(68, 1, "Status Return Level", Unit::NONE, Between(0, 2), 2)),
    (Only::All, MAP.read(69, 1, "Registered Instruction", Unit::NONE)),
    (Only::All, MAP.read(70, 1, "Hardware Error Status", Unit::NONE)),
    (Only::All, MAP.write(76, 2, "Velocity I Gain", Unit::NONE, Between(0, 16_383), 1920)),
    (Only::All, MAP.write(78, 2, "Velocity P Gain", Unit::NONE, Between(0, 16_383), 100)),
    (Only::All, MAP.write(80, 2, "Position D Gain", Unit::NONE, Between(0, 16_383), 0)),
    (Only::All, MAP.write(82, 2, "Position I Gain", Unit::NONE, Between(0, 16_383), 0)),
    (Only::All, MAP.write(84, 2, "Position P Gain", Unit::NONE, Between(0, 16_383), 800)),
    (Only::All, MAP.write(88, 2, "Feedforward 2nd Gain", Unit::NONE, Between(0, 16_383), 0)),
    (Only::All, MAP.write(90, 2, "Feedforward 1st Gain", Unit::NONE, Between(0, 16_383), 0)),
    (Only::All, signed(MAP.write(98, 1, "Bus Watchdog", TWENTY_MILLISECONDS, Between(0, 127), 0))),
    (
        Only::All,
        signed(MAP.write(100, 2, "Goal PWM", PWM, PlusMinus(address::PWM_LIMIT), PWM_COUNTS)),
    ),
    (
        Only::Current,
        signed(MAP.write(102, 2, "Goal Current", Unit::NONE, PlusMinus(address::CURRENT_LIMIT), 0)),
    ),
    (
        Only::All,
        signed(MAP.write(104, 4, "Goal Velocity", VELOCITY, PlusMinus(address::VELOCITY_LIMIT), 0)),
    ),
    (Only::All, MAP.write(108, 4, "Profile Acceleration", ACCELERATION, Between(0, 32_767), 0)),
    (Only::All, MAP.write(112, 4, "Profile Velocity", VELOCITY, Between(0, 32_767), 0)),
    (
        Only::All,
        signed(MAP.write(
            116,
            4,
            "Goal Position",
            POSITION,
            Within(address::MIN_POSITION, address::MAX_POSITION),
            0,
        )),
    ),
    (Only::All, MAP.read(120, 2, "Realtime Tick", MILLISECOND)),
    (Only::All, MAP.read(122, 1, "Moving", Unit::NONE)),
    (Only::All, MAP.read(123, 1, "Moving Status", Unit::NONE)),
    (Only::All, signed(MAP.read(124, 2, "Present PWM", PWM))),
    (Only::Current, signed(MAP.read(126, 2, "Present Current", Unit::NONE))),
    (Only::Load, signed(MAP.read(126, 2, "Present Load", Unit::PER_MILLE))),
    (Only::All, signed(MAP.read(128, 4, "Present Velocity", VELOCITY))),
    (Only::All, signed(MAP.read(132, 4, "Present Position", POSITION))),
    (Only::All, signed(MAP.read(136, 4, "Velocity Trajectory", VELOCITY))),
    (Only::All, signed(MAP.read(140, 4, "Position Trajectory", POSITION))),
    (Only::All, MAP.read(144, 2, "Present Input Voltage", Unit::DECIVOLT)),
    (Only::All, MAP.read(146, 1, "Present Temperature", Unit::CELSIUS)),
    (Only::X, MAP.read(147, 1, "Backup Ready", Unit::NONE)),
    (Only::X540, MAP.write(152, 2, "External Port Data 1", Unit::NONE, Any, 0)),
    (Only::X540, MAP.write(154, 2, "External Port Data 2", Unit::NONE, Any, 0)),
    (Only::X540, MAP.write(156, 2, "External Port Data 3", Unit::NONE, Any, 0)),
];
