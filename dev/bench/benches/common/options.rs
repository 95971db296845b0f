//! Options of the command line.

/// Returns whether a quick, rough result is enough: with `--quick` after `--`, or when run as a test, without
/// cargo's `--bench`.
pub(crate) fn quick() -> bool {
    let has = |wanted: &str| std::env::args().any(|argument| argument == wanted);
    has("--quick") || !has("--bench")
}
