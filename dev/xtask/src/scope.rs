//! The extent of a run of checks and tests.

/// Extent of checks and tests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scope {
    /// The checks that every change must pass.
    Gate,
    /// Everything except steps that take an hour.
    All,
}
