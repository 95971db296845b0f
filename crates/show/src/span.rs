//! A span of a cubic spline with unequal knots, as a polynomial.

/// Value, first and second derivative.
pub(crate) type Jet = [f32; 3];

/// A cubic over a span: position, velocity and half the acceleration at its first knot, and a sixth of the jerk, per
/// sample.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Cubic([f32; 4]);

impl Cubic {
    /// Returns the cubic of the span from knot 2 to knot 3 of six. `control`: the control values of knots 1 to 4.
    ///
    /// It is computed from the control polygon's slopes (quadratic B-spline) and their slopes (linear: the
    /// accelerations at the two knots). De Boor, A Practical Guide to Splines, chapter X. The acceleration at a knot
    /// has the same bits on both of its sides.
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

    /// Evaluates the cubic `u` samples after the first knot. Derivatives are per sample.
    pub(crate) fn at(&self, u: f32) -> Jet {
        let [p, v, a, j] = self.0;
        [p + u * (v + u * (a + u * j)), v + u * (2.0 * a + u * (3.0 * j)), 2.0 * a + u * (6.0 * j)]
    }
}
