//! The protocols of servos.

use sinew_servo_bus::dynamixel::table::BAUDS as DYNAMIXEL_BAUDS;
use sinew_servo_bus::feetech::table::BAUDS as FEETECH_BAUDS;

/// A servo protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Protocol {
    /// Dynamixel protocol 2.0.
    Dynamixel,
    /// Protocol of Feetech STS, SMS and SCS servos.
    Feetech,
}

impl Protocol {
    /// Both protocols.
    pub const ALL: [Self; 2] = [Self::Dynamixel, Self::Feetech];

    /// Returns the baud rates of the protocol, bits per second, the most likely first: the factory rate, then the usual
    /// rates of rigs.
    pub const fn bauds(self) -> [u32; 8] {
        match self {
            Self::Dynamixel => {
                [57_600, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 115_200, 4_500_000, 9_600]
            }
            Self::Feetech => {
                [1_000_000, 500_000, 115_200, 250_000, 128_000, 57_600, 76_800, 38_400]
            }
        }
    }

    /// Returns the name of the protocol.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Dynamixel => "Dynamixel",
            Self::Feetech => "Feetech",
        }
    }

    /// Returns the baud rates by their code in the servo's register.
    pub(crate) const fn baud_codes(self) -> [u32; 8] {
        match self {
            Self::Dynamixel => DYNAMIXEL_BAUDS,
            Self::Feetech => FEETECH_BAUDS,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rate_of_a_register_is_scanned() {
        for protocol in Protocol::ALL {
            let (mut scanned, mut codes) = (protocol.bauds(), protocol.baud_codes());
            scanned.sort_unstable();
            codes.sort_unstable();
            assert_eq!(scanned, codes, "{protocol:?}");
        }
    }
}
