//! Messages between host and controller.

mod answer;
mod command;
mod fault;
mod greeting;
mod limit;
mod numbered;
mod operator;
mod service;
mod state;
mod stored;
mod stream;
mod telemetry;

pub use answer::{Answer, Applied, Outcome, Refusal};
pub use command::{Command, Feed};
pub use fault::{FaultRecord, FaultReport};
pub use greeting::{About, Capacities, Hello, Misfit, Release, Version, Welcome};
pub use limit::Limit;
pub use numbered::Numbered;
pub use operator::Operator;
pub use service::{
    Cycles, Health, PASS_LEAST_BAUD, PASS_MAX, PASS_WAIT_US, PASSED_MAX, Pass, Passed,
};
pub use state::State;
pub use stored::{
    APPROVER_MAX, Approver, BLOCK_MAX, Block, Item, Kind, Location, NAME_MAX, Name, Value,
};
pub use stream::{LiveFrame, POSE_MAX, Stream};
pub use telemetry::{
    ACKNOWLEDGED_SINCE, DOFS_A_FRAME, Dof, Errors, SERVOS_A_FRAME, SUPPLIES_A_FRAME, SUPPLY_UNIT,
    Servo, Snapshot, SnapshotPart, Summary, TARGET_UNIT, TARGETS_A_FRAME, TELEMETRY_LEAST_HZ,
    Telemetry, TelemetryParts, TelemetrySetting,
};

use serde::{Deserialize, Serialize};

/// A message from a host to a controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum ToController {
    /// The first message, with the host's version.
    Hello(Hello),
    /// A command. It is executed once and answered.
    Command(Numbered<Command>),
    /// A periodic message: only the newest counts, and it gets no answer.
    Stream(Numbered<Stream>),
}

/// A message from a controller to a host.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum ToHost {
    /// The answer to a greeting.
    Welcome(Welcome),
    /// The answer to a command, with its session and number.
    Answer(Answer),
    /// The state of the rig, at the requested rate.
    Telemetry(Telemetry),
    /// A fault, sent when it occurs.
    Fault(FaultRecord),
}
