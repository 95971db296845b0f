//! Commands for storage: uploads, shows, settings, faults.

use embedded_storage::nor_flash::NorFlash;
use sinew_link::message::{Applied, Block, FaultReport, Item, Location, Refusal, Value};
use sinew_rig::board::BoardRig;
use sinew_show::ShowFrames;
use sinew_storage::{Approver, Descriptor, Disarmed, Error, Kind, Store};

use super::background_task::BackgroundTask;
use super::board::Port;
use super::mail::{Mail, Shared};
use super::settings::{NodeSettings, SETTINGS_SCHEMA, SettingsError};
use super::start::{RIG_SCHEMA, split_rig};
use super::text;
use crate::SettingError;
use crate::controller::open_show;
use crate::supervisor::Fault;

/// Version of the shows that this firmware reads.
pub const SHOW_SCHEMA: u16 = 2;

/// Approver of a setting that a host has changed on its own.
const BY_HOST: &str = "host, one setting";

type Done = Result<Applied, Refusal>;

impl<
    'a,
    F: NorFlash,
    const BODIES: usize,
    const DOFS: usize,
    const SERVOS: usize,
    const COORDS: usize,
> BackgroundTask<'a, F, BODIES, DOFS, SERVOS, COORDS>
{
    /// Runs an action that may erase flash. The action needs the only permission to erase, and is refused if the
    /// permission is not in the mail: the loop has it while torque may be on. If the action `restarts` the board, the
    /// permission stays with the background task: nobody can arm before the restart.
    fn disarmed<R>(
        &mut self,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
        restarts: bool,
        act: impl FnOnce(&mut Store<F>, &Disarmed) -> Result<R, Error<F::Error>>,
    ) -> Result<R, Refusal> {
        let (disarmed, state) = mail.with(|mail| (mail.disarmed.take(), mail.state));
        let refusal =
            if state.is_on() { Refusal::State(text::state(state)) } else { Refusal::Busy };
        let disarmed = disarmed.ok_or(refusal)?;
        let result = act(&mut self.store, &disarmed).map_err(|error| text::storage(&error));
        if restarts && result.is_ok() {
            self.kept = Some(disarmed);
        } else {
            mail.with(|mail| mail.disarmed = Some(disarmed));
        }
        result
    }

    /// Opens a show, which is read in place.
    pub(super) fn open(
        &mut self,
        slot: usize,
        port: &mut impl Port<'a>,
    ) -> Result<ShowFrames<'a, COORDS>, Refusal> {
        let (rig, crc) = self.setup.rig.ok_or(Refusal::Unsupported)?;
        let item = self
            .store
            .show(slot)
            .map_err(|error| text::storage(&error))?
            .ok_or(Refusal::Unknown)?;
        let of = item.descriptor();
        of.check_schema(SHOW_SCHEMA).map_err(|_| Refusal::Content(0))?;
        if ![0, crc].contains(&of.rig) {
            return Err(Refusal::OtherRig { show: of.rig, rig: crc });
        }
        let bytes = port.lend(item.place()).ok_or(Refusal::Unsupported)?;
        open_show(rig, crc, self.setup.tick_s, bytes).map_err(|error| text::show_error(&error))
    }

    pub(super) fn delete(
        &mut self,
        slot: usize,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
    ) -> Done {
        self.disarmed(mail, false, |store, disarmed| store.delete_show(disarmed, slot))?;
        Ok(Applied::Stored(None))
    }

    #[inline(never)]
    pub(super) fn ask(&mut self, place: Location) -> Done {
        let item = match place {
            Location::Settings => self.store.settings(),
            Location::Rig => self.store.rig(),
            Location::Show { slot } => self.store.show(slot.into()),
        };
        let item = item.map_err(|error| text::storage(&error))?;
        Ok(Applied::Stored(item.map(|item| text::item(item.descriptor()))))
    }

    #[inline(never)]
    pub(super) fn begin(
        &mut self,
        item: &Item,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
    ) -> Done {
        let descriptor = text::descriptor(item).ok_or(Refusal::Value)?;
        let schema = match descriptor.kind {
            Kind::Settings => SETTINGS_SCHEMA,
            Kind::Rig => RIG_SCHEMA,
            Kind::Show => SHOW_SCHEMA,
        };
        descriptor.check_schema(schema).map_err(|_| Refusal::Value)?;
        let (of, here) = (descriptor.rig, self.setup.about.rig);
        if descriptor.kind != Kind::Rig && here != 0 && ![0, here].contains(&of) {
            return Err(Refusal::OtherRig { show: of, rig: here });
        }
        self.upload = None;
        let upload =
            self.disarmed(mail, false, |store, disarmed| store.begin(disarmed, &descriptor))?;
        let next = upload.received();
        self.upload = Some(upload);
        Ok(Applied::Upload { next })
    }

    pub(super) fn block(
        &mut self,
        block: &Block,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
    ) -> Done {
        let mut upload = self.upload.take().ok_or(Refusal::Offset { next: 0 })?;
        let written = self.disarmed(mail, false, |store, disarmed| {
            store.write(disarmed, &mut upload, block.offset, &block.bytes)
        });
        let next = upload.received();
        self.upload = Some(upload);
        written?;
        Ok(Applied::Upload { next })
    }

    /// Ends an upload. The content is checked first: unusable content does not replace usable content.
    #[inline(never)]
    pub(super) fn end<P: Port<'a>>(
        &mut self,
        port: &mut P,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
    ) -> Done {
        let upload = self.upload.take().ok_or(Refusal::Offset { next: 0 })?;
        let of = upload.descriptor().clone();
        if upload.received() != of.len {
            let next = upload.received();
            self.upload = Some(upload);
            return Err(Refusal::Offset { next });
        }
        let checked = port.look(upload.place::<F>(), |bytes| self.check::<P>(of.kind, bytes));
        checked.unwrap_or(Err(Refusal::Unsupported))?;
        let restarts = matches!(of.kind, Kind::Settings | Kind::Rig);
        let stored =
            self.disarmed(mail, restarts, |store, disarmed| store.end(disarmed, &upload))?;
        Ok(Applied::Stored(Some(text::item(stored.descriptor()))))
    }

    /// Checks that this node can use the content of an item.
    fn check<P: Port<'a>>(&self, kind: Kind, bytes: &[u8]) -> Result<(), Refusal> {
        match kind {
            Kind::Settings => self.setup.settings.read(bytes).map(|_| ()).map_err(settings_error),
            Kind::Rig => {
                let (rig, behind) = split_rig(bytes);
                check_rig::<BODIES, DOFS, SERVOS>(rig)?;
                if P::drives(behind) { Ok(()) } else { Err(Refusal::Unsupported) }
            }
            Kind::Show => {
                let (rig, crc) = self.setup.rig.ok_or(Refusal::Unsupported)?;
                check_show::<BODIES, DOFS, SERVOS, COORDS>(rig, crc, self.setup.tick_s, bytes)
            }
        }
    }

    pub(super) fn read_setting(&self, key: u16) -> Done {
        let value = self.setup.settings.get(key).ok_or(Refusal::Unknown)?;
        Ok(Applied::Setting(Value::Number(value)))
    }

    /// Changes one setting and stores all settings. The change takes effect after the restart.
    #[inline(never)]
    pub(super) fn write_setting(
        &mut self,
        key: u16,
        value: &Value,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
    ) -> Done {
        if self.setup.is_bad {
            // The other settings would take effect, too, although nobody has approved them for this rig.
            return Err(Refusal::NeedsUpload(Fault::SettingsBad.number()));
        }
        let Value::Number(value) = *value else { return Err(Refusal::Value) };
        let settings = self.setup.settings.with(key, value).map_err(settings_error)?;
        let bytes = settings.bytes();
        let approver = Approver::new(BY_HOST).map_err(|_| Refusal::Value)?;
        let descriptor =
            Descriptor::of(Kind::Settings, SETTINGS_SCHEMA, &bytes, self.setup.about.rig, approver);
        let stored =
            self.disarmed(mail, true, |store, disarmed| store.put(disarmed, &descriptor, &bytes))?;
        let read = read_back(&mut self.store, &stored, &self.setup.settings)?;
        let value = read.get(key).ok_or(Refusal::Memory)?;
        Ok(Applied::Setting(Value::Number(value)))
    }

    /// Returns a stored fault. 0 is the first fault since faults were cleared; the next indices go back from the
    /// latest fault. The index after them is the last warning since faults were cleared.
    #[inline(never)]
    pub(super) fn read_fault(&mut self, index: u16) -> Done {
        let faults = self.store.faults().map_err(|error| text::storage(&error))?;
        let all = faults.first.iter().chain(&faults.last);
        let count = u16::try_from(all.count()).unwrap_or(u16::MAX);
        let record = match index.checked_sub(1) {
            None => faults.first.as_ref(),
            Some(back) => faults.last.iter().rev().nth(back.into()),
        };
        let record = record.and_then(text::kept).map(|record| text::fault(&record));
        let mut report = FaultReport { count, record };
        if self.warning.is_some() {
            // If no fault occurred since faults were cleared, older faults are not counted.
            let told = if faults.first.is_some() { count } else { 0 };
            report.count = told.saturating_add(1);
            if index == told {
                report.record = self.warning;
            }
        }
        Ok(Applied::Fault(report))
    }
}

#[inline(never)]
fn check_show<const BODIES: usize, const DOFS: usize, const SERVOS: usize, const COORDS: usize>(
    rig: &BoardRig<BODIES, DOFS, SERVOS>,
    crc: u32,
    tick_s: f32,
    bytes: &[u8],
) -> Result<(), Refusal> {
    let opened = open_show::<BODIES, DOFS, SERVOS, COORDS>(rig, crc, tick_s, bytes);
    opened.map(|_| ()).map_err(|error| text::show_error(&error))
}

// Not inlined, like all functions of this file that need much stack: their stack is free again before the rest.
#[inline(never)]
fn check_rig<const BODIES: usize, const DOFS: usize, const SERVOS: usize>(
    bytes: &[u8],
) -> Result<(), Refusal> {
    BoardRig::<BODIES, DOFS, SERVOS>::decode(bytes)
        .map(|_| ())
        .map_err(|error| text::rig_error(&error))
}

fn read_back<F: NorFlash>(
    store: &mut Store<F>,
    item: &sinew_storage::Stored,
    settings: &NodeSettings,
) -> Result<NodeSettings, Refusal> {
    let mut bytes = [0; super::settings::SETTINGS_MAX];
    let bytes = bytes.get_mut(..item.descriptor().len as usize).ok_or(Refusal::Memory)?;
    store.read(item, 0, bytes).map_err(|error| text::storage(&error))?;
    settings.read(bytes).map_err(settings_error)
}

fn settings_error(error: SettingsError) -> Refusal {
    match error {
        SettingsError::Key { .. } => Refusal::Unknown,
        SettingsError::Value(SettingError { what, found, least, most }) => {
            match NodeSettings::key(what) {
                // The link carries only finite numbers.
                Some(key) if found.is_finite() => Refusal::Setting { key, found, least, most },
                _ => Refusal::Value,
            }
        }
        SettingsError::Length { .. } => Refusal::Value,
    }
}
