//! One span of a cubic spline with knots of any distance, as a polynomial.

/// Value, first and second derivative.
pub(crate) type Jet = [f32; 3];

/// A cubic over one span: position, velocity and half of the acceleration at its first knot, and a sixth of the jerk,
/// per sample.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Cubic([f32; 4]);

impl Cubic {
    /// Of the span from knot 2 to knot 3 of six. `control`: the control values of knots 1 to 4.
    ///
    /// The control polygon's slopes (quadratic B-spline) and their slopes (linear: the accelerations at the two knots).
    /// De Boor, A Practical Guide to Splines, chapter X. The acceleration at a knot comes out with the same bits on
    /// both of its sides.
    pub(crate) fn new(knots: &[i32; 6], control: [i32; 4], step: f32) -> Self {
        let [t0, t1, t2, t3, t4, t5] = *knots;
        let [c1, c2, c3, c4] = control;
        let over = |from: i32, to: i32| to.wrapping_sub(from) as f32;
        let slope =
            |from: i32, to: i32, knots: f32| step * (to.wrapping_sub(from) as f32) * 3.0 / knots;
        let s1 = slope(c1, c2, over(t0, t3));
        let s2 = slope(c2, c3, over(t1, t4));
        let s3 = slope(c3, c4, over(t2, t5));
        let (before, here, after) = (over(t1, t2), over(t2, t3), over(t1, t3));
        let first = 2.0 * (s2 - s1) / after;
        let last = 2.0 * (s3 - s2) / over(t2, t4);
        let velocity = (s1 * here + s2 * before) / after;
        let position =
            step * c2 as f32 - velocity * (here - before) / 3.0 + first * (before * here) / 6.0;
        Self([position, velocity, first * 0.5, (last - first) / (6.0 * here)])
    }

    /// At so many samples behind the first knot; derivatives per sample.
    pub(crate) fn at(&self, u: f32) -> Jet {
        let [p, v, a, j] = self.0;
        [p + u * (v + u * (a + u * j)), v + u * (2.0 * a + u * (3.0 * j)), 2.0 * a + u * (6.0 * j)]
    }
}

#[cfg(all(test, feature = "std"))]
mod tests {
    use super::*;
    use crate::write::weights;

    #[test]
    #[expect(
        clippy::indexing_slicing,
        clippy::cast_possible_truncation,
        reason = "a test, of numbers that are near"
    )]
    fn the_curve_and_its_derivatives_are_the_spline_s() {
        let mut random = 5u32;
        let mut next = |below: i32| {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            i32::try_from(random >> 8).unwrap_or(0) % below
        };
        for _ in 0..2000 {
            let mut knots = [next(1000) - 500; 6];
            for k in 1..6 {
                knots[k] =
                    knots[k - 1] + crate::span_lengths::span(u8::try_from(next(12)).unwrap_or(0));
            }
            let control = [0; 4].map(|_| next(4000) - 2000);
            let step = 1e-3;
            let cubic = Cubic::new(&knots, control, step);
            let len = f64::from(knots[3] - knots[2]);
            let exact = |u: f64| -> f64 {
                let weights = weights(knots, f64::from(knots[2]) + u);
                weights.iter().zip(control).map(|(w, c)| w * f64::from(c)).sum::<f64>()
                    * f64::from(step)
            };
            // Differences of a cubic by so much are exact, but for rounding and the third derivative's part in speed.
            let h = len * 1e-3;
            let shortest = knots.windows(2).map(|w| f64::from(w[1] - w[0])).fold(len, f64::min);
            for share in [0.0f32, 0.1, 0.5, 0.9, 1.0] {
                let (u, u_f32) = (len * f64::from(share), len as f32 * share);
                let middle = u.clamp(h, len - h);
                let (a, b, c) = (exact(middle - h), exact(middle), exact(middle + h));
                let acceleration = (a - 2.0 * b + c) / (h * h);
                let speed = (c - a) / (2.0 * h);
                let at_middle = cubic.at(middle as f32).map(f64::from);
                // Rounding of f32, of control values up to 2 over the shortest span.
                let size = 2.0 * 8.0 * f64::from(f32::EPSILON);
                assert!((f64::from(cubic.at(u_f32)[0]) - exact(u)).abs() < size);
                assert!(
                    (at_middle[1] - speed).abs()
                        < size / shortest
                            + 1e-4 * speed.abs() * 1e-2
                            + 6.0 * 4.0 / shortest.powi(3) * h * h / 6.0
                );
                assert!(
                    (at_middle[2] - acceleration).abs()
                        < 6.0 * size / shortest.powi(2)
                            + 1e-7 * acceleration.abs()
                            + 1e-15 / (h * h)
                );
            }
        }
    }
}
