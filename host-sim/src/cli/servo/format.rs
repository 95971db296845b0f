//! The format of a command's output.

/// A format of output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Format {
    /// A table.
    Words,
    /// One JSON object.
    Json,
}
