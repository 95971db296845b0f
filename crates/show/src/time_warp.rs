//! Maps time in a slowed-down show to time in the original performance.

/// The time map of a slowed-down show: pairs of a sample of the show and the corresponding sample of the original
/// performance. Between two pairs the map is linear; after the last, the performance runs as fast as the show.
#[derive(Debug, Clone)]
pub struct TimeWarp<'a> {
    rest: &'a [u8],
}

/// Length of a pair of samples, in bytes.
pub(crate) const PAIR_LEN: usize = 8;

impl<'a> TimeWarp<'a> {
    pub(crate) fn new(table: &'a [u8]) -> Self {
        Self { rest: table }
    }

    /// Returns the sample of the performance at a sample of the show, rounded down. O(pairs).
    pub(crate) fn performed(self, sample: u32) -> u32 {
        let mut from = (0, 0);
        for to in self {
            if to.0 > sample {
                let [span, way, done] = [
                    to.0.wrapping_sub(from.0),
                    to.1.wrapping_sub(from.1),
                    sample.wrapping_sub(from.0),
                ]
                .map(u64::from);
                let gone = done.wrapping_mul(way).checked_div(span).unwrap_or(0);
                return from.1.saturating_add(u32::try_from(gone).unwrap_or(u32::MAX));
            }
            from = to;
        }
        from.1.saturating_add(sample.wrapping_sub(from.0))
    }

    /// Returns the first pair that does not follow the pair before it, or is beyond `longest`.
    pub(crate) fn fault(self, longest: u32) -> Option<(usize, u32)> {
        let mut before = (0, 0);
        for (index, pair) in self.enumerate() {
            let is_behind = pair.0 > before.0 && pair.1 >= before.1;
            if !is_behind || pair.0 > longest || pair.1 > longest {
                return Some((index, pair.0));
            }
            before = pair;
        }
        None
    }
}

impl Iterator for TimeWarp<'_> {
    type Item = (u32, u32);

    fn next(&mut self) -> Option<(u32, u32)> {
        let (sample, rest) = self.rest.split_first_chunk::<4>()?;
        let (performed, rest) = rest.split_first_chunk::<4>()?;
        self.rest = rest;
        Some((u32::from_le_bytes(*sample), u32::from_le_bytes(*performed)))
    }
}
