//! The widest vector instructions of the processor, chosen while the program runs.

/// A computation for [`widest`].
pub trait Work {
    /// Type of the result.
    type Output;

    /// Computes the result. Implementations, and all functions that loop over lanes, need `#[inline(always)]`: a
    /// function that is not inlined has only the instructions of every processor of the target.
    fn run(self) -> Self::Output;
}

/// Computes `work` with the widest vector instructions that the compiler may use on this processor. The results have
/// the same bits on all processors: vector instructions round like scalar instructions, and the compiler never fuses
/// a multiplication and an addition that the source separates.
///
/// ```
/// use sinew_batch::{Work, widest};
/// struct Halves([f32; 3]);
/// impl Work for Halves {
///     type Output = [f32; 3];
///
///     #[inline(always)]
///     fn run(self) -> [f32; 3] {
///         self.0.map(|number| 0.5 * number)
///     }
/// }
/// assert_eq!(widest(Halves([1.0, 2.0, 3.0])), [0.5, 1.0, 1.5]);
/// ```
pub fn widest<W: Work>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if std::arch::is_x86_feature_detected!("avx512f") {
            #[expect(unsafe_code, reason = "the compiler cannot know the processor")]
            // SAFETY: the processor has the instructions.
            return unsafe { with_avx512(work) };
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            #[expect(unsafe_code, reason = "the compiler cannot know the processor")]
            // SAFETY: the processor has the instructions.
            return unsafe { with_avx2(work) };
        }
    }
    work.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn with_avx512<W: Work>(work: W) -> W::Output {
    work.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn with_avx2<W: Work>(work: W) -> W::Output {
    work.run()
}
