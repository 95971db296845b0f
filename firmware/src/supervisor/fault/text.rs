//! Texts of faults for users. They are separate from the table, since a board reports only numbers: unused texts are
//! not linked.

use super::Fault;

impl Fault {
    /// Returns the condition of the fault.
    pub const fn when(self) -> &'static str {
        match self {
            Self::LinkLate => "no valid message came for 0.2 s (setting)",
            Self::LinkLost => "no valid message came for 2 s (setting)",
            Self::ServoSilent => {
                "a servo missed 5 replies in a row (setting), or its reading is too old"
            }
            Self::ServoError => "a servo reports an error: overload, encoder, shock",
            Self::HotMeasured => "a servo is at its own limit of temperature, less 5 degC",
            Self::HotWinding => {
                "by its current, a winding has the heat of the continuous current and more"
            }
            Self::SupplyLow => "the filtered voltage is at a servo's minimum, plus 5 %",
            Self::SupplyHigh => "the filtered voltage is at a servo's maximum, less 5 %",
            Self::FollowingError => {
                "a servo is 15 deg from where it should be, for 0.2 s (settings)"
            }
            Self::Range => "a servo was measured outside of its range",
            Self::NotFinite => "a number is NaN or infinite: a reading, a target, a command",
            Self::Overrun => "more than 3 ticks in 500 took too long (settings)",
            Self::SettingsBad => {
                "settings or rig are unreadable or invalid, or only older ones are complete"
            }
            Self::ShowBad => "the show that is played cannot be read",
            Self::ShowForeign => "the show that is played is of another rig",
            Self::EStop => "the emergency stop is pressed, or was commanded",
            Self::WatchdogReset => "the board begins, since its watchdog has reset it",
            Self::BrownOut => "the board begins, since its own supply broke down",
            Self::Panic => "the board begins, since its program stopped itself",
            Self::ServoStopped => {
                "a servo with torque heard nothing for 0.1 s: its own watchdog has stopped it"
            }
            Self::TorqueStuck => {
                "torque was switched off, and a servo's register says that it is on"
            }
            Self::HostDeaf => {
                "the host acknowledged no telemetry for 2 s (setting of the link lost)"
            }
            Self::Jump => "5 readings in a row of a servo are where it cannot have turned to",
            Self::Swing => {
                "a joint shakes by 0.8 deg and more, 15 to 40 times a second: its gear is too soft for its gains"
            }
        }
    }

    /// Returns the advice for a user.
    pub const fn remedy(self) -> &'static str {
        match self {
            Self::LinkLate => "look at cable and host; play again",
            Self::LinkLost => "look at cable and host",
            Self::ServoSilent => "look at its plug, its id and its supply",
            Self::ServoError => "read the error with `sinew servo`; restart the servo",
            Self::HotMeasured | Self::HotWinding => "let it cool; lighten its load",
            Self::SupplyLow => "a stronger supply, thicker wires, or less at once",
            Self::SupplyHigh => "the right supply, able to absorb the energy of braking",
            Self::FollowingError => "check what holds it, and its load",
            Self::Range => "bring it back by hand; calibrate it",
            Self::NotFinite | Self::WatchdogReset | Self::Panic => "keep the record, and report it",
            Self::Overrun => "a lower rate, a faster bus, or a smaller rig",
            Self::SettingsBad => "upload them again",
            Self::ShowBad => "upload it again",
            Self::ShowForeign => "bake it for this rig",
            Self::EStop => "look why; release it",
            Self::BrownOut => "feed the board apart from the servos",
            Self::ServoStopped => "look at the bus and its cable; keep the record",
            Self::TorqueStuck => "cut its supply; restart the servo, or replace it",
            Self::HostDeaf => "look at the wire from board to host; look at the host",
            Self::Jump => "look at its horn, its encoder's magnet and the bus; calibrate it",
            Self::Swing => {
                "tighten its horn and links; lighten what it moves; `sinew board settings set swing_gain 0.5`"
            }
        }
    }
}
