//! Settings of a whole MJCF.

use super::compiler::MassRules;
use super::defaults::Defaults;
use super::pose::Angles;
use crate::import::options::Options;

/// Settings that apply to all bodies, joints and actuators.
pub(super) struct Model<'a, 'd, 'o> {
    pub(super) defaults: Defaults<'a, 'd>,
    pub(super) angles: Angles,
    pub(super) masses: MassRules,
    /// Whether a range is a limit even without a flag.
    pub(super) auto_limits: bool,
    pub(super) options: &'o Options,
}
