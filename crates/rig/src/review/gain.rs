//! Maximum stiffness of a joint's loop at a control rate.

/// Returns the largest stable angle `ω dt` of a critically damped PD loop with natural frequency ω on a double
/// integrator. Torques are held for a tick and act `latency_ticks` late; velocities are backward differences.
///
/// The loop's characteristic polynomial is `2 (z - 1)² z^(L+1) + (z + 1)(w² z + 2 w (z - 1))` with `w = ω dt` (the
/// double integrator under a zero-order hold); the bound is found by bisection with the test of Schur and Cohn.
pub fn largest_stable_angle(latency_ticks: usize) -> f64 {
    let (mut stable, mut unstable) = (0.0, 4.0);
    // Further bisection exceeds the digits of f64.
    for _ in 0..52 {
        let middle = 0.5 * (stable + unstable);
        if is_stable(&characteristic(middle, latency_ticks)) {
            stable = middle;
        } else {
            unstable = middle;
        }
    }
    stable
}

/// Returns the coefficients of the characteristic polynomial, the constant one first.
fn characteristic(w: f64, latency_ticks: usize) -> Vec<f64> {
    let mut coefficients = vec![0.0; latency_ticks + 4];
    // (z + 1)((w² + 2w) z - 2w)
    let feedback = [-2.0 * w, w * w, w * w + 2.0 * w];
    let plant = [2.0, -4.0, 2.0];
    let (low, high) = coefficients.split_at_mut(latency_ticks + 1);
    for (slot, x) in low.iter_mut().chain(high.iter_mut()).zip(feedback) {
        *slot += x;
    }
    for (slot, x) in high.iter_mut().zip(plant) {
        *slot += x;
    }
    coefficients
}

/// Returns whether all roots are inside the unit circle (Schur and Cohn).
fn is_stable(coefficients: &[f64]) -> bool {
    let mut p = coefficients.to_vec();
    while let (Some(&first), Some(&last)) = (p.first(), p.last()) {
        if p.len() == 1 {
            return true;
        }
        if first.abs() >= last.abs() {
            return false;
        }
        let next: Vec<f64> =
            p.iter().zip(p.iter().rev()).map(|(x, mirrored)| last * x - first * mirrored).collect();
        // The constant coefficient is zero now: divide by z. Scaling keeps long polynomials within the range of
        // f64.
        let scale = next.last().map_or(1.0, |last| 1.0 / last.abs());
        p = next.into_iter().skip(1).map(|x| x * scale).collect();
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Simulates the loop tick by tick, and returns whether it decays.
    fn decays(w: f64, latency_ticks: usize) -> bool {
        let (mut x, mut v) = (1.0_f64, 0.0);
        let mut positions = vec![1.0; latency_ticks + 2];
        for _ in 0..20_000 {
            positions.push(x);
            let seen = positions[positions.len() - 1 - latency_ticks];
            let before = positions[positions.len() - 2 - latency_ticks];
            let a = -(w * w * seen + 2.0 * w * (seen - before));
            (x, v) = (x + v + 0.5 * a, v + a);
        }
        x.abs() < 1.0
    }

    #[test]
    fn the_bound_is_where_the_loop_itself_begins_to_grow() {
        for latency_ticks in [0, 1, 2, 5, 20] {
            let bound = largest_stable_angle(latency_ticks);
            assert!(decays(bound * 0.98, latency_ticks), "{latency_ticks}: {bound}");
            assert!(!decays(bound * 1.02, latency_ticks), "{latency_ticks}: {bound}");
        }
    }

    #[test]
    fn latency_costs_gain() {
        let bounds: Vec<f64> = (0..5).map(largest_stable_angle).collect();
        assert!(bounds.windows(2).all(|pair| pair[1] < pair[0]), "{bounds:?}");
    }
}
