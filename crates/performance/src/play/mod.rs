//! Plays a show on simulated servos, with the controller that boards run.
//!
//! ```text
//! rig ─ put_servos ─> RigParts (compact form, buses, rate, settings)
//!                       └─> SimulatedRig (controller, buses, one bench), a tick a call ─> Tally, Recorder
//! stop ─> Director (arm, play, stop) ─────┘       └─ PeerController (a board elsewhere), if there is one
//! ```
//! Everything runs in simulated time: a show gives the same bytes on every run. [`SimulatedBoard`] is a whole board
//! instead of the controller, for programs that talk to boards.

mod board;
mod bus;
mod checksum;
mod director;
mod error;
mod exchange;
mod line;
mod line_setup;
mod options;
mod peer;
mod pulse_ranges;
mod pulses;
mod record;
mod recording;
mod rig_parts;
mod schedule;
mod servo_part;
mod servos;
mod simulated_lines;
mod simulated_rig;
mod swing_meter;
mod tally;
mod wires;

pub use board::{BoardEnd, BoardError, Chip, HostEnd, HostSide, SimulatedBoard, pipe};
pub use director::{Director, Ended};
pub use error::{PartsError, SimulatedRigError};
pub use line::Line;
pub use options::Options;
pub use peer::PeerController;
pub use pulse_ranges::PulseRange;
pub use record::{Recorder, SCHEMA, Tick, TickOfJoint};
pub use recording::{JointRows, Part, Recording, RecordingError, ServoRows};
pub use rig_parts::{RigParts, Ways};
pub use schedule::RateError;
pub(crate) use servo_part::closes_loop;
pub use servo_part::{Drive, ServoPart};
pub use servos::{PutError, ServoChoice, put_servos};
pub use simulated_lines::Memory;
pub use simulated_rig::SimulatedRig;
pub use swing_meter::SwingMeter;
pub use tally::{Errors, Tally};
pub use wires::Wires;

use sinew_firmware::controller::MotionController;
use sinew_rig::board::BoardRig;

/// Capacities of the largest board. A show's CRC of its rig does not depend on them.
const BODIES: usize = 64;
const DOFS: usize = 128;
const SERVOS: usize = 64;
/// Maximum number of coordinates. It is larger than the number of dofs, because a ball joint has four coordinates and
/// three dofs.
const COORDINATES: usize = 192;

/// The compact form of a simulated rig.
pub type CompactRig = BoardRig<BODIES, DOFS, SERVOS>;
/// The controller of a simulated rig.
pub type RigController<'a> = MotionController<'a, BODIES, DOFS, SERVOS, COORDINATES>;

#[cfg(test)]
mod tests;
