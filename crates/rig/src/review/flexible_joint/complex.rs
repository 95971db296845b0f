//! Complex numbers, and linear systems of them.

use std::ops::{Add, Div, Mul, Sub};

/// A complex number.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Complex {
    pub(super) re: f64,
    pub(super) im: f64,
}

impl Complex {
    pub(super) fn real(re: f64) -> Self {
        Self { re, im: 0.0 }
    }

    /// Returns the number on the unit circle at an angle, rad.
    pub(super) fn turn(angle_rad: f64) -> Self {
        let (im, re) = libm::sincos(angle_rad);
        Self { re, im }
    }

    pub(super) fn size(self) -> f64 {
        libm::hypot(self.re, self.im)
    }

    /// Returns the angle of the number, from -π to π.
    pub(super) fn angle_rad(self) -> f64 {
        libm::atan2(self.im, self.re)
    }
}

impl Add for Complex {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }
}

impl Sub for Complex {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { re: self.re - other.re, im: self.im - other.im }
    }
}

impl Mul for Complex {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }
}

impl Div for Complex {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let square = other.re * other.re + other.im * other.im;
        let product = self * Self { re: other.re, im: -other.im };
        Self { re: product.re / square, im: product.im / square }
    }
}

/// Solves a linear system by elimination with the largest pivot of each column. Each row contains a row of the
/// matrix, followed by the right side.
pub(super) fn solve(mut rows: Vec<Vec<Complex>>) -> Vec<Complex> {
    let size = rows.len();
    for column in 0..size {
        let by_size =
            |a: &usize, b: &usize| rows[*a][column].size().total_cmp(&rows[*b][column].size());
        let pivot = (column..size).max_by(by_size).unwrap_or(column);
        rows.swap(column, pivot);
        let (done, rest) = rows.split_at_mut(column + 1);
        let by = &done[column];
        for row in rest {
            let factor = row[column] / by[column];
            if factor == Complex::default() {
                continue;
            }
            for (item, above) in row.iter_mut().zip(by).skip(column) {
                *item = *item - factor * *above;
            }
        }
    }
    let mut solution = vec![Complex::default(); size];
    for (place, row) in rows.iter().enumerate().rev() {
        let known = row.iter().zip(&solution).skip(place + 1);
        let known = known.fold(Complex::default(), |sum, (item, x)| sum + *item * *x);
        solution[place] = (row[size] - known) / row[place];
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_is_solved_whatever_its_order() {
        // The first pivot is zero. By hand: x = 1 + i, y = 2 - i.
        let i = Complex { re: 0.0, im: 1.0 };
        let (x, y) = (Complex { re: 1.0, im: 1.0 }, Complex { re: 2.0, im: -1.0 });
        let [zero, three] = [0.0, 3.0].map(Complex::real);
        let found = solve(vec![vec![zero, i, i * y], vec![three, i, three * x + i * y]]);
        for (found, expected) in found.into_iter().zip([x, y]) {
            assert!((found - expected).size() < 1e-14, "{found:?}");
        }
    }
}
