//! A number with its rounding: its exact value, and many random samples of its value in f32.

use std::array;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Number of random computations beside the exact computation.
const LANES: usize = 32;

/// Multiple of its expected size that a rounding error may have: λ in Higham & Mary, *A new approach to
/// probabilistic rounding error analysis* (2019).
///
/// A rounding is modelled as a random number within half a unit of the last place. A sum of roundings is
/// sub-Gaussian: it exceeds λ times its standard deviation σ with a probability below `2 exp(-λ² / 2)`, 3e-14 for
/// 8. σ is estimated from 32 samples; the distribution is then Student's with 32 degrees of freedom, and the
/// probability 4e-9.
pub const LAMBDA: f64 = 8.0;

/// Ratio of a rounding error of f64 to one of f32.
pub const DOUBLE: f64 = 1.0 / (1u64 << 29) as f64;

/// Half a unit in the last place of f32, relative to the next lower power of two.
const HALF_ULP: f64 = f32::EPSILON as f64 / 2.0;

/// A number in an f32 computation: its value without rounding, and in each lane its value with random roundings.
/// The effect of one rounding on the result, on all paths, is included in a lane: nothing is linearised, and no
/// independence is assumed except that of the roundings.
///
/// The roundings are drawn from the operands: a repeated computation is rounded equally, as on a real machine.
#[derive(Debug, Clone, Copy)]
pub struct Number {
    exact: f64,
    lanes: [f64; LANES],
}

impl Number {
    /// The number zero.
    pub const ZERO: Self = Self { exact: 0.0, lanes: [0.0; LANES] };

    /// Creates a number that f32 represents exactly.
    pub fn known(value: f64) -> Self {
        Self { exact: value, lanes: [value; LANES] }
    }

    /// Creates an input, which f32 represents by the nearest number.
    #[expect(clippy::cast_possible_truncation, reason = "the core's inputs are f32")]
    pub fn given(value: f64) -> Self {
        Self::near(value, value as f32)
    }

    /// Creates an input with this representation in f32.
    pub(super) fn near(value: f64, in_f32: f32) -> Self {
        Self { exact: value, lanes: [f64::from(in_f32); LANES] }
    }

    /// Returns the value without rounding.
    pub fn exact(&self) -> f64 {
        self.exact
    }

    /// Returns the expected size of the error: the root of its mean square over the lanes.
    pub fn spread(&self) -> f64 {
        let squares = self.lanes.iter().map(|lane| (lane - self.exact).powi(2));
        (squares.sum::<f64>() / LANES as f64).sqrt()
    }

    /// Returns the limit of the f32 error: [`LAMBDA`] times its expected size.
    pub fn limit(&self) -> f64 {
        LAMBDA * self.spread()
    }

    /// Applies an operation in each lane, and rounds its result.
    #[inline]
    fn rounded(exact: f64, key: u64, lane: impl Fn(usize) -> f64) -> Self {
        Self::rounded_more(exact, 1.0, key, lane)
    }

    /// Rounds like [`Self::rounded`], but with `times` times the standard deviation, for a function that consists of
    /// `times²` rounding steps.
    #[inline]
    fn rounded_more(exact: f64, times: f64, key: u64, lane: impl Fn(usize) -> f64) -> Self {
        // A rounding is uniform within half a unit: its standard deviation is half a unit divided by the root of 3.
        let deviation = times * HALF_ULP * power_of_two_below(exact) / 3f64.sqrt();
        let signs = signs_of(key, exact < 0.0);
        Self { exact, lanes: array::from_fn(|k| lane(k) + deviation * signs[k / 4][k % 4]) }
    }

    /// Returns a key that identifies the number, but not its sign: the first lane without its last digits, which
    /// are f64's own rounding, mixed as in `SplitMix64`.
    #[inline]
    fn key(&self) -> u64 {
        mixed((self.lanes[0].to_bits() << 1) >> 17)
    }

    /// Returns whether the number is exactly this value in all lanes (the first lane is checked for all).
    #[expect(clippy::float_cmp, reason = "what rounds nothing is exact")]
    #[inline]
    fn is(&self, value: f64) -> bool {
        self.exact == value && self.lanes[0] == value
    }

    /// Returns the square root.
    #[must_use]
    pub fn sqrt(self) -> Self {
        Self::rounded(self.exact.max(0.0).sqrt(), self.key(), |k| self.lanes[k].max(0.0).sqrt())
    }

    /// Applies an elementary function: a polynomial and a range reduction, about four steps.
    #[must_use]
    pub fn function(self, of: impl Fn(f64) -> f64) -> Self {
        Self::rounded_more(of(self.exact), 2.0, self.key(), |k| of(self.lanes[k]))
    }

    /// Applies an elementary function of two numbers.
    #[must_use]
    pub fn function_with(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        let exact = of(self.exact, other.exact);
        let key = self.key().wrapping_add(other.key().rotate_left(1));
        Self::rounded_more(exact, 2.0, key, |k| of(self.lanes[k], other.lanes[k]))
    }

    /// Multiplies by a power of two, which does not round.
    #[must_use]
    pub fn doubled(self, times: f64) -> Self {
        Self { exact: self.exact * times, lanes: self.lanes.map(|lane| lane * times) }
    }
}

/// Returns the largest power of two that is not above the magnitude of a number; 0 for 0.
#[inline]
fn power_of_two_below(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & 0x7ff0_0000_0000_0000)
}

/// Mixes bits, to make all of them depend on all input bits.
#[inline]
fn mixed(bits: u64) -> u64 {
    let z = bits.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Returns a random sign for each lane. The signs for a negative number are inverted.
#[inline]
fn signs_of(key: u64, negative: bool) -> [&'static [f64; 4]; LANES / 4] {
    const PLUS_MINUS: [[f64; 4]; 16] = {
        let mut table = [[1.0; 4]; 16];
        let mut row = 0;
        while row < 16 {
            let mut bit = 0;
            while bit < 4 {
                if row >> bit & 1 == 1 {
                    table[row][bit] = -1.0;
                }
                bit += 1;
            }
            row += 1;
        }
        table
    };
    let turned = if negative { u64::MAX } else { 0 };
    let bits = mixed(key) ^ turned;
    array::from_fn(|four| {
        #[expect(clippy::cast_possible_truncation, reason = "four bits")]
        let row = (bits >> (4 * four)) as usize & 15;
        &PLUS_MINUS[row]
    })
}

/// Implements an operation with rounding, unless the result is exactly one of the operands.
macro_rules! rounded {
    ($operation:ident, $name:ident, $sign:tt, $stays:expr) => {
        impl $operation for Number {
            type Output = Self;

            #[inline]
            fn $name(self, other: Self) -> Self {
                let stays: fn(&Self, &Self) -> (bool, bool) = $stays;
                match stays(&self, &other) {
                    (true, _) => self,
                    (_, true) => other,
                    // The sum of the keys does not depend on the order of the operands.
                    _ => {
                        let key = self.key().wrapping_add(other.key());
                        Self::rounded(self.exact $sign other.exact, key, |k| {
                            self.lanes[k] $sign other.lanes[k]
                        })
                    }
                }
            }
        }
    };
}

rounded!(Add, add, +, |a, b| (b.is(0.0), a.is(0.0)));
rounded!(Sub, sub, -, |_, b| (b.is(0.0), false));
rounded!(Mul, mul, *, |a, b| (b.is(1.0), a.is(1.0)));
rounded!(Div, div, /, |_, b| (b.is(1.0), false));

impl Neg for Number {
    type Output = Self;

    fn neg(self) -> Self {
        self.doubled(-1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_stays_and_what_is_given_is_off_by_what_f32_leaves_out() {
        assert_eq!(Number::known(0.1).limit().to_bits(), 0);
        let left_out = 0.1 - f64::from(0.1f32);
        assert!((Number::given(0.1).spread() - left_out.abs()).abs() < 1e-17);
        assert_eq!(Number::given(0.5).limit().to_bits(), 0);
    }

    /// The error of a sum of n numbers near 1 grows with the root of n; that of n equal numbers grows with n,
    /// since their roundings are equal.
    #[test]
    fn errors_grow_with_the_root_of_their_number_unless_they_are_the_same() {
        let steps = 4096;
        let products: Vec<_> = (0..steps)
            .map(|k| Number::known(1.0 + f64::from(k) * 1e-7) * Number::known(1.1))
            .collect();
        let norm = |numbers: &[Number]| {
            let sums: [f64; LANES] =
                array::from_fn(|k| numbers.iter().map(|n| n.lanes[k] - n.exact).sum());
            (sums.iter().map(|sum| sum * sum).sum::<f64>() / LANES as f64).sqrt()
        };
        let one = HALF_ULP / 3f64.sqrt();
        let of_many = norm(&products) / (one * f64::from(steps).sqrt());
        assert!((0.6..1.6).contains(&of_many), "{of_many}");
        let same = norm(&vec![products[1]; 4096]) / (one * f64::from(steps));
        assert!((same - 1.0).abs() < 1e-6, "{same}");
    }

    #[test]
    fn a_difference_of_like_numbers_is_off_by_what_they_are() {
        let (a, b) = (Number::known(1.5) * Number::known(1.1), Number::known(1.65));
        let difference = a - b;
        assert!(difference.exact().abs() < 1e-15);
        assert!((difference.spread() / (HALF_ULP / 3f64.sqrt()) - 1.0).abs() < 1e-6);
    }
}
