//! The valid lengths of a span between two knots, in samples.

/// Number of lengths.
pub(crate) const RUNGS: u8 = 20;

/// Returns the length of a span, at least 1: 1, 2, 3, 4, 6, 8, 12, and so on to 1024. `rung`: below [`RUNGS`]; a
/// higher rung gives the maximum.
pub(crate) fn span(rung: u8) -> i32 {
    match rung.min(RUNGS - 1).checked_sub(1) {
        None => 1,
        Some(above) => {
            if above & 1 == 0 {
                2 << (above >> 1)
            } else {
                3 << (above >> 1)
            }
        }
    }
}
