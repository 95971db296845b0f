//! The widest vector instructions of the processor, chosen while the program runs.

/// A computation for [`widest`].
pub trait Work {
    /// Type of the result.
    type Output;

    /// Computes the result. Implementations, and all functions that loop over lanes, need `#[inline(always)]`: a
    /// function that is not inlined has only the instructions of every processor of the target.
    fn run(self) -> Self::Output;
}

/// Computes `work` with the widest vector instructions that this processor has. The results have the same bits on all
/// processors: vector instructions round like scalar instructions, and the compiler never fuses a multiplication and
/// an addition.
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
    Instructions::widest().run(work)
}

/// Sets of instructions for which this crate is compiled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Instructions {
    /// Instructions of every processor of the target.
    Common,
    #[cfg(target_arch = "x86_64")]
    Avx2(Detected),
    #[cfg(target_arch = "x86_64")]
    Avx512(Detected),
}

/// Proof that the processor has the instructions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Detected(());

impl Instructions {
    /// Returns the sets that this processor has, from the narrowest to the widest.
    pub(crate) fn available() -> impl Iterator<Item = Self> {
        let common = std::iter::once(Self::Common);
        #[cfg(target_arch = "x86_64")]
        let common = common
            .chain(is_x86_feature_detected!("avx2").then_some(Self::Avx2(Detected(()))))
            .chain(is_x86_feature_detected!("avx512f").then_some(Self::Avx512(Detected(()))));
        common
    }

    fn widest() -> Self {
        Self::available().last().unwrap_or(Self::Common)
    }

    pub(crate) fn run<W: Work>(self, work: W) -> W::Output {
        match self {
            Self::Common => work.run(),
            #[cfg(target_arch = "x86_64")]
            #[expect(unsafe_code, reason = "the compiler does not know the processor")]
            // SAFETY: the processor has the instructions, which `Detected` proves.
            Self::Avx2(_) => unsafe { with_avx2(work) },
            #[cfg(target_arch = "x86_64")]
            #[expect(unsafe_code, reason = "the compiler does not know the processor")]
            // SAFETY: the processor has the instructions, which `Detected` proves.
            Self::Avx512(_) => unsafe { with_avx512(work) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn with_avx2<W: Work>(work: W) -> W::Output {
    work.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn with_avx512<W: Work>(work: W) -> W::Output {
    work.run()
}
