//! Text messages between page and hub: JSON objects with a `type`. Angles are in rad, lengths in m.

use serde::{Deserialize, Serialize};

/// A message of a page, or of a program that drives. The answer to it has the number `id`; without a number there is no
/// answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct FromPage {
    pub(crate) id: Option<u64>,
    #[serde(flatten)]
    pub(crate) command: PageCommand,
}

/// A command of a page. Every page may hold, stop, e-stop, and ask for the wheel; the other commands are for the page
/// that has the wheel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum PageCommand {
    /// The first message of a page.
    Hello {
        /// The token, which shows that the console's user has opened the page.
        token: String,
    },
    /// The page is still open.
    Ping {
        /// Any number; it is returned.
        t: f64,
    },
    /// The rig holds where it is.
    Hold,
    /// The rig goes to its rest pose and is lowered; then torque is off.
    Stop,
    /// Torque goes off at once.
    EStop,
    /// The page takes the wheel, or gives it back.
    Wheel {
        /// Whether the page takes the wheel.
        take: bool,
    },
    /// The rig is armed.
    Arm,
    /// The rig is lowered where it is.
    Lower,
    /// The rig goes to its home pose.
    Home,
    /// All latched faults are cleared.
    Clear,
    /// A show is played.
    Play {
        /// Slot of the show.
        slot: u8,
        /// Whether the show begins again when it is over.
        #[serde(default, rename = "loop")]
        is_loop: bool,
        /// Number of rounds of a loop; then the answer follows at the end of the show. 0 for a page.
        #[serde(default)]
        rounds: u32,
    },
    /// The rig goes to a pose. The answer follows at the end of the motion.
    Goto {
        /// Coordinates.
        q: Vec<f32>,
        /// Shortest time of the motion, s.
        seconds: f64,
    },
    /// The rig follows a pose; the program sends the next one before the board holds.
    Live {
        /// Coordinates.
        q: Vec<f32>,
    },
    /// The answer is the state of the rig, as a [`Report`](sinew_board_client::console::Report).
    State,
    /// The answer is the board's log of faults; for programs.
    Faults,
    /// Idle life starts, or ends.
    Idle {
        /// Whether it starts.
        on: bool,
    },
    /// A pose of a show is drawn as a ghost.
    Seek {
        /// Time in the show, s; `None` removes the ghost.
        t: Option<f64>,
        /// Slot of the show; `None`: the loaded show.
        slot: Option<u8>,
    },
    /// The rig goes to a pose of a show.
    Follow {
        /// Time in the show, s.
        t: f64,
        /// Slot of the show; `None`: the loaded show.
        slot: Option<u8>,
    },
    /// The goal of a slider; the page repeats it while the slider is held.
    Jog {
        /// Index of the dof.
        dof: usize,
        /// Goal, rad or m.
        goal: f64,
    },
    /// A slider was released.
    Release {
        /// Index of the dof.
        dof: usize,
    },
    /// Begins a recording of the session in a new file, or ends it.
    Record {
        /// Whether it begins.
        on: bool,
    },
    /// The next binary message is a show. A program sends the show's bytes after the line of this message.
    Upload {
        /// Name for lists.
        name: String,
        /// Slot whose show is replaced; `None`: a free slot.
        slot: Option<u8>,
        /// Number of bytes that a program sends.
        #[serde(default)]
        bytes: usize,
    },
}

/// A text message of the hub.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub(crate) enum ToPage<'a> {
    Shows {
        slots: &'a [Slot],
        loaded: Option<u8>,
        /// Idle life of the console; `None` if it has none.
        idle: Option<IdleState<'a>>,
    },
    /// `driver`: whether this page drives; `asked`: another page has asked this page for the wheel.
    Role {
        driver: bool,
        other: Option<&'static str>,
        asked: bool,
    },
    Event {
        t: f64,
        level: Level,
        text: &'a str,
        fault: Option<u8>,
        joint: Option<&'a str>,
    },
    Answer {
        id: u64,
        ok: bool,
        text: &'a str,
    },
    /// The file into which the session is recorded; `None`: it is not recorded.
    Record {
        file: Option<&'a str>,
    },
    Progress {
        what: &'static str,
        done: f32,
    },
    Pong {
        t: f64,
    },
}

/// The importance of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Level {
    Info,
    Warning,
    Fault,
    Error,
}

/// State of idle life.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct IdleState<'a> {
    pub(crate) name: &'a str,
    pub(crate) on: bool,
}

/// A slot of the board that has a show.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Slot {
    #[serde(rename = "slot")]
    pub(crate) index: u8,
    pub(crate) name: String,
    /// SHA-256 of the show; a recording has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) hash: Option<[u8; 32]>,
    /// Duration, s; `None` if this program does not know the show's bytes.
    pub(crate) duration_s: Option<f32>,
    pub(crate) cues: Vec<CueMark>,
    /// Sound of the show, if it has a sound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) sound: Option<SlotSound>,
}

/// Sound of a show in a slot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct SlotSound {
    /// SHA-256 of the file, by which pages request it.
    pub(crate) hash: String,
    pub(crate) name: String,
    /// Time of the sound at the start of the show, s.
    pub(crate) offset_s: f64,
}

/// A cue of a show.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct CueMark {
    /// Time from the start, s.
    pub(crate) t: f32,
    pub(crate) name: String,
}

impl ToPage<'_> {
    /// Returns the message as JSON text.
    pub(crate) fn json(&self) -> String {
        // Numbers that are not finite become `null`.
        serde_json::to_string(self).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_those_of_the_page() {
        let read = |text: &str| serde_json::from_str::<FromPage>(text);
        let jog = read(r#"{"type":"jog","dof":2,"goal":0.5,"id":7}"#).unwrap();
        assert_eq!(jog, FromPage { id: Some(7), command: PageCommand::Jog { dof: 2, goal: 0.5 } });
        assert_eq!(read(r#"{"type":"estop"}"#).unwrap().command, PageCommand::EStop);
        let play = read(r#"{"type":"play","slot":0,"loop":true}"#).unwrap().command;
        assert_eq!(play, PageCommand::Play { slot: 0, is_loop: true, rounds: 0 });
        assert_eq!(
            read(r#"{"type":"seek","t":null}"#).unwrap().command,
            PageCommand::Seek { t: None, slot: None }
        );
        for bad in [
            r#"{"type":"jog","dof":-1,"goal":0}"#,
            r#"{"type":"jog","dof":1,"goal":1e999}"#,
            "{}",
            "[]",
        ] {
            assert!(read(bad).is_err(), "{bad}");
        }
        let role = ToPage::Role { driver: true, other: None, asked: false }.json();
        assert_eq!(role, r#"{"type":"role","driver":true,"other":null,"asked":false}"#);
    }
}
