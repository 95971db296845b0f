//! What was asked for on the command line.

/// Whether a rough answer is wanted soon: `--quick` after `--`, or a run as a test, without cargo's `--bench`.
pub(crate) fn quick() -> bool {
    let has = |wanted: &str| std::env::args().any(|argument| argument == wanted);
    has("--quick") || !has("--bench")
}
