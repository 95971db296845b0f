//! The motion that a show is written of.

use crate::joint::Joint;
use crate::position::Rate;
use crate::time_code::TimeCode;

/// A motion to write a show of.
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    /// The rig's joints, in regular numbering.
    pub joints: &'a [Joint],
    /// The rig's coordinates in each sample, one sample behind the other: nq numbers each, rad, m, quaternions xyzw.
    pub q: &'a [f64],
    /// Samples per second.
    pub rate: Rate,
    /// Whether the sample behind the last one is the first again.
    pub is_loop: bool,
    /// The CRC of the rig's compact form, or 0.
    pub rig: u32,
    /// What happens when: a sample, and a name of at most 255 bytes.
    pub cues: &'a [(u32, &'a str)],
    /// The time code of the first sample.
    pub time_code: Option<TimeCode>,
    /// Where the performance was when the show is at a sample, if the show was slowed down: pairs of samples, both in
    /// order, between which it goes evenly. The time code follows.
    pub course: &'a [(u32, u32)],
}
