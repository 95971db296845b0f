//! Computes the pseudo-inverse of a small matrix and its condition number, from its singular values.

use heapless::Vec;
use sinew_core::math;

use super::numbers::{DRIVE_CAPACITY, MATRIX_CAPACITY, Numbers, collect, dot};

/// Maximum number of sweeps over all pairs of columns. Convergence is quadratic: matrices of up to six columns need
/// about five.
const SWEEPS: usize = 12;

/// A column of `A V`, and the column of `V` that it is computed from.
struct Column {
    image: Numbers,
    of: Numbers,
}

impl Column {
    fn squared(&self) -> f32 {
        dot(&self.image, &self.image)
    }
}

/// Returns the pseudo-inverse (row after row) of a `rows x columns` matrix, also given row after row, and the
/// condition number. If a singular value is zero, the condition number is infinite and the pseudo-inverse is
/// useless.
///
/// Uses the one-sided Jacobi method (Hestenes 1958): rotates pairs of columns until all columns are perpendicular.
/// Their lengths are then the singular values.
pub(super) fn pseudo_inverse(
    numbers: &[f32],
    rows: usize,
    columns: usize,
) -> (Vec<f32, MATRIX_CAPACITY>, f32) {
    // Works on the matrix or its transpose: the one that is not wider than high.
    let wide = columns > rows;
    let mut turned = Vec::<Column, DRIVE_CAPACITY>::new();
    let count = rows.min(columns);
    for index in 0..count {
        let image = if wide {
            collect(numbers.iter().skip(index.saturating_mul(columns)).take(columns).copied())
        } else {
            collect(numbers.iter().skip(index).step_by(columns.max(1)).copied())
        };
        let of = collect((0..count).map(|other| if other == index { 1.0 } else { 0.0 }));
        // There is room: both counts are at most `DRIVE_CAPACITY`.
        let _ = turned.push(Column { image, of });
    }
    for _ in 0..SWEEPS {
        if !sweep(&mut turned) {
            break;
        }
    }
    let squares = || turned.iter().map(Column::squared);
    let (least, most) = (squares().fold(f32::INFINITY, f32::min), squares().fold(0.0, f32::max));
    let condition = math::sqrt(most / least);
    // Element of Σ v wᵀ / σ²; for a wide matrix, of its transpose.
    let element = |of_column: usize, of_row: usize| -> f32 {
        let (inner, outer) = if wide { (of_row, of_column) } else { (of_column, of_row) };
        turned
            .iter()
            .map(|column| {
                let v = column.of.get(inner).copied().unwrap_or_default();
                let w = column.image.get(outer).copied().unwrap_or_default();
                v * w / column.squared()
            })
            .sum()
    };
    let inverse = collect(
        (0..columns)
            .flat_map(|column| (0..rows).map(move |row| (column, row)))
            .map(|(column, row)| element(column, row)),
    );
    (inverse, condition)
}

/// Makes each pair of columns perpendicular in turn. Returns whether any pair was not.
fn sweep(columns: &mut [Column]) -> bool {
    let mut any = false;
    for index in 1..columns.len() {
        let (before, from) = columns.split_at_mut(index);
        if let Some(second) = from.first_mut() {
            for first in before {
                any |= make_perpendicular(first, second);
            }
        }
    }
    any
}

fn make_perpendicular(first: &mut Column, second: &mut Column) -> bool {
    let (a, b, product) = (first.squared(), second.squared(), dot(&first.image, &second.image));
    if product.abs() <= f32::EPSILON * math::sqrt(a * b) {
        return false;
    }
    let zeta = (b - a) / (2.0 * product);
    let tangent = zeta.signum() / (zeta.abs() + math::sqrt(1.0 + zeta * zeta));
    let cosine = 1.0 / math::sqrt(1.0 + tangent * tangent);
    let sine = cosine * tangent;
    let turn = |p: &mut Numbers, q: &mut Numbers| {
        for (p, q) in p.iter_mut().zip(q) {
            (*p, *q) = (cosine * *p - sine * *q, sine * *p + cosine * *q);
        }
    };
    turn(&mut first.image, &mut second.image);
    turn(&mut first.of, &mut second.of);
    true
}
