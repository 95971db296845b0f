//! Shows on the board: the content of its slots, and poses of shows whose bytes this program has.

use std::sync::Arc;
use std::time::Duration;

use sinew_board_client::{ClientError, Line, item};
use sinew_firmware::node::SHOW_SCHEMA;
use sinew_link::message::{Command, Item, Kind, State};
use sinew_show::{Player, Show};

use super::act::Act;
use super::{Hub, Refused};
use crate::message::{CueMark, IdleState, Slot, SlotSound, ToPage};
use crate::sounds::OwnSound;

/// Name of the approver that a board stores with a show of the console.
pub(super) const APPROVER: &str = "sinew console";
/// Maximum number of coordinates of a show.
const COORDS: usize = 192;

/// A show that this program has read.
#[derive(Debug, Clone)]
pub struct OwnShow {
    /// Name for lists.
    pub name: String,
    /// The show's bytes.
    pub bytes: Arc<[u8]>,
    /// Sound of the show, if it has a sound.
    pub sound: Option<OwnSound>,
}

/// The shows of a console.
#[derive(Debug, Clone, Default)]
pub struct OwnShows {
    /// Shows for the board's slots.
    pub shows: Vec<OwnShow>,
    /// A loop of idle life, which the console itself sends to the board.
    pub idle: Option<OwnShow>,
}

/// The board's slots, and the shows whose bytes this program has.
#[derive(Debug, Default)]
pub(super) struct Shows {
    slots: Vec<Slot>,
    known: Vec<(Item, OwnShow)>,
    /// For each slot whose show is in `known`: the slot, and the index in `known`.
    bytes: Vec<(u8, usize)>,
    /// Slot that was loaded last; `None` if none was loaded.
    pub(super) loaded: Option<u8>,
}

impl Shows {
    /// Remembers a show, so that its name and poses are known wherever it is stored.
    pub(super) fn know(&mut self, item: Item, show: OwnShow) {
        if !self.known.iter().any(|(known, _)| known.hash == item.hash) {
            self.known.push((item, show));
        }
    }

    /// Describes the slots, from the items that the board has in them.
    fn set(&mut self, items: &[Option<Item>]) {
        (self.slots, self.bytes) = (Vec::new(), Vec::new());
        for (slot, item) in items.iter().enumerate() {
            let (Some(item), Ok(slot)) = (item, u8::try_from(slot)) else { continue };
            let known = self.known.iter().position(|(known, _)| known.hash == item.hash);
            let [a, b, c, d, ..] = item.hash;
            let name = format!("slot {slot} ({a:02x}{b:02x}{c:02x}{d:02x})");
            let unknown = Slot {
                index: slot,
                name,
                hash: Some(item.hash),
                duration_s: None,
                cues: Vec::new(),
                sound: None,
            };
            let found = known.and_then(|index| {
                self.bytes.push((slot, index));
                describe(slot, &self.known[index])
            });
            self.slots.push(found.unwrap_or(unknown));
        }
        self.loaded = self.loaded.filter(|slot| self.slots.iter().any(|own| own.index == *slot));
    }

    /// Returns the list of slots, and idle life, as a message.
    pub(super) fn json(&self, idle: Option<IdleState<'_>>) -> String {
        ToPage::Shows { slots: &self.slots, loaded: self.loaded, idle }.json()
    }

    pub(super) fn has(&self, slot: u8) -> bool {
        self.slots.iter().any(|own| own.index == slot)
    }

    /// Returns the bytes of a slot's show; `None` if this program does not have them.
    fn bytes(&self, slot: u8) -> Option<Arc<[u8]>> {
        let (_, index) = self.bytes.iter().find(|(own, _)| *own == slot)?;
        Some(Arc::clone(&self.known[*index].1.bytes))
    }
}

fn describe(slot: u8, (item, own): &(Item, OwnShow)) -> Option<Slot> {
    let show = Show::open(&own.bytes).ok()?;
    let rate_hz = show.rate().hz();
    let cues = show.cues();
    let cues =
        cues.map(|cue| CueMark { t: cue.sample as f32 / rate_hz, name: cue.name.to_owned() });
    let duration_s = Some(show.duration_s());
    let sound = own.sound.as_ref().map(|sound| SlotSound {
        hash: sound.hash.clone(),
        name: sound.name.clone(),
        offset_s: sound.offset_s,
    });
    Some(Slot {
        index: slot,
        name: own.name.clone(),
        hash: Some(item.hash),
        duration_s,
        cues: cues.collect(),
        sound,
    })
}

/// Returns the pose of a show at a time, s; `None` if the show is invalid, or is not of this rig.
fn pose(bytes: &[u8], t: f64, coordinates: usize) -> Option<Vec<f32>> {
    let show = Show::open(bytes).ok()?;
    let t = t.clamp(0.0, f64::from(show.duration_s()));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the show")]
    let at = show.position_at_us((t * 1e6) as u64);
    let mut player = Player::<COORDS>::new(show).ok()?;
    let (mut q, mut qd, mut qdd) = ([0.0; COORDS], [0.0; COORDS], [0.0; COORDS]);
    player.state_at(at, &mut q, &mut qd, &mut qdd).ok()?;
    Some(q.get(..coordinates)?.to_vec())
}

impl<L: Line> Hub<'_, L> {
    /// Reads which shows the slots contain.
    pub(super) fn read_slots(&mut self) -> Result<(), ClientError> {
        let items = self.board.shows()?;
        self.shows.set(&items);
        Ok(())
    }

    /// Uploads a show of the command line, unless the board has it already.
    pub(super) fn put_own(&mut self, show: OwnShow) -> Result<(), ClientError> {
        let rig = self.board.about().rig;
        let item = item(Kind::Show, SHOW_SCHEMA, &show.bytes, rig, APPROVER)?;
        if self.board.slot_of(&item)?.is_none() {
            self.board.upload(&item, &show.bytes, &mut |_| {})?;
        }
        self.shows.know(item, show);
        self.read_slots()
    }

    /// Loads the show of a slot and plays it; of a loop that does not repeat, as many rounds.
    pub(super) fn play(&mut self, slot: u8, repeats: bool, rounds: u32) -> Result<String, Refused> {
        if !self.shows.has(slot) {
            return Err(Refused::because("there is no show in this slot"));
        }
        if matches!(self.act, Some(Act::Show(_) | Act::Journey(_) | Act::Live(_))) {
            return Err(Refused::because("the rig moves: hold it first"));
        }
        self.act = None;
        self.load(slot)?;
        self.ghost = None;
        let is_loop = self
            .shows
            .bytes(slot)
            .is_some_and(|bytes| Show::open(&bytes).is_ok_and(|show| show.is_loop()));
        self.begin_show(repeats, (is_loop && !repeats).then_some(rounds.max(1)))?;
        Ok("the rig goes to the show's first pose, and plays".to_owned())
    }

    /// Returns the duration of the way from the present pose to the beginning of the loaded show; `None` if the rig
    /// moves, or pose or show are not known.
    pub(super) fn way_to_show(&self) -> Option<Duration> {
        if self.state() != State::Holding {
            return None;
        }
        let show = self.shows.bytes(self.shows.loaded?)?;
        let from = self.scene.commanded(&self.board.log)?;
        Duration::try_from_secs_f32(self.scene.way_s(&show, &from)?).ok()
    }

    fn load(&mut self, slot: u8) -> Result<(), Refused> {
        self.ask(Command::LoadShow { slot })?;
        self.shows.loaded = Some(slot);
        self.tell_shows();
        Ok(())
    }

    /// Shows the pose of a show at a time, s, as a ghost; without a time, removes the ghost. Without a slot, uses the
    /// loaded show, or the first show whose bytes are known.
    pub(super) fn seek(&mut self, t: Option<f64>, slot: Option<u8>) -> Result<String, Refused> {
        self.ghost = None;
        let Some(t) = t else { return Ok(String::new()) };
        let slot = slot.or(self.shows.loaded).or(self.shows.bytes.first().map(|(slot, _)| *slot));
        let bytes = slot.and_then(|slot| self.shows.bytes(slot));
        let bytes = bytes.ok_or_else(|| {
            Refused::because(
                "the poses of this show are not known: give its file to `sinew console`",
            )
        })?;
        self.ghost = pose(&bytes, t, self.scene.home.len());
        Ok(String::new())
    }
}
