//! Measures the wall time of several functions in one run. The comparison is fair even if other programs use the
//! machine.

use std::convert::Infallible;
use std::time::Instant;

/// Returns for each of `runs` the median time of a call, ns, and the median ratio to the first.
pub(crate) fn medians(rounds: usize, runs: &mut [&mut dyn FnMut()]) -> Vec<Median> {
    let batches: Vec<u32> = runs.iter_mut().map(|run| batch(run)).collect();
    let count = runs.len();
    let Ok(found) =
        in_turns::<Infallible>(rounds, count, |index| Ok(time_ns(batches[index], runs[index])));
    found
}

/// Returns the medians of functions that measure their own time: `time_ns` runs a batch of the function with an
/// index, and returns the time of a call.
///
/// In each round every function runs a batch of calls, and each round begins with another function. A slow phase of
/// the machine that is longer than a round affects all of them; an interruption of one batch does not change the
/// median. Ratios are medians of the ratios of the rounds.
pub(crate) fn in_turns<E>(
    rounds: usize,
    count: usize,
    mut time_ns: impl FnMut(usize) -> Result<f64, E>,
) -> Result<Vec<Median>, E> {
    let mut times_ns = vec![Vec::with_capacity(rounds); count];
    for round in 0..rounds {
        for turn in 0..count {
            let index = (round + turn) % count;
            times_ns[index].push(time_ns(index)?);
        }
    }
    let first = times_ns.first().cloned().unwrap_or_default();
    let of_all = times_ns.into_iter().map(|times| Median {
        to_first: median(times.iter().zip(&first).map(|(time, first)| time / first).collect()),
        time_ns: median(times),
    });
    Ok(of_all.collect())
}

/// Result of [`medians`] for one function.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Median {
    pub(crate) time_ns: f64,
    pub(crate) to_first: f64,
}

/// Returns the number of calls that take about 10 µs: much longer than reading the clock, much shorter than a time
/// slice.
fn batch(run: &mut dyn FnMut()) -> u32 {
    let mut count = 1;
    // The first call fills the caches.
    run();
    while time_ns(count, run) * f64::from(count) < 10_000.0 {
        count *= 2;
    }
    count
}

fn time_ns(count: u32, run: &mut dyn FnMut()) -> f64 {
    let start = Instant::now();
    for _ in 0..count {
        run();
    }
    start.elapsed().as_secs_f64() * 1e9 / f64::from(count)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
