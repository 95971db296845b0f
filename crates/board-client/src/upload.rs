//! Stored items of a controller, and their upload.

use std::time::Duration;

use sha2::{Digest as _, Sha256};
use sinew_link::message::{Applied, BLOCK_MAX, Block, Command, Item, Kind, Location, Refusal};

use crate::{Board, ClientError, Line};

/// Maximum wait for a board to answer after its restart. A board that is slow to erase flash may exceed this time.
const RESTART: Duration = Duration::from_secs(10);

/// Returns the description of a content, for storage on a board. `rig`: CRC of the rig to which the content belongs, 0
/// for any rig.
///
/// # Errors
/// [`ClientError::Approver`] if the approver's name is empty, too long, or has control characters.
pub fn item(
    kind: Kind,
    schema: u16,
    content: &[u8],
    rig: u32,
    approver: &str,
) -> Result<Item, ClientError> {
    let is_name = !approver.is_empty() && !approver.chars().any(char::is_control);
    let name = approver.try_into().ok().filter(|_| is_name);
    Ok(Item {
        kind,
        schema,
        length: u32::try_from(content.len()).unwrap_or(u32::MAX),
        hash: Sha256::digest(content).into(),
        rig,
        approver: name.ok_or_else(|| ClientError::Approver(approver.to_owned()))?,
    })
}

impl<L: Line> Board<L> {
    /// Uploads a content block by block. Continues an interrupted upload of the same content. `progress` receives the
    /// number of stored bytes. After a rig or settings the board restarts, and this function returns in a new session.
    ///
    /// # Errors
    /// [`ClientError::Refused`] with the board's reason; others as in [`Self::ask`].
    pub fn upload(
        &mut self,
        item: &Item,
        content: &[u8],
        progress: &mut dyn FnMut(u32),
    ) -> Result<(), ClientError> {
        let mut command = Command::BeginUpload(item.clone());
        while let Some(next) = self.upload_step(command, item.kind, content, progress)? {
            command = next;
        }
        if !restarts(item.kind) {
            return Ok(());
        }
        self.reconnect(RESTART)?;
        let place = if item.kind == Kind::Rig { Location::Rig } else { Location::Settings };
        let is_there = self.stored(place)?.is_some_and(|stored| stored.hash == item.hash);
        if is_there { Ok(()) } else { Err(ClientError::Refused(Refusal::Memory)) }
    }

    /// Sends a command of an upload; the first is `BeginUpload`. Returns the next command, or `None` after the last.
    /// Callers can do other things between two blocks.
    ///
    /// # Errors
    /// As in [`Self::upload`].
    pub fn upload_step(
        &mut self,
        command: Command,
        kind: Kind,
        content: &[u8],
        progress: &mut dyn FnMut(u32),
    ) -> Result<Option<Command>, ClientError> {
        let is_end = command == Command::EndUpload;
        let next = match self.ask(command) {
            Ok(Applied::Upload { next }) | Err(ClientError::Refused(Refusal::Offset { next })) => {
                next
            }
            Ok(Applied::Stored(_)) => return Ok(None),
            // The answer to the end was lost, and the board has restarted.
            Err(ClientError::SessionOver) if is_end && restarts(kind) => return Ok(None),
            Ok(_) => return Err(ClientError::Unexpected("an upload")),
            Err(error) => return Err(error),
        };
        progress(next);
        Ok(Some(match content.get(next as usize..) {
            None | Some([]) => Command::EndUpload,
            Some(rest) => {
                let bytes = rest.iter().copied().take(BLOCK_MAX).collect();
                Command::UploadBlock(Block { offset: next, bytes })
            }
        }))
    }

    /// Returns the item that is stored at a location, or `None` if there is none.
    ///
    /// # Errors
    /// As in [`Self::ask`].
    pub fn stored(&mut self, place: Location) -> Result<Option<Item>, ClientError> {
        match self.ask(Command::AskStored(place))? {
            Applied::Stored(item) => Ok(item),
            _ => Err(ClientError::Unexpected("what is stored")),
        }
    }

    /// Returns the item in each slot for shows; `None` for an empty slot.
    ///
    /// # Errors
    /// As in [`Self::ask`].
    pub fn shows(&mut self) -> Result<Vec<Option<Item>>, ClientError> {
        (0..self.about().capacities.slots)
            .map(|slot| self.stored(Location::Show { slot }))
            .collect()
    }

    /// Returns the first slot that has a show with this content for this rig, or `None` if no slot has it.
    ///
    /// # Errors
    /// As in [`Self::ask`].
    pub fn slot_of(&mut self, show: &Item) -> Result<Option<u8>, ClientError> {
        let is_it = |item: &Option<Item>| {
            item.as_ref().is_some_and(|item| item.hash == show.hash && item.rig == show.rig)
        };
        let slot = self.shows()?.iter().position(is_it);
        Ok(slot.and_then(|slot| u8::try_from(slot).ok()))
    }
}

/// Returns `true` if the board restarts to use the item: a rig or settings.
fn restarts(kind: Kind) -> bool {
    matches!(kind, Kind::Rig | Kind::Settings)
}
