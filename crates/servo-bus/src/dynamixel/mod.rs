//! Dynamixel protocol 2.0.
//!
//! Source: ROBOTIS e-manual, "Protocol 2.0" and the pages of the servos. ROBOTIS's clients read replies less strictly
//! (CRCs inside fast replies, stuffing); this module follows the text of the protocol.

mod bus;
pub mod crc;
pub mod device;
pub mod fast;
mod frame;
pub mod group;
mod instruction;
mod parser;
mod status;
pub mod table;

pub use bus::{Bus, Mode, ServoSetup, Settings, traffic};
pub use device::{Device, Event};
pub use frame::{BROADCAST, FrameWriter, HEADER, MAX_ID, Packet, STATUS};
pub use instruction::{Instruction, ResetScope, Span, factory_reset};
pub use parser::Parser;
pub use status::{ErrorCode, Status, StatusError, hardware_error};
