//! The registers of both families, by address.

use super::{address, phase};
use crate::table::Range::{Any, Between};
use crate::table::{Item, MemoryMap, RAD_S_PER_RPM, Sign, TORQUE_ENABLE, Unit};

pub(super) const STS_POSITION: Unit =
    Unit { symbol: "rad", scale: core::f32::consts::TAU / 4096.0 };
/// Position of one SCS count: 300 degrees over 1024 counts. This value is remembered from the SCS0009 data sheet
/// and not checked: measure it.
pub(super) const SCS_POSITION: Unit =
    Unit { symbol: "rad", scale: core::f32::consts::PI * (300.0 / 180.0) / 1024.0 };
/// Speed of one STS count as shipped: one count of position per second. With another setting of Phase it is 50 counts
/// per second: see [`super::Table::speed_counts`].
const STS_SPEED: Unit = Unit { symbol: "rad/s", scale: STS_POSITION.scale };
/// Speed of one count of Maximum Velocity Limit, for every setting of Phase: 0.732 rev/min.
const STS_MOST_SPEED: Unit = Unit { symbol: "rad/s", scale: 0.732 * RAD_S_PER_RPM };
const ACCELERATION: Unit = Unit { symbol: "rad/s2", scale: core::f32::consts::PI * (8.7 / 180.0) };
pub(in crate::feetech) const CURRENT: Unit = Unit { symbol: "A", scale: 0.0065 };
const TWO_MICROSECONDS: Unit = Unit { symbol: "s", scale: 2e-6 };
const TEN_MILLISECONDS: Unit = Unit { symbol: "s", scale: 0.01 };
const MILLISECOND: Unit = Unit { symbol: "s", scale: 1e-3 };

const MAP: MemoryMap = MemoryMap { ram_from: address::TORQUE_ENABLE as u16 };

const fn signed(bit: u8, item: Item) -> Item {
    Item { sign: Sign::Magnitude(bit), ..item }
}

/// Registers of STS and SMS servos.
pub(super) const STS: &[Item] = &[
    MAP.read(0, 1, "Firmware Major Version", Unit::NONE),
    MAP.read(1, 1, "Firmware Minor Version", Unit::NONE),
    MAP.read(2, 1, "Endianness", Unit::NONE),
    MAP.read(3, 2, "Model Number", Unit::NONE),
    MAP.write(5, 1, "ID", Unit::NONE, Between(0, 253), 1),
    MAP.write(6, 1, "Baud Rate", Unit::NONE, Between(0, 7), 0),
    MAP.write(7, 1, "Return Delay Time", TWO_MICROSECONDS, Between(0, 253), 0),
    MAP.write(8, 1, "Response Status Level", Unit::NONE, Between(0, 1), 1),
    MAP.write(9, 2, "Min Position Limit", STS_POSITION, Between(0, 4_094), 0),
    MAP.write(11, 2, "Max Position Limit", STS_POSITION, Between(0, 4_095), 4095),
    MAP.write(13, 1, "Max Temperature Limit", Unit::CELSIUS, Between(0, 100), 70),
    MAP.write(14, 1, "Max Voltage Limit", Unit::DECIVOLT, Between(0, 254), 140),
    MAP.write(15, 1, "Min Voltage Limit", Unit::DECIVOLT, Between(0, 254), 40),
    MAP.write(16, 2, "Max Torque Limit", Unit::PER_MILLE, Between(0, 1_000), 1000),
    MAP.write(18, 1, "Phase", Unit::NONE, Between(0, 254), phase::SHIPPED),
    MAP.write(19, 1, "Unloading Condition", Unit::NONE, Between(0, 254), 0),
    MAP.write(20, 1, "LED Alarm Condition", Unit::NONE, Between(0, 254), 0),
    MAP.write(21, 1, "P Coefficient", Unit::NONE, Between(0, 254), 32),
    MAP.write(22, 1, "D Coefficient", Unit::NONE, Between(0, 254), 32),
    MAP.write(23, 1, "I Coefficient", Unit::NONE, Between(0, 254), 0),
    MAP.write(24, 1, "Minimum Startup Force", Unit::PER_MILLE, Between(0, 254), 0),
    MAP.write(25, 1, "Integral Limit", Unit::NONE, Between(0, 254), 0),
    MAP.write(26, 1, "CW Dead Zone", STS_POSITION, Between(0, 16), 1),
    MAP.write(27, 1, "CCW Dead Zone", STS_POSITION, Between(0, 16), 1),
    MAP.write(28, 2, "Protection Current", CURRENT, Between(0, 2_047), 511),
    MAP.write(30, 1, "Angular Resolution", Unit::NONE, Between(1, 128), 1),
    signed(11, MAP.write(31, 2, "Homing Offset", STS_POSITION, Between(-2_047, 2_047), 0)),
    MAP.write(33, 1, "Operating Mode", Unit::NONE, Between(0, 3), 0),
    MAP.write(34, 1, "Protective Torque", Unit::PER_CENT, Between(0, 254), 20),
    MAP.write(35, 1, "Protection Time", TEN_MILLISECONDS, Between(0, 254), 200),
    MAP.write(36, 1, "Overload Torque", Unit::PER_CENT, Between(0, 254), 80),
    MAP.write(37, 1, "Velocity P Coefficient", Unit::NONE, Between(0, 254), 0),
    MAP.write(38, 1, "Over Current Protection Time", TEN_MILLISECONDS, Between(0, 254), 200),
    MAP.write(39, 1, "Velocity I Coefficient", Unit::NONE, Between(0, 254), 0),
    MAP.write(40, 1, TORQUE_ENABLE, Unit::NONE, Between(0, 128), 0),
    MAP.write(41, 1, "Acceleration", ACCELERATION, Between(0, 254), 0),
    signed(15, MAP.write(42, 2, "Goal Position", STS_POSITION, Between(-32_767, 32_767), 0)),
    signed(10, MAP.write(44, 2, "Goal Time", Unit::PER_MILLE, Between(-1_000, 1_000), 0)),
    signed(15, MAP.write(46, 2, "Goal Velocity", STS_SPEED, Between(-32_767, 32_767), 0)),
    MAP.write(48, 2, "Torque Limit", Unit::PER_MILLE, Between(0, 1_000), 1000),
    MAP.write(55, 1, "Lock", Unit::NONE, Between(0, 1), 1),
    signed(15, MAP.read(56, 2, "Present Position", STS_POSITION)),
    signed(15, MAP.read(58, 2, "Present Velocity", STS_SPEED)),
    signed(10, MAP.read(60, 2, "Present Load", Unit::PER_MILLE)),
    MAP.read(62, 1, "Present Voltage", Unit::DECIVOLT),
    MAP.read(63, 1, "Present Temperature", Unit::CELSIUS),
    MAP.read(64, 1, "Async Write Flag", Unit::NONE),
    MAP.read(65, 1, "Status", Unit::NONE),
    MAP.read(66, 1, "Moving", Unit::NONE),
    MAP.read(67, 2, "Target Position", STS_POSITION),
    signed(15, MAP.read(69, 2, "Present Current", CURRENT)),
    MAP.read(80, 1, "Moving Velocity Threshold", Unit::NONE),
    MAP.read(81, 1, "DTs", Unit::NONE),
    MAP.read(82, 1, "Velocity Unit Factor", Unit::NONE),
    MAP.read(83, 1, "Hts", Unit::NONE),
    MAP.read(84, 1, "Maximum Velocity Limit", STS_MOST_SPEED),
    MAP.read(85, 1, "Maximum Acceleration", Unit::NONE),
    MAP.read(86, 1, "Acceleration Multiplier", Unit::NONE),
];

/// Registers of SCS servos.
pub(super) const SCS: &[Item] = &[
    MAP.read(0, 1, "Firmware Major Version", Unit::NONE),
    MAP.read(1, 1, "Firmware Minor Version", Unit::NONE),
    MAP.read(3, 2, "Model Number", Unit::NONE),
    MAP.write(5, 1, "ID", Unit::NONE, Between(0, 253), 1),
    MAP.write(6, 1, "Baud Rate", Unit::NONE, Between(0, 7), 0),
    MAP.write(7, 1, "Return Delay Time", TWO_MICROSECONDS, Any, 0),
    MAP.write(8, 1, "Response Status Level", Unit::NONE, Between(0, 1), 1),
    MAP.write(9, 2, "Min Position Limit", SCS_POSITION, Between(0, 1_023), 0),
    MAP.write(11, 2, "Max Position Limit", SCS_POSITION, Between(0, 1_023), 1023),
    MAP.write(13, 1, "Max Temperature Limit", Unit::CELSIUS, Any, 80),
    MAP.write(14, 1, "Max Voltage Limit", Unit::DECIVOLT, Any, 0),
    MAP.write(15, 1, "Min Voltage Limit", Unit::DECIVOLT, Any, 0),
    MAP.write(16, 2, "Max Torque Limit", Unit::PER_MILLE, Between(0, 1_000), 1000),
    MAP.write(18, 1, "Phase", Unit::NONE, Any, 0),
    MAP.write(19, 1, "Unloading Condition", Unit::NONE, Any, 0),
    MAP.write(20, 1, "LED Alarm Condition", Unit::NONE, Any, 0),
    MAP.write(21, 1, "P Coefficient", Unit::NONE, Any, 0),
    MAP.write(22, 1, "D Coefficient", Unit::NONE, Any, 0),
    MAP.write(23, 1, "I Coefficient", Unit::NONE, Any, 0),
    MAP.write(24, 2, "Minimum Startup Force", Unit::NONE, Any, 0),
    MAP.write(26, 1, "CW Dead Zone", SCS_POSITION, Any, 1),
    MAP.write(27, 1, "CCW Dead Zone", SCS_POSITION, Any, 1),
    MAP.write(37, 1, "Protective Torque", Unit::NONE, Any, 0),
    MAP.write(38, 1, "Protection Time", Unit::NONE, Any, 0),
    MAP.write(40, 1, TORQUE_ENABLE, Unit::NONE, Between(0, 128), 0),
    MAP.write(41, 1, "Acceleration", Unit::NONE, Any, 0),
    MAP.write(42, 2, "Goal Position", SCS_POSITION, Between(0, 1_023), 0),
    signed(10, MAP.write(44, 2, "Running Time", MILLISECOND, Between(-1_023, 1_023), 0)),
    signed(15, MAP.write(46, 2, "Goal Velocity", Unit::NONE, Between(-32_767, 32_767), 0)),
    MAP.write(48, 1, "Lock", Unit::NONE, Between(0, 1), 1),
    MAP.read(56, 2, "Present Position", SCS_POSITION),
    signed(15, MAP.read(58, 2, "Present Velocity", Unit::NONE)),
    signed(10, MAP.read(60, 2, "Present Load", Unit::PER_MILLE)),
    MAP.read(62, 1, "Present Voltage", Unit::DECIVOLT),
    MAP.read(63, 1, "Present Temperature", Unit::CELSIUS),
    MAP.read(64, 1, "Sync Write Flag", Unit::NONE),
    MAP.read(65, 1, "Status", Unit::NONE),
    MAP.read(66, 1, "Moving", Unit::NONE),
    MAP.read(78, 1, "PWM Maximum Step", Unit::NONE),
    MAP.read(79, 1, "Moving Velocity Threshold", Unit::NONE),
    MAP.read(80, 1, "DTs", Unit::NONE),
    MAP.read(81, 1, "Minimum Velocity Limit", Unit::NONE),
    MAP.read(82, 1, "Maximum Velocity Limit", Unit::NONE),
    MAP.read(83, 1, "Acceleration 2", Unit::NONE),
];
