//! What defmt logs of shows.

use defmt::{Format, Formatter, write};

use crate::show::{Show, ShowError};

/// How long it is, not its bytes.
impl Format for Show<'_> {
    fn format(&self, f: Formatter<'_>) {
        let (bodies, frames, dt_s) = (self.body_count(), self.frame_count(), self.dt_s());
        write!(f, "Show {{ bodies: {}, frames: {}, dt_s: {} }}", bodies, frames, dt_s);
    }
}

impl Format for ShowError {
    fn format(&self, f: Formatter<'_>) {
        match *self {
            Self::Magic { found } => write!(f, "Magic {{ found: {=[u8; 4]:a} }}", found),
            Self::Version { found } => write!(f, "Version {{ found: {} }}", found),
            Self::Empty => write!(f, "Empty"),
            Self::TimeStep { found } => write!(f, "TimeStep {{ found: {} }}", found),
            Self::Length { expected, found } => {
                write!(f, "Length {{ expected: {}, found: {} }}", expected, found);
            }
            Self::Checksum { stored, computed } => {
                write!(f, "Checksum {{ stored: {:08x}, computed: {:08x} }}", stored, computed);
            }
            Self::Parent { body, found } => {
                write!(f, "Parent {{ body: {}, found: {} }}", body, found);
            }
            Self::JointKind { body, found } => {
                write!(f, "JointKind {{ body: {}, found: {} }}", body, found);
            }
            Self::Place { body } => write!(f, "Place {{ body: {} }}", body),
            Self::Pose { frame, body } => write!(f, "Pose {{ frame: {}, body: {} }}", frame, body),
            Self::Rig(error) => write!(f, "Rig({})", error),
        }
    }
}
