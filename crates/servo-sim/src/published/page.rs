//! The table as a page of the documentation.

use std::fmt::Write;

use super::Row;

const HEAD: &str = "# Simulated servos

What is published of servos against what the simulated ones do, over their bus. `cargo run -p sinew-servo-sim --example
published > docs/simulated-servos.md` writes this page; a test compares.

*Fitted*: the servo's numbers were chosen to meet this figure; it tells nothing new. Nothing was chosen by the others.
*Shown only*: the figure is known not to fit, or comes without what it would take to compare.

*Our numbers*: steps and sags are published as laws of second order, whose numbers are not always those of the
simulated servo: two people identified two motors, a maker's sheet tells of a third. This is what the published law
says with the simulated servo's numbers, and *within* is how far the simulation may be from it; else, from what is
published. Sags: one encoder step, half of it by the goal, half by the encoder. Steps: two ticks of the servo's loop,
one until it takes the goal and one that a reading is old, and the time in which the shaft, as fast as it is there, goes
half the play of its gear and an encoder step. Makers' figures: 3 %, the winding warms meanwhile.

| servo | what | published | our numbers | simulated | off the published | fitted | within |
| --- | --- | ---: | ---: | ---: | ---: | --- | ---: |
";

const REST: &str = "
## Where they differ

- **XL330: two figures of one motor.** The maker's stall torque is 0.52 N m at the shaft, which takes a motor of
  0.62 N m before friction. Rhoban/bam identified 0.48 N m before friction. The simulated servo is the maker's; so it
  sags a fifth less than bam's, and its stiffness is 0.7 N m/rad where `crates/rig/models` has bam's 0.55. An offset for
  gravity by 0.55 then lifts the simulated one too far: see [drives](drives.md).
- **STS3215 at 12 V: sags three times as much as a builder measured** (SO-ARM100 issue 134). The gains of that servo are
  not told; with those it is shipped with, 2 deg at 1.47 N m cannot be.
- **STS3215 at 12 V: draws 0.27 A without load, not 0.18.** Its friction is the 7.4 V type's.
- **XL430: viscous friction is a guess.** The 0.12 N m s that toddlerbot identified holds the back-EMF (k²/R of the
  maker's sheet is 0.14 N m s): with it the motor could not reach the sheet's no-load speed.
- **Step responses** are compared with identified second-order models, not with recorded steps: none was found that
  tells load and voltage.
- Heat is a guess in all of them: no maker states a time constant.

## Sources

| servo | what | source, and what differs |
| --- | --- | --- |
";

/// Returns the page `docs/simulated-servos.md` for the rows of [`table`](super::table).
pub fn page(rows: &[Row]) -> String {
    let mut page = HEAD.to_owned();
    for row in rows {
        let within = row.within.map_or("shown only".to_owned(), digits);
        // Writing into a string cannot fail.
        let _ = writeln!(
            page,
            "| {} | {} | {} | {} | {} | {} % | {} | {within} |",
            row.servo,
            row.what,
            digits(row.published),
            row.expected.map_or(String::new(), digits),
            digits(row.simulated),
            percent(row.error()),
            if row.is_fitted { "yes" } else { "no" },
        );
    }
    page += REST;
    for row in rows {
        let _ = writeln!(page, "| {} | {} | {} |", row.servo, row.what, row.source);
    }
    page
}

/// Formats a ratio in per cent, with its sign unless it is zero.
fn percent(part: f64) -> String {
    let percent = format!("{:+.0}", 100.0 * part);
    if percent == "+0" || percent == "-0" { "0".to_owned() } else { percent }
}

/// Formats a number with three digits.
fn digits(number: f64) -> String {
    match number {
        number if number >= 100.0 => format!("{number:.0}"),
        number if number >= 10.0 => format!("{number:.1}"),
        number => format!("{number:.2}"),
    }
}
