//! Rounding and formatting of numbers, and their conversion to f32.

/// Significant digits that are kept. Rounding errors of conversions affect the last four of an f64's 16 digits;
/// f32, which finally stores the numbers, has 7.
const DIGITS: u8 = 12;

/// Converts a number to f32. A number that is too large becomes infinite, which later checks refuse.
#[expect(clippy::cast_possible_truncation, reason = "to f32 is what it is for")]
pub(crate) fn single(number: f64) -> f32 {
    number as f32
}

/// Rounds a number to [`DIGITS`] significant digits.
pub(crate) fn rounded(number: f64) -> f64 {
    if number.is_finite() {
        // The text of a finite number is always a number.
        format!("{number:.*e}", usize::from(DIGITS - 1)).parse().unwrap_or(number)
    } else {
        number
    }
}

/// Rounds numbers that belong together, such as elements of a vector. Also removes values that are below the last
/// digit of the largest number, because they are noise: for example the cosine of a right angle.
pub(crate) fn rounded_together(numbers: &[f64]) -> Vec<f64> {
    let largest = numbers.iter().fold(0.0_f64, |largest, number| largest.max(number.abs()));
    // Half a step of the largest number's last digit.
    let noise = largest * 0.5 * 10.0_f64.powi(1 - i32::from(DIGITS));
    numbers
        .iter()
        .map(|number| if number.abs() <= noise { 0.0 } else { rounded(*number) })
        .collect()
}

/// Returns the shortest text that TOML reads as the same number.
pub(crate) fn text(number: f64) -> String {
    let size = number.abs();
    if size <= 0.0 {
        "0".to_owned()
    } else if number.is_nan() {
        "nan".to_owned()
    } else if (1e-4..1e9).contains(&size) || number.is_infinite() {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}

/// Returns numbers as text in square brackets.
pub(crate) fn list_text(numbers: &[f64]) -> String {
    let texts: Vec<_> = numbers.iter().map(|number| text(*number)).collect();
    format!("[{}]", texts.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_rounded_and_the_rest_is_short() {
        for (number, expected) in [
            (0.1 + 0.2, "0.3"),
            (90.0, "90"),
            (-0.0, "0"),
            (1.2345e-7, "1.2345e-7"),
            (1e-4, "0.0001"),
            (2.5e12, "2.5e12"),
            (std::f64::consts::FRAC_1_SQRT_2, "0.707106781187"),
            (f64::NAN, "nan"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            assert_eq!(text(rounded(number)), expected);
        }
        let right_angle = std::f64::consts::FRAC_PI_2;
        assert_eq!(list_text(&rounded_together(&[right_angle.cos(), right_angle.sin()])), "[0, 1]");
    }
}
