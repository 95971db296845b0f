//! How much a run of checks and tests has.

/// How much is checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scope {
    /// The checks that every change must pass.
    Gate,
    /// Everything but what takes an hour.
    All,
}
