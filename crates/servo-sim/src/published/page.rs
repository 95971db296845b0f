//! The table as a page of the documentation.

use std::fmt::Write;

use super::Row;

const HEAD: &str = "# Simulated servos

This page compares published figures of servos with the simulated servos, measured over their bus.
`cargo run -p sinew-servo-sim --example published > docs/simulated-servos.md` writes this page; a test compares.

- *Fitted*: the simulated servo's numbers were chosen to meet this figure, so its row proves nothing. All other rows are
  independent of the choice.
- *Shown only*: the figure is known not to match, or its source does not state the conditions.
- *Our numbers*: for steps and sags, sources publish a law of second order with the numbers of their own servo, and
  these are not always those of the simulated servo. This column is the result of that law with the simulated servo's
  numbers.
- *Within*: the largest permitted difference from *our numbers*, or else from the published figure. For sags: one
  encoder step, half of it from the goal, half from the encoder. For steps: two ticks of the servo's loop (one until the
  servo takes the goal, one for the age of a reading), and the time in which the shaft, at its speed there, turns by
  half the play of its gear and one encoder step. For makers' figures: 3 %, since the winding warms during the
  measurement.

| servo | figure | published | our numbers | simulated | difference from published | fitted | within |
| --- | --- | ---: | ---: | ---: | ---: | --- | ---: |
";

const REST: &str = "
## Differences

- **XL330: two sources disagree.** The maker's stall torque is 0.52 N m at the shaft, which takes a motor of 0.62 N m
  before friction. Rhoban/bam identified 0.48 N m before friction. The simulated servo follows the maker, so it sags a
  fifth less than bam's. Its stiffness is 0.7 N m/rad, while `crates/rig/models` has bam's 0.55. An offset for gravity
  computed with 0.55 therefore lifts the simulated servo too far: see [drives](drives.md).
- **STS3215 at 12 V sags three times as much as a builder measured** (SO-ARM100 issue 134). The builder did not state
  the gains of that servo. With the factory's gains, 2 deg at 1.47 N m is impossible.
- **STS3215 at 12 V draws 0.27 A without load instead of 0.18 A.** Its friction is that of the 7.4 V type.
- **XL430: viscous friction is a guess.** The 0.12 N m s that toddlerbot identified contains the back-EMF (k²/R of the
  maker's sheet is 0.14 N m s). A motor with that much friction could not reach the sheet's no-load speed.
- **Step responses** are compared with identified second-order models. No recorded step with a stated load and voltage
  was found.
- **Heat** is a guess for all servos, since no maker states a time constant.

## Sources

| servo | figure | source, and differences |
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
