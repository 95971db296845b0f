//! The option for the number of threads.

use std::num::NonZeroUsize;

use anyhow::Context as _;

/// Stack size of a thread, bytes: an evaluation builds a tracker of some 0.5 MB on it.
const STACK_BYTES: usize = 16 << 20;

/// Maximum number of threads: more than any machine can use. Their stacks are 4 GB.
const THREADS_MAX: usize = 256;

/// The option for the number of threads.
#[derive(Debug, clap::Args)]
pub struct ThreadArgs {
    /// Number of threads; the result does not depend on it. Default: one per processor.
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    threads: Option<NonZeroUsize>,
}

fn threads(text: &str) -> Result<NonZeroUsize, String> {
    let threads =
        text.trim().parse().ok().filter(|threads: &NonZeroUsize| threads.get() <= THREADS_MAX);
    threads.ok_or_else(|| format!("expected a whole number from 1 to {THREADS_MAX}"))
}

impl ThreadArgs {
    /// Runs `work` with the chosen number of threads.
    ///
    /// # Errors
    /// The errors of `work`, and an error if the threads cannot be started.
    pub fn install<T: Send>(
        &self,
        work: impl FnOnce() -> anyhow::Result<T> + Send,
    ) -> anyhow::Result<T> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads.map_or(0, NonZeroUsize::get))
            .stack_size(STACK_BYTES)
            .build()
            .context("the threads could not be started")?;
        pool.install(work)
    }
}
