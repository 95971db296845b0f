//! A number with its rounding: as it is, and as f32 may have it, many times over.

use std::array;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// How many times a computation is done beside the exact one.
const LANES: usize = 32;

/// How many times its expected size a rounding error may be: λ in Higham & Mary, *A new approach to probabilistic
/// rounding error analysis* (2019).
///
/// A rounding is taken as a random number within half a unit of the last place. A sum of such is sub-Gaussian: it is
/// above λ times its standard deviation σ with a probability below `2 exp(-λ² / 2)`, 3e-14 for 8. Known is not σ but
/// what 32 tries say about it: with that it is Student's distribution of 32 degrees of freedom, 4e-9.
pub const LAMBDA: f64 = 8.0;

/// What a rounding error of f64 is of one of f32.
pub const DOUBLE: f64 = 1.0 / (1u64 << 29) as f64;

/// Half a unit in the last place of f32, as a fraction of the power of two below.
const HALF_ULP: f64 = f32::EPSILON as f64 / 2.0;

/// A number of a computation in f32: what it would be without rounding, and what it is with roundings drawn at random,
/// by lane. What one rounding does to the result, by however many ways, a lane does too: nothing is linearised, and
/// no independence is assumed but that of the roundings.
///
/// The roundings are drawn from the numbers that are computed with: the same computation is rounded alike each time, as
/// a machine does it.
#[derive(Debug, Clone, Copy)]
pub struct Number {
    exact: f64,
    lanes: [f64; LANES],
}

impl Number {
    /// Zero.
    pub const ZERO: Self = Self { exact: 0.0, lanes: [0.0; LANES] };

    /// A number that f32 has as it is.
    pub fn known(value: f64) -> Self {
        Self { exact: value, lanes: [value; LANES] }
    }

    /// An input, of which f32 has the nearest number.
    #[expect(clippy::cast_possible_truncation, reason = "the core's inputs are f32")]
    pub fn given(value: f64) -> Self {
        Self::near(value, value as f32)
    }

    /// An input, of which f32 has this.
    pub(super) fn near(value: f64, in_f32: f32) -> Self {
        Self { exact: value, lanes: [f64::from(in_f32); LANES] }
    }

    /// Without rounding.
    pub fn exact(&self) -> f64 {
        self.exact
    }

    /// Expected size of the error: the root of its mean square over the lanes.
    pub fn spread(&self) -> f64 {
        let squares = self.lanes.iter().map(|lane| (lane - self.exact).powi(2));
        (squares.sum::<f64>() / LANES as f64).sqrt()
    }

    /// What the error of f32 may be: [`LAMBDA`] times its expected size.
    pub fn limit(&self) -> f64 {
        LAMBDA * self.spread()
    }

    /// An operation by lane, and the rounding of its result.
    #[inline]
    fn rounded(exact: f64, key: u64, lane: impl Fn(usize) -> f64) -> Self {
        Self::rounded_more(exact, 1.0, key, lane)
    }

    /// As [`Self::rounded`], `times` as much: of a function that takes the square of that many steps.
    #[inline]
    fn rounded_more(exact: f64, times: f64, key: u64, lane: impl Fn(usize) -> f64) -> Self {
        // A number is uniform within half a unit: the standard deviation is that over the root of 3.
        let deviation = times * HALF_ULP * power_of_two_below(exact) / 3f64.sqrt();
        let signs = signs_of(key, exact < 0.0);
        Self { exact, lanes: array::from_fn(|k| lane(k) + deviation * signs[k / 4][k % 4]) }
    }

    /// What tells it from other numbers, but not from its negative: the first lane, without the last digits, which are
    /// f64's own rounding; mixed as `SplitMix64` does it.
    #[inline]
    fn key(&self) -> u64 {
        mixed((self.lanes[0].to_bits() << 1) >> 17)
    }

    /// Whether it is this in all lanes (which the first stands for).
    #[expect(clippy::float_cmp, reason = "what rounds nothing is exact")]
    #[inline]
    fn is(&self, value: f64) -> bool {
        self.exact == value && self.lanes[0] == value
    }

    /// The square root.
    #[must_use]
    pub fn sqrt(self) -> Self {
        Self::rounded(self.exact.max(0.0).sqrt(), self.key(), |k| self.lanes[k].max(0.0).sqrt())
    }

    /// An elementary function: a polynomial and what brings its argument into range, some four steps.
    #[must_use]
    pub fn function(self, of: impl Fn(f64) -> f64) -> Self {
        Self::rounded_more(of(self.exact), 2.0, self.key(), |k| of(self.lanes[k]))
    }

    /// An elementary function of two numbers.
    #[must_use]
    pub fn function_with(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        let exact = of(self.exact, other.exact);
        let key = self.key().wrapping_add(other.key().rotate_left(1));
        Self::rounded_more(exact, 2.0, key, |k| of(self.lanes[k], other.lanes[k]))
    }

    /// Times a power of two, which rounds nothing.
    #[must_use]
    pub fn doubled(self, times: f64) -> Self {
        Self { exact: self.exact * times, lanes: self.lanes.map(|lane| lane * times) }
    }
}

/// The largest power of two that is not above a number; 0 for 0.
#[inline]
fn power_of_two_below(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & 0x7ff0_0000_0000_0000)
}

/// Well mixed bits of others.
#[inline]
fn mixed(bits: u64) -> u64 {
    let z = bits.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A random sign for each lane. A negative number is rounded the other way.
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

/// An operation with a rounding, unless it leaves the one number or the other as it is.
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
                    // The other way round it is the same.
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

    /// A sum of n numbers next to 1 is off by the root of n; of n times the same number, by what n times that rounding
    /// is.
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
