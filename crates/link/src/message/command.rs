//! Commands of a host.

use core::fmt;

use serde::{Deserialize, Serialize};

use super::{Block, Item, Location, Operator, Pass, TelemetrySetting, Value};

/// A command. The controller answers each with its outcome, and with the limit that reduced it.
///
/// Commands from [`EStop`](Self::EStop) to [`ClearFaults`](Self::ClearFaults) go to the supervisor. The answer to an
/// executed command contains the resulting state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Command {
    /// Torque is switched off at once, and a fault is latched. The command is never refused: it is executed for any
    /// session and number, every time it arrives.
    EStop,
    /// Torque is switched on at the measured pose. Allowed only in the state limp.
    Arm,
    /// The rig is lowered, and is then limp. The supervisor never refuses this command.
    Disarm,
    /// The rig follows a feed.
    Play(Feed),
    /// The rig holds its last commanded pose.
    Hold,
    /// The rig moves to its rest pose, is lowered, and is then limp. In maintenance and while arming, the rig is
    /// lowered at once. The supervisor never refuses this command.
    Stop,
    /// Ranges are found by moving the rig by hand, until [`Stop`](Self::Stop) or [`Disarm`](Self::Disarm). Allowed
    /// only in the state limp.
    Calibrate,
    /// Poses are shown by hand with torque off, until [`Stop`](Self::Stop) or [`Disarm`](Self::Disarm). Allowed
    /// only in the state limp.
    Teach,
    /// An operator takes the rig for maintenance. Nobody else may move or arm it until the operator leaves it. The
    /// rig moves while fresh [`Stream::HoldToRun`](super::Stream::HoldToRun) and [`Stream::Jog`](super::Stream::Jog)
    /// arrive.
    Maintain(Operator),
    /// The operator gives the rig back, and it holds its pose.
    Leave(Operator),
    /// All latched faults are cleared. Nothing moves.
    ClearFaults,
    /// Selects the show to play. Nothing moves. If a show is playing, it ends, and the rig holds its pose.
    LoadShow {
        /// Slot of the show.
        slot: u8,
    },
    /// Deletes a show.
    DeleteShow {
        /// Slot of the show.
        slot: u8,
    },
    /// Sets the parts of telemetry, and their rate.
    SetTelemetry(TelemetrySetting),
    /// Reads a setting.
    ReadSetting {
        /// Key of the setting.
        key: u16,
    },
    /// Writes a setting.
    WriteSetting {
        /// Key of the setting.
        key: u16,
        /// New value.
        value: Value,
    },
    /// Reads a record from the log of faults.
    ReadFault {
        /// Index of the record. 0 is the first fault since faults were cleared, 1 is the latest fault, and so on to the
        /// earliest; after them comes the last warning. Without a fault since faults were cleared, 0 is the last
        /// warning.
        index: u16,
    },
    /// Asks which item is stored at a location.
    AskStored(Location),
    /// Starts an upload, or continues the same upload.
    BeginUpload(Item),
    /// Transfers bytes of the upload.
    UploadBlock(Block),
    /// Ends the upload: the controller reads it back, compares its SHA-256, and uses it.
    EndUpload,
    /// Passes bytes on to servos, and receives their reply. Allowed only while torque is off and nobody moves the
    /// rig by hand. Since version 1.1.
    PassOn(Pass),
    /// Reads more of the servos' reply to the last bytes that were passed on. Since version 1.1.
    ReadPassed {
        /// Offset of the first byte to read.
        offset: u16,
    },
    /// Reads the controller's measurements of itself, and restarts the counts of cycles. Since version 1.1.
    ReadHealth,
    /// Poses are shown by hand while the rig carries its own weight, until [`Hold`](Self::Hold), [`Stop`](Self::Stop)
    /// or [`Disarm`](Self::Disarm). Allowed only in the state holding. This command goes to the supervisor, too.
    /// Since version 1.1.
    Float,
}

/// A source of poses. If a feed falls silent, the rig holds its pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Feed {
    /// The show that [`Command::LoadShow`] selected.
    Show,
    /// Live frames of this session: [`Stream::Live`](super::Stream::Live).
    Live,
    /// Motion of single joints by an operator: [`Stream::Jog`](super::Stream::Jog).
    Jog,
}

impl fmt::Display for Feed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Show => "show",
            Self::Live => "live",
            Self::Jog => "jog",
        })
    }
}
