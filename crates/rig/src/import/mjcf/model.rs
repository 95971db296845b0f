//! Settings of the whole file.

use super::compiler::MassRules;
use super::defaults::Defaults;
use super::pose::Angles;
use crate::import::options::Options;

/// The settings by which bodies, joints and actuators are read.
pub(super) struct Model<'a, 'd, 'o> {
    pub(super) defaults: Defaults<'a, 'd>,
    pub(super) angles: Angles,
    pub(super) masses: MassRules,
    /// Whether a range alone is a limit.
    pub(super) auto_limits: bool,
    pub(super) options: &'o Options,
}
