//! Random messages of every kind.

use sinew_link::message::*;

use super::Random;

fn state(r: &mut Random) -> State {
    State::ALL[r.below(State::ALL.len())]
}

fn place(r: &mut Random) -> Location {
    [Location::Settings, Location::Rig, Location::Show { slot: r.bits() as u8 }][r.below(3)]
}

fn item(r: &mut Random) -> Item {
    Item {
        kind: [Kind::Settings, Kind::Rig, Kind::Show][r.below(3)],
        schema: r.bits() as u16,
        length: r.bits(),
        hash: std::array::from_fn(|_| r.bits() as u8),
        rig: r.bits(),
        approver: r.text(),
    }
}

fn value(r: &mut Random) -> Value {
    match r.below(4) {
        0 => Value::Flag(r.chance(0.5)),
        1 => Value::Count(r.bits()),
        2 => Value::Number(r.finite()),
        _ => Value::Text(r.text()),
    }
}

fn setting(r: &mut Random) -> TelemetrySetting {
    TelemetrySetting { rate_hz: r.finite(), parts: TelemetryParts(r.bits() as u8) }
}

fn fault(r: &mut Random) -> FaultRecord {
    FaultRecord {
        fault: r.bits() as u8,
        state: state(r),
        servo: r.maybe(|r| r.bits() as u16),
        start: r.bits(),
        time_us: u64::from(r.bits()) << r.below(33),
        times: r.bits() as u16,
    }
}

fn feed(r: &mut Random) -> Feed {
    [Feed::Show, Feed::Live, Feed::Jog][r.below(3)]
}

fn operator(r: &mut Random) -> Operator {
    Operator(r.bits() as u8)
}

fn version(r: &mut Random) -> Version {
    Version { major: r.below(3) as u8, minor: r.bits() as u8 }
}

/// Number of kinds of commands.
pub(crate) const COMMANDS: usize = 25;

pub(crate) fn command_of_kind(kind: usize, r: &mut Random) -> Command {
    match kind {
        0 => Command::EStop,
        1 => Command::Arm,
        2 => Command::Disarm,
        3 => Command::Play(feed(r)),
        4 => Command::Hold,
        5 => Command::Stop,
        6 => Command::Calibrate,
        7 => Command::Teach,
        8 => Command::Maintain(operator(r)),
        9 => Command::Leave(operator(r)),
        10 => Command::ClearFaults,
        11 => Command::LoadShow { slot: r.bits() as u8 },
        12 => Command::DeleteShow { slot: r.bits() as u8 },
        13 => Command::SetTelemetry(setting(r)),
        14 => Command::ReadSetting { key: r.bits() as u16 },
        15 => Command::WriteSetting { key: r.bits() as u16, value: value(r) },
        16 => Command::ReadFault { index: r.bits() as u16 },
        17 => Command::AskStored(place(r)),
        18 => Command::BeginUpload(item(r)),
        19 => Command::UploadBlock(Block { offset: r.bits(), bytes: r.bytes() }),
        20 => Command::EndUpload,
        21 => Command::PassOn(Pass {
            line: r.bits() as u8,
            baud: r.bits(),
            wait_us: r.bits(),
            bytes: r.bytes(),
        }),
        22 => Command::ReadPassed { offset: r.bits() as u16 },
        23 => Command::ReadHealth,
        _ => Command::Float,
    }
}

pub(crate) fn command(r: &mut Random) -> Command {
    let kind = r.below(COMMANDS);
    command_of_kind(kind, r)
}

pub(crate) fn stream(r: &mut Random) -> Stream {
    match r.below(5) {
        4 => Stream::Heard(r.bits() as u16),
        0 => Stream::Heartbeat,
        1 => Stream::HoldToRun(operator(r)),
        2 => Stream::Jog { dof: r.bits() as u8, velocity: r.finite() },
        _ => Stream::Live(LiveFrame { sent_us: r.bits(), q: r.list(Random::finite) }),
    }
}

fn numbered<T>(r: &mut Random, item: T) -> Numbered<T> {
    Numbered { session: r.bits() as u16, seq: r.bits() as u16, item }
}

pub(crate) fn to_controller(r: &mut Random) -> ToController {
    match r.below(5) {
        0 => ToController::Hello(Hello { protocol: version(r), nonce: r.bits() }),
        1..=3 => {
            let command = command(r);
            ToController::Command(numbered(r, command))
        }
        _ => {
            let stream = stream(r);
            ToController::Stream(numbered(r, stream))
        }
    }
}

fn limit(r: &mut Random) -> Limit {
    use Limit::*;
    [
        Range,
        Speed,
        Acceleration,
        Effort,
        Current,
        Offset,
        Supply,
        Heat,
        Stale,
        NotFinite,
        Room,
        SoftStart,
        Maintenance,
        Link,
    ][r.below(14)]
}

fn refusal(r: &mut Random) -> Refusal {
    match r.below(30) {
        0 => Refusal::Session,
        1 => Refusal::Late,
        2 => Refusal::Forgotten,
        3 => Refusal::State(state(r)),
        4 => Refusal::NotMeasured,
        5 => Refusal::StopUntested,
        6 => Refusal::FeedSilent(feed(r)),
        7 => Refusal::Fault(r.bits() as u8),
        8 => Refusal::StillThere(r.bits() as u8),
        9 => Refusal::NeedsUpload(r.bits() as u8),
        10 => Refusal::NoFault,
        11 => Refusal::InMaintenance(operator(r)),
        12 => Refusal::Unknown,
        13 => Refusal::Value,
        14 => Refusal::Capacity { room: r.bits(), needs: r.bits() },
        15 => Refusal::NoFreeSlot,
        16 => Refusal::Offset { next: r.bits() },
        17 => Refusal::Hash,
        18 => Refusal::OtherRig { show: r.bits(), rig: r.bits() },
        19 => Refusal::Content(r.bits() as u16),
        20 => Refusal::Memory,
        21 => Refusal::Unsupported,
        22 => Refusal::Busy,
        23 => Refusal::RegistersUnread,
        24 => Refusal::Moving { dof: r.bits() as u16, mrad_s: r.bits(), most_mrad_s: r.bits() },
        26 => Refusal::NoEffort,
        27 => Refusal::Overload { dof: r.bits() as u16, mnm: r.bits(), most_mnm: r.bits() },
        28 => Refusal::Supply { dof: r.bits() as u16, ma: r.bits(), most_ma: r.bits() },
        25 => Refusal::Setting {
            key: r.bits() as u16,
            found: r.finite(),
            least: r.finite(),
            most: r.finite(),
        },
        _ => Refusal::RegisterDiffers {
            servo: r.bits() as u16,
            address: r.bits() as u16,
            found: r.bits().cast_signed(),
            expected: r.bits().cast_signed(),
        },
    }
}

fn cycles(r: &mut Random) -> Cycles {
    Cycles { least: r.bits(), mean: r.bits(), most: r.bits(), count: r.bits() }
}

fn applied(r: &mut Random) -> Applied {
    match r.below(9) {
        0 => Applied::Done,
        1 => Applied::State(state(r)),
        2 => Applied::Telemetry(setting(r)),
        3 => Applied::Setting(value(r)),
        4 => Applied::Fault(FaultReport { count: r.bits() as u16, record: r.maybe(fault) }),
        5 => Applied::Stored(r.maybe(item)),
        6 => Applied::Upload { next: r.bits() },
        7 => {
            Applied::Passed(Passed { count: r.bits() as u16, took_us: r.bits(), bytes: r.bytes() })
        }
        _ => Applied::Health(Health {
            cycles_hz: r.bits(),
            tick: cycles(r),
            bus: cycles(r),
            link: cycles(r),
            period: cycles(r),
            supply_least_v: r.finite(),
        }),
    }
}

pub(crate) fn outcome(r: &mut Random) -> Outcome {
    match r.below(4) {
        0 => Outcome::Applied(applied(r)),
        1 => Outcome::Limited(applied(r), limit(r)),
        2 => Outcome::Refused(refusal(r)),
        _ => Outcome::Working,
    }
}

pub(crate) fn summary(r: &mut Random) -> Summary {
    Summary {
        state: state(r),
        fault: r.maybe(|r| r.bits() as u8),
        errors: r.maybe(|r| Errors {
            mean_deg: r.finite(),
            largest_deg: r.finite(),
            mean_cm: r.finite(),
            largest_cm: r.finite(),
            worst: r.bits() as u8,
        }),
        tick_us: r.bits() as u16,
        tick_max_us: r.bits() as u16,
        overruns: r.bits(),
        stack_free: r.bits(),
        supply_v: r.finite(),
        link_damaged: r.bits(),
        link_lost: r.bits(),
        live_age_ms: r.maybe(|r| r.bits() as u16),
        show_ms: r.bits(),
    }
}

pub(crate) fn dof(r: &mut Random) -> Dof {
    Dof { effort: r.finite(), limiter: r.maybe(limit), target: 0 }
}

pub(crate) fn servo(r: &mut Random) -> Servo {
    Servo {
        temperature_c: r.maybe(|r| r.bits() as i8),
        heat_percent: r.bits() as u8,
        bus_errors: r.bits() as u16,
        hardware_error: r.bits() as u8,
        supply: 0,
    }
}

fn part(r: &mut Random) -> SnapshotPart {
    let first = r.bits() as u8;
    match r.below(6) {
        0 => SnapshotPart::Summary(summary(r)),
        1 => SnapshotPart::Pose { first, q: r.list(Random::finite) },
        2 => SnapshotPart::Dofs { first, dofs: r.list(dof) },
        3 => SnapshotPart::Servos { first, servos: r.list(servo) },
        4 => SnapshotPart::Targets { first, offsets: r.list(|r| r.bits() as i16) },
        _ => SnapshotPart::Supplies { first, supplies: r.list(|r| r.bits() as u8) },
    }
}

fn about(r: &mut Random) -> About {
    About {
        protocol: version(r),
        firmware: Release { major: r.bits() as u8, minor: r.bits() as u8, patch: r.bits() as u8 },
        rig: r.bits(),
        capacities: Capacities {
            bodies: r.bits() as u16,
            coordinates: r.bits() as u16,
            dofs: r.bits() as u16,
            servos: r.bits() as u16,
            slots: r.bits() as u8,
            slot_bytes: r.bits(),
        },
    }
}

pub(crate) fn to_host(r: &mut Random) -> ToHost {
    match r.below(4) {
        0 => {
            let verdict = match r.below(3) {
                0 => Ok(r.bits() as u8),
                1 => Err(Misfit::Version { controller: version(r), host: version(r) }),
                _ => Err(Misfit::Busy),
            };
            let (nonce, session) = (r.bits(), r.bits() as u16);
            ToHost::Welcome(Welcome { nonce, session, about: about(r), verdict })
        }
        1 => {
            let outcome = outcome(r);
            ToHost::Answer(numbered(r, outcome))
        }
        2 => {
            let (seq, tick) = (r.bits() as u16, r.bits());
            ToHost::Telemetry(Telemetry { seq, tick, part: part(r) })
        }
        _ => ToHost::Fault(fault(r)),
    }
}
