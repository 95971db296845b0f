//! Conversion between the controller's types and those of link and storage.

use core::fmt::Debug;

use sinew_core::control::LimitReason;
use sinew_link::message::{self, Limit, Refusal};
use sinew_rig::board::BoardRigError;
use sinew_show::ShowError;
use sinew_storage::{Approver, CapacityError, Descriptor, Error, Hash, Kind};

use crate::controller::{DofReport, ServoReport};
use crate::drives;
use crate::supervisor::detect::Concern;
use crate::supervisor::{
    self, Fault, FaultRecord, Feed, Moving, Operator, Overload, Refused, RegisterDiffers, State,
};

pub(super) fn state(state: State) -> message::State {
    let all = message::State::ALL;
    all.get(usize::from(state.number())).copied().unwrap_or(message::State::Faulted)
}

pub(super) fn feed(feed: message::Feed) -> Feed {
    match feed {
        message::Feed::Show => Feed::Show,
        message::Feed::Live => Feed::Live,
        message::Feed::Jog => Feed::Jog,
    }
}

pub(super) fn operator(operator: message::Operator) -> Operator {
    Operator(operator.0)
}

/// Returns the limit of a dof: that of its effort, or else of its first servo's drive, or of heat and supply.
/// Telemetry, recordings and tables all use this function.
pub fn limiter(dof: &DofReport, servo: Option<&ServoReport>) -> Option<Limit> {
    if dof.limit.is_some() {
        return dof.limit.map(limit);
    }
    let servo = servo?;
    let concern = servo.concern.filter(|_| servo.share < 1.0);
    servo.limit.map(of_drive).or(concern.map(of_concern))
}

fn of_drive(limit: drives::Limit) -> Limit {
    match limit {
        drives::Limit::Range => Limit::Range,
        drives::Limit::Speed => Limit::Speed,
        drives::Limit::Acceleration => Limit::Acceleration,
        drives::Limit::Torque => Limit::Effort,
        drives::Limit::Current => Limit::Current,
        drives::Limit::Voltage => Limit::Supply,
        drives::Limit::Offset | drives::Limit::OffsetRate => Limit::Offset,
        drives::Limit::Stale => Limit::Stale,
        drives::Limit::Heat => Limit::Heat,
    }
}

fn of_concern(concern: Concern) -> Limit {
    match concern {
        Concern::SupplyLow | Concern::SupplyHigh => Limit::Supply,
        Concern::Hot | Concern::HotWinding => Limit::Heat,
        Concern::NotFinite => Limit::NotFinite,
    }
}

fn limit(reason: LimitReason) -> Limit {
    match reason {
        LimitReason::Torque | LimitReason::Force => Limit::Effort,
        LimitReason::NotFinite => Limit::NotFinite,
        LimitReason::Supply => Limit::Supply,
        // No room, and reasons that a later core may add.
        _ => Limit::Room,
    }
}

/// Returns the supervisor's command, or `None` if another part handles it.
pub(super) fn command(command: &message::Command) -> Option<supervisor::Command> {
    use supervisor::Command as To;
    Some(match *command {
        message::Command::EStop => To::EStop,
        message::Command::Arm => To::Arm,
        message::Command::Disarm => To::Disarm,
        message::Command::Play(from) => To::Play(feed(from)),
        message::Command::Hold => To::Hold,
        message::Command::Stop => To::Stop,
        message::Command::Calibrate => To::Calibrate,
        message::Command::Teach => To::Teach,
        message::Command::Float => To::Float,
        message::Command::Maintain(by) => To::Maintain(operator(by)),
        message::Command::Leave(by) => To::Leave(operator(by)),
        message::Command::ClearFaults => To::ClearFaults,
        _ => return None,
    })
}

pub(super) fn refused(why: Refused) -> Refusal {
    match why {
        Refused::InState(of) => Refusal::State(state(of)),
        Refused::NotMeasured => Refusal::NotMeasured,
        Refused::RegistersUnread => Refusal::RegistersUnread,
        Refused::RegisterDiffers(RegisterDiffers { servo, address, found, expected, .. }) => {
            Refusal::RegisterDiffers { servo, address, found, expected }
        }
        Refused::StopUntested => Refusal::StopUntested,
        Refused::Moving(Moving { dof, mrad_s, most_mrad_s }) => {
            Refusal::Moving { dof, mrad_s, most_mrad_s }
        }
        Refused::Overload(Overload::Servo { dof, mnm, most_mnm }) => {
            Refusal::Overload { dof, mnm, most_mnm }
        }
        Refused::Overload(Overload::Supply { dof, ma, most_ma }) => {
            Refusal::Supply { dof, ma, most_ma }
        }
        Refused::FeedSilent(Feed::Show) => Refusal::FeedSilent(message::Feed::Show),
        Refused::FeedSilent(Feed::Live) => Refusal::FeedSilent(message::Feed::Live),
        Refused::FeedSilent(Feed::Jog) => Refusal::FeedSilent(message::Feed::Jog),
        Refused::NoEffort => Refusal::NoEffort,
        Refused::Fault(fault) => Refusal::Fault(fault.number()),
        Refused::StillThere(fault) => Refusal::StillThere(fault.number()),
        Refused::NeedsUpload(fault) => Refusal::NeedsUpload(fault.number()),
        Refused::NoFault => Refusal::NoFault,
        Refused::InMaintenance(Operator(id)) => Refusal::InMaintenance(message::Operator(id)),
    }
}

pub(super) fn fault(record: &FaultRecord) -> message::FaultRecord {
    let FaultRecord { fault, servo, start, time_us, times, .. } = *record;
    message::FaultRecord {
        fault: fault.number(),
        state: state(record.state),
        servo,
        start,
        time_us,
        times,
    }
}

/// Returns a fault as storage keeps it. Storage itself counts the starts.
pub(super) fn to_keep(record: &FaultRecord) -> sinew_storage::Fault {
    sinew_storage::Fault {
        run: record.start,
        time_us: record.time_us,
        number: record.fault.number().into(),
        part: record.servo,
        state: record.state.number(),
        times: record.times,
    }
}

/// Returns a stored fault, or `None` if a later firmware has stored it.
pub(super) fn kept(fault: &sinew_storage::Fault) -> Option<FaultRecord> {
    let number = |of: &Fault| u16::from(of.number()) == fault.number;
    Some(FaultRecord {
        fault: Fault::ALL.into_iter().find(number)?,
        state: State::ALL.get(usize::from(fault.state)).copied()?,
        servo: fault.part,
        start: fault.run,
        time_us: fault.time_us,
        times: fault.times,
    })
}

pub(super) fn kind(kind: message::Kind) -> Kind {
    match kind {
        message::Kind::Settings => Kind::Settings,
        message::Kind::Rig => Kind::Rig,
        message::Kind::Show => Kind::Show,
    }
}

pub(super) fn descriptor(item: &message::Item) -> Option<Descriptor> {
    Some(Descriptor {
        kind: kind(item.kind),
        schema: item.schema,
        len: item.length,
        hash: Hash(item.hash),
        rig: item.rig,
        approver: Approver::new(&item.approver).ok()?,
    })
}

pub(super) fn item(of: &Descriptor) -> message::Item {
    message::Item {
        kind: match of.kind {
            Kind::Settings => message::Kind::Settings,
            Kind::Rig => message::Kind::Rig,
            Kind::Show => message::Kind::Show,
        },
        schema: of.schema,
        length: of.len,
        hash: of.hash.0,
        rig: of.rig,
        // The field has room for every approver's name.
        approver: of.approver.name().try_into().unwrap_or_default(),
    }
}

pub(super) fn storage<E: Debug>(error: &Error<E>) -> Refusal {
    match *error {
        Error::Full { needed, free } => Refusal::Capacity { room: free, needs: needed },
        Error::TooLong { len, holds } => Refusal::Capacity { room: holds, needs: len },
        Error::NoFreeSlot { .. } => Refusal::NoFreeSlot,
        Error::Slot { .. } => Refusal::Unknown,
        Error::Order { expected, .. } => Refusal::Offset { next: expected },
        Error::Alignment { .. } | Error::Beyond { .. } => Refusal::Value,
        Error::Hash => Refusal::Hash,
        Error::Capacity(CapacityError::TooLarge { found, holds, .. }) => {
            Refusal::Capacity { room: holds.into(), needs: found.into() }
        }
        Error::Capacity(_) => Refusal::Content(RIG_MAGIC),
        Error::Untidy => Refusal::Busy,
        _ => Refusal::Memory,
    }
}

const RIG_MAGIC: u16 = 2;

/// Returns an error of a rig as its number: the order in `BoardRigError`, from 1.
pub(super) fn rig_error(error: &BoardRigError) -> Refusal {
    use BoardRigError::{
        Capacity, Checksum, Count, Drive, Index, Joints, Kind, Length, Magic, Number, Servo,
        Shared, Tree, Version,
    };
    Refusal::Content(match error {
        Capacity { .. } => 1,
        Magic { .. } => RIG_MAGIC,
        Version { .. } => 3,
        Length { .. } => 4,
        Checksum { .. } => 5,
        Kind { .. } => 6,
        Count { .. } => 7,
        Index { .. } => 8,
        Shared { .. } => 9,
        Number { .. } => 10,
        Joints { .. } => 11,
        Tree(_) => 12,
        Drive { .. } => 13,
        Servo { .. } => 14,
        _ => 0,
    })
}

/// Returns an error of a show as its number: the order in `ShowError`, from 1. A show of another rig has its own
/// refusal.
pub(super) fn show_error(error: &ShowError) -> Refusal {
    use ShowError::{
        Block, Broken, Capacity, Checksum, Field, Joint, Joints, Length, Magic, Range, Rig, Version,
    };
    Refusal::Content(match *error {
        Rig { show, here } => return Refusal::OtherRig { show, rig: here },
        Magic { .. } => 1,
        Version { .. } => 2,
        Length { .. } => 3,
        Checksum { .. } => 4,
        Block { .. } => 5,
        Broken { .. } => 6,
        Field { .. } => 7,
        Capacity { .. } => 8,
        Joints { .. } => 10,
        Joint { .. } => 11,
        Range { .. } => 12,
        _ => 0,
    })
}
