//! What a host may ask for.

use core::fmt;

use serde::{Deserialize, Serialize};

use super::{Block, Item, Location, Operator, Pass, TelemetrySetting, Value};

/// Something to do. The controller answers each with what it did, and what limited it.
///
/// [`EStop`](Self::EStop) to [`ClearFaults`](Self::ClearFaults) go to the supervisor. What is done is answered with the
/// state that it led to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Command {
    /// Torque off at once; latched. Never refused: it is executed whatever its session and number, as often as it
    /// comes.
    EStop,
    /// Torque on, at the measured pose. From limp alone.
    Arm,
    /// The rig is lowered, then limp. The supervisor never refuses it.
    Disarm,
    /// Follow a feed.
    Play(Feed),
    /// Stand where it was commanded last.
    Hold,
    /// The rig goes to its rest pose, is lowered, then limp. In maintenance and while arming it is lowered at once. The
    /// supervisor never refuses it.
    Stop,
    /// Ranges are found by hand, until [`Stop`](Self::Stop) or [`Disarm`](Self::Disarm). From limp alone.
    Calibrate,
    /// Poses are shown by hand, torque off, until [`Stop`](Self::Stop) or [`Disarm`](Self::Disarm). From limp alone.
    Teach,
    /// An operator takes the rig for maintenance, and nobody else may move or arm it until he or she leaves it. It
    /// moves while fresh [`Stream::HoldToRun`](super::Stream::HoldToRun) and [`Stream::Jog`](super::Stream::Jog) come.
    Maintain(Operator),
    /// The operator gives the rig back: it holds.
    Leave(Operator),
    /// Clear all latched faults. Nothing moves by it.
    ClearFaults,
    /// Choose the show to play. Nothing moves by it: if a show plays, it ends, and the rig holds.
    LoadShow {
        /// Its slot.
        slot: u8,
    },
    /// Delete a show.
    DeleteShow {
        /// Its slot.
        slot: u8,
    },
    /// What telemetry to send, and how often.
    SetTelemetry(TelemetrySetting),
    /// Read a setting.
    ReadSetting {
        /// Its number.
        key: u16,
    },
    /// Write a setting.
    WriteSetting {
        /// Its number.
        key: u16,
        /// Its new value.
        value: Value,
    },
    /// Read from the log of faults.
    ReadFault {
        /// Which one; 0 is the first since faults were cleared, then from the latest back.
        index: u16,
    },
    /// Ask what is stored at a place.
    AskStored(Location),
    /// Begin an upload, or go on with the same one.
    BeginUpload(Item),
    /// Bytes of the upload.
    UploadBlock(Block),
    /// The upload is whole: read it back, compare its SHA-256, and use it.
    EndUpload,
    /// Pass bytes on to servos, and listen. Only while torque is off, and nobody moves the rig by hand. Since 1.1.
    PassOn(Pass),
    /// More of what servos said to the last bytes that were passed on. Since 1.1.
    ReadPassed {
        /// From this byte on.
        offset: u16,
    },
    /// Read what the controller has measured of itself; cycles are counted anew. Since 1.1.
    ReadHealth,
    /// Poses are shown by hand, while the rig carries its own weight, until [`Hold`](Self::Hold), [`Stop`](Self::Stop)
    /// or [`Disarm`](Self::Disarm). From holding alone. For the supervisor, too. Since 1.1.
    Float,
}

/// Who gives poses from outside. Each may fall silent, and then the rig holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Feed {
    /// The show that was chosen by [`Command::LoadShow`].
    Show,
    /// Live frames of this session: [`Stream::Live`](super::Stream::Live).
    Live,
    /// Somebody moves single joints: [`Stream::Jog`](super::Stream::Jog).
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
