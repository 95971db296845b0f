//! Upload of a show from a page to the board. Each turn of the hub sends a block, so that pages can stop the rig
//! meanwhile.

use std::sync::Arc;

use sinew_board_client::{ClientError, Line, item};
use sinew_firmware::node::SHOW_SCHEMA;
use sinew_link::message::{Command, Item, Kind};
use sinew_show::Show;
use sinew_show::sound::split;

use super::shows::{APPROVER, OwnShow};
use super::{Hub, Refused};
use crate::message::ToPage;
use crate::server::PageId;

/// Maximum length of a show's name, bytes.
const NAME_MAX: usize = 100;
/// Number of stored bytes after which the page is told the progress again.
const STEP: u32 = 4096;

/// An upload: the page first announces it, then sends the bytes.
#[derive(Debug)]
pub(super) struct Upload {
    page: PageId,
    id: Option<u64>,
    name: String,
    slot: Option<u8>,
    sending: Option<Sending>,
}

#[derive(Debug)]
struct Sending {
    item: Item,
    bytes: Arc<[u8]>,
    /// Next command for the board. If a show is replaced, the first command deletes it.
    command: Command,
    told: u32,
}

impl<L: Line> Hub<'_, L> {
    /// Notes that the next binary message of a page is a show. Refuses it during another upload, or if the name is
    /// invalid.
    pub(super) fn announce_upload(
        &mut self,
        page: PageId,
        id: Option<u64>,
        name: String,
        slot: Option<u8>,
    ) {
        let is_busy = self.upload.as_ref().is_some_and(|upload| upload.sending.is_some());
        let is_name = name.len() <= NAME_MAX && !name.chars().any(char::is_control);
        if is_busy || !is_name {
            let why = if is_busy { "another upload is going on" } else { "the name is invalid" };
            if let Some(id) = id {
                self.answer(page, id, Err(Refused::because(why)));
            }
        } else {
            self.upload = Some(Upload { page, id, name, slot, sending: None });
        }
    }

    /// Forgets an announced upload whose bytes have not arrived.
    pub(super) fn forget_upload(&mut self, page: PageId) {
        self.upload.take_if(|upload| upload.page == page && upload.sending.is_none());
    }

    /// Accepts the bytes of an announced show, and begins to send them.
    pub(super) fn take_content(&mut self, page: PageId, bytes: Arc<[u8]>) {
        let is_announced = |upload: &mut Upload| upload.page == page && upload.sending.is_none();
        let Some(mut upload) = self.upload.take_if(is_announced) else { return };
        // The section for a sound is not uploaded. Only shows of the command line can have a sound.
        let bytes = match split(&bytes) {
            Ok((show, Some(_))) => show.into(),
            _ => bytes,
        };
        match self.check(page, &bytes) {
            Ok(item) => {
                let slot = upload.slot.filter(|slot| self.shows.has(*slot));
                let command = slot.map_or_else(
                    || Command::BeginUpload(item.clone()),
                    |slot| Command::DeleteShow { slot },
                );
                upload.sending = Some(Sending { item, bytes, command, told: 0 });
                self.upload = Some(upload);
            }
            Err(refused) => self.end_upload(&upload, Err(refused)),
        }
    }

    /// Checks that the page still drives, and that the bytes are a valid show for this rig. It does so before the old
    /// show in the slot is deleted.
    fn check(&self, page: PageId, bytes: &[u8]) -> Result<Item, Refused> {
        if !self.wheel.is_at(page) {
            return Err(Refused::because("this page does not drive any more"));
        }
        let text = |error: &dyn std::fmt::Display| Refused::Other(error.to_string());
        let show = Show::open(bytes).map_err(|error| text(&error))?;
        show.check_blocks().map_err(|error| text(&error))?;
        show.check_rig(self.scene.rig_crc).map_err(|error| text(&error))?;
        let rig = self.board.about().rig;
        item(Kind::Show, SHOW_SCHEMA, bytes, rig, APPROVER).map_err(|error| text(&error))
    }

    /// Sends the next block of an upload, or ends the upload.
    pub(super) fn go_on_upload(&mut self) {
        let Some(mut upload) = self.upload.take_if(|upload| upload.sending.is_some()) else {
            return;
        };
        let Some(sending) = &mut upload.sending else { return };
        let command = sending.command.clone();
        let mut stored = None;
        let next = if matches!(command, Command::DeleteShow { .. }) {
            self.board.ask(command).map(|_| Some(Command::BeginUpload(sending.item.clone())))
        } else {
            let kind = sending.item.kind;
            self.board.upload_step(command, kind, &sending.bytes, &mut |next| stored = Some(next))
        };
        if let Some(stored) = stored
            && (stored >= sending.told + STEP || stored == sending.item.length)
        {
            sending.told = stored;
            let done = stored as f32 / sending.item.length as f32;
            self.tell_page(upload.page, &ToPage::Progress { what: "upload", done });
        }
        match next {
            Ok(Some(command)) => {
                sending.command = command;
                self.upload = Some(upload);
            }
            Ok(None) => {
                let show = OwnShow {
                    name: upload.name.clone(),
                    bytes: Arc::clone(&sending.bytes),
                    sound: None,
                };
                self.shows.know(sending.item.clone(), show);
                self.end_upload(&upload, Ok("the show is on the board".to_owned()));
            }
            Err(ClientError::Refused(refusal)) => {
                self.end_upload(&upload, Err(Refused::Board(refusal)));
            }
            Err(error) => {
                self.end_upload(&upload, Err(Refused::Other(error.to_string())));
                self.lose(error);
            }
        }
    }

    fn end_upload(&mut self, upload: &Upload, answer: Result<String, Refused>) {
        if self.lost.is_none()
            && let Err(error) = self.read_slots()
        {
            self.lose(error);
        }
        self.tell_shows();
        if let Some(id) = upload.id {
            self.answer(upload.page, id, answer);
        }
    }

    /// Ends upload and arming because the board does not answer, and answers their pages with the reason.
    pub(super) fn give_up(&mut self, why: &str) {
        let upload = self.upload.take().and_then(|upload| Some((upload.page, upload.id?)));
        if let Some((page, id)) = upload {
            self.answer(page, id, Err(Refused::because(why)));
        }
        self.end_arming(why);
    }
}
