//! Limits that follow from the rounding of each case hold on unseen rigs: random trees of all kinds of joints, up to
//! 64 bodies, with rotors and without.
//!
//! Each case is computed by the core, and again with its rounding ([`sinew_verification::rounding`]); each number has
//! a limit of its own. `SINEW_CASES` sets the number of cases (default: 200). `cargo xtask limits` runs 10,000 and
//! prints the smallest error that would be noticed.

mod case;
mod dynamics;
mod errors;
mod planted;
mod tally;

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use case::Case;
use tally::Table;

/// Returns the number of cases to compare.
fn cases() -> u64 {
    match std::env::var("SINEW_CASES") {
        Ok(cases) => cases.parse().expect("SINEW_CASES is a number of cases"),
        Err(_) => 200,
    }
}

/// Number of cases between two progress lines; so many cases take about 15 s.
const TOLD: u64 = 500;

/// Compares all cases in one way and prints their table.
fn all_within(title: &str, compare: impl Fn(&Case, &mut Table) + Sync) {
    let (cases, done) = (cases(), AtomicU64::new(0));
    let table = (0..cases)
        .into_par_iter()
        .map(|number| {
            let mut table = Table::of_case(number);
            compare(&Case::new(number), &mut table);
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            if done.is_multiple_of(TOLD) {
                eprintln!("{title}: {done} of {cases} cases");
            }
            table
        })
        .reduce(Table::default, Table::with);
    println!("{title}, {cases} cases\n{table}");
    let over = table.over();
    assert!(over.is_empty(), "over their limits: {over:#?}");
}

#[test]
fn dynamics_of_any_rig_are_within_their_limits() {
    all_within("dynamics", dynamics::compare);
}

#[test]
fn errors_and_ticks_of_any_figure_are_within_their_limits() {
    all_within("errors and ticks", errors::compare);
}
