//! The reply to a ping, or the reason why none arrived.

use sinew_servo_bus::dynamixel;

use crate::Table;
use crate::reply::Reply;

/// The reason why there is no reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Miss {
    Silence,
    Noise,
}

/// Model and firmware of the servo that answered a ping.
#[derive(Debug, Clone)]
pub(crate) struct Pong {
    pub(crate) number: u16,
    pub(crate) firmware: String,
    pub(crate) table: Option<Table>,
    pub(crate) dynamixel_firmware: u8,
}

impl Pong {
    pub(crate) fn of_dynamixel(reply: &Reply) -> Option<Self> {
        let &[low, high, firmware] = reply.data.as_slice() else { return None };
        let number = u16::from_le_bytes([low, high]);
        let table = dynamixel::table::Table::of(number, firmware).map(Table::Dynamixel);
        Some(Self { number, firmware: firmware.to_string(), table, dynamixel_firmware: firmware })
    }

    pub(crate) fn of_feetech(reply: &Reply) -> Option<Self> {
        let &[major, minor, _, low, high] = reply.data.as_slice() else { return None };
        let table = Table::of_feetech([low, high]);
        let number = u16::from_le_bytes([low, high]);
        Some(Self { number, firmware: format!("{major}.{minor}"), table, dynamixel_firmware: 0 })
    }
}
