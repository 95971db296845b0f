//! Errors compared with their limits, by quantity, over many cases.

use std::fmt;

use sinew_verification::rounding::LAMBDA;

/// Results of one quantity.
#[derive(Debug, Clone)]
struct Row {
    name: &'static str,
    unit: &'static str,
    compared: u64,
    /// The largest ratio of an error to its limit, and its place.
    share: f64,
    worst: String,
    /// For each case: the smallest error that is noticed everywhere, relative to the largest number of its kind in
    /// the case.
    notices: Vec<f64>,
}

/// The quantities of one case, or of many.
#[derive(Debug, Clone, Default)]
pub(crate) struct Table {
    case: u64,
    rows: Vec<Row>,
}

/// The subject of a comparison.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quantity {
    pub(crate) name: &'static str,
    pub(crate) unit: &'static str,
    /// The largest number of its kind in the case.
    pub(crate) scale: f64,
}

impl Row {
    /// Returns the largest allowed ratio for this number of comparisons. A share of 4e-9 of all numbers exceeds λ = 8
    /// by chance (Student's distribution with 32 degrees of freedom), and the tail falls with the 20th power or faster.
    /// By chance, at most one row in a hundred exceeds the result.
    fn allowed(&self) -> f64 {
        let expected = 4e-9 * self.compared as f64;
        (expected / 0.01).powf(1.0 / 20.0).max(1.0)
    }
}

impl Table {
    /// Creates an empty table.
    pub(crate) fn of_case(case: u64) -> Self {
        Self { case, rows: Vec::new() }
    }

    /// Compares one error with its limit.
    pub(crate) fn add(
        &mut self,
        quantity: Quantity,
        at: fmt::Arguments<'_>,
        error: f64,
        limit: f64,
    ) {
        let Quantity { name, unit, scale } = quantity;
        // Results in f64 are rounded, too. An infinite limit would excuse any error, so it counts as zero.
        let allowed = limit + LAMBDA * f64::EPSILON * scale;
        let allowed = if allowed.is_finite() { allowed } else { 0.0 };
        let error = if error.is_finite() { error.abs() } else { f64::INFINITY };
        let share = if error > 0.0 { error / allowed } else { 0.0 };
        let case = self.case;
        let row = self.row(name, unit);
        if share > row.share || row.compared == 0 {
            (row.share, row.worst) = (share, format!("case {case}, {at}"));
        }
        row.compared += 1;
        if scale > 0.0 {
            // A mistake may have the opposite sign of the error.
            row.notices[0] = row.notices[0].max((allowed + error) / scale);
        }
    }

    fn row(&mut self, name: &'static str, unit: &'static str) -> &mut Row {
        let index = self.rows.iter().position(|row| row.name == name).unwrap_or_else(|| {
            let (share, compared, worst) = (0.0, 0, String::new());
            self.rows.push(Row { name, unit, compared, share, worst, notices: vec![0.0] });
            self.rows.len() - 1
        });
        &mut self.rows[index]
    }

    /// Merges two tables.
    pub(crate) fn with(mut self, other: Self) -> Self {
        for theirs in other.rows {
            match self.rows.iter_mut().find(|row| row.name == theirs.name) {
                None => self.rows.push(theirs),
                Some(row) => {
                    row.compared += theirs.compared;
                    if theirs.share > row.share {
                        (row.share, row.worst) = (theirs.share, theirs.worst);
                    }
                    row.notices.extend(theirs.notices);
                }
            }
        }
        self
    }

    /// Returns the quantities that exceed their limits, with their largest ratio and its place.
    pub(crate) fn over(&self) -> Vec<String> {
        let over = self.rows.iter().filter(|row| row.share.is_nan() || row.share > row.allowed());
        over.map(|row| format!("{}: {:.3} at {}", row.name, row.share, row.worst)).collect()
    }
}

/// Prints the table. The numbers in the format strings are widths of columns.
impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (half, most) = ("in half of cases", "in 99 of 100");
        writeln!(
            f,
            "{:<32} {:>10} {:>7} {:>8}  {half:>16} {most:>12}  nearest",
            "", "compared", "share", "at most"
        )?;
        for row in &self.rows {
            let name = format!("{}, {}", row.name, row.unit);
            let mut notices = row.notices.clone();
            notices.sort_by(f64::total_cmp);
            let of = |hundredths: usize| notices[(notices.len() - 1) * hundredths / 100];
            let (half, most) = (of(50), of(99));
            writeln!(
                f,
                "{name:<32} {:>10} {:>7.3} {:>8.3}  {half:>16.1e} {most:>12.1e}  {}",
                row.compared,
                row.share,
                row.allowed(),
                row.worst
            )?;
        }
        Ok(())
    }
}
