//! The motion from which a show is written.

use crate::joint::Joint;
use crate::position::Rate;
use crate::time_code::TimeCode;

/// A motion from which a show is written.
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    /// The rig's joints, in regular numbering.
    pub joints: &'a [Joint],
    /// Coordinates of the rig, sample after sample: nq numbers each, rad, m, quaternions xyzw.
    pub q: &'a [f64],
    /// Samples per second.
    pub rate: Rate,
    /// Whether the motion repeats: the sample after the last is the first again.
    pub is_loop: bool,
    /// CRC of the rig's compact form, or 0.
    pub rig: u32,
    /// Cues: for each a sample, and a name of at most 255 bytes.
    pub cues: &'a [(u32, &'a str)],
    /// Time code of the first sample.
    pub time_code: Option<TimeCode>,
    /// Time map of a slowed-down show, linear between pairs of a sample of the show and a sample of the performance.
    /// From pair to pair, samples of the show increase, and samples of the performance do not decrease. The time code
    /// uses this map.
    pub course: &'a [(u32, u32)],
}
