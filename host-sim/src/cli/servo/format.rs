//! The format of what a command prints.

/// A format of output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Format {
    /// A table.
    Words,
    /// One JSON object.
    Json,
}
