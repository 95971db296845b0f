//! Published segment parameters: P. de Leva, "Adjustments to Zatsiorsky-Seluyanov's segment inertia
//! parameters", J. Biomech. 29 (1996) 1223-1230, table 4, males (73.0 kg, 1.741 m).

/// Mass of the subject that the fractions are for by default, in kg: the mean of the sample.
pub(super) const MASS_KG: f64 = 73.0;

/// One row of the table. Lengths, centre and radii are turned from percent to fractions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    /// Mass, as a fraction of the body's.
    pub mass: f64,
    /// Length of the segment, as a fraction of stature.
    pub length: f64,
    /// Centre of mass, as a fraction of the length from the end that the figure's joint is at.
    pub center: f64,
    /// Radii of gyration about the centre of mass as fractions of the length: about the sagittal
    /// (front to back), the transverse (left to right) and the longitudinal axis.
    pub gyration: [f64; 3],
}

const STATURE_M: f64 = 1.741;

const fn row(mass: f64, length_m: f64, center: f64, gyration: [f64; 3]) -> Segment {
    let [s, t, l] = gyration;
    Segment {
        mass: mass / 100.0,
        length: length_m / STATURE_M,
        center: center / 100.0,
        gyration: [s / 100.0, t / 100.0, l / 100.0],
    }
}

// The table counts the trunk's parts and the head from the top, the figure's joints are at the bottom:
// their centres are 100 minus the table's.

/// Vertex to cervicale, since the figure's head turns at the neck: the table's alternative end points.
pub(super) const HEAD: Segment = row(6.94, 0.2429, 100.0 - 50.02, [30.3, 31.5, 26.1]);
/// Suprasternale to xyphion.
pub(super) const UPPER_TRUNK: Segment = row(15.96, 0.1707, 100.0 - 29.99, [71.6, 45.4, 65.9]);
/// Xyphion to omphalion.
pub(super) const MID_TRUNK: Segment = row(16.33, 0.2155, 100.0 - 45.02, [48.2, 38.3, 46.8]);
/// Omphalion to the middle of the hips.
pub(super) const LOWER_TRUNK: Segment = row(11.17, 0.1457, 100.0 - 61.15, [61.5, 55.1, 58.7]);
/// Shoulder to elbow.
pub(super) const UPPER_ARM: Segment = row(2.71, 0.2817, 57.72, [28.5, 26.9, 15.8]);
/// Elbow to wrist.
pub(super) const FOREARM: Segment = row(1.62, 0.2689, 45.74, [27.6, 26.5, 12.1]);
/// Wrist to third metacarpal.
pub(super) const HAND: Segment = row(0.61, 0.0862, 79.00, [62.8, 51.3, 40.1]);
/// Hip to knee.
pub(super) const THIGH: Segment = row(14.16, 0.4222, 40.95, [32.9, 32.9, 14.9]);
/// Knee to lateral malleolus.
pub(super) const SHANK: Segment = row(4.33, 0.4340, 44.59, [25.5, 24.9, 10.3]);
/// Heel to toe tip. Our assumption: the ankle lies a quarter of the foot in front of the heel.
pub(super) const FOOT: Segment = row(1.37, 0.2581, 44.15 - 25.0, [25.7, 24.5, 12.4]);

/// The upper trunk cut in three, as the paper's figure needs it: the thorax between two shoulder parts.
///
/// The upper trunk is taken for a solid elliptical column with the published radii of gyration, and cut
/// by two sagittal planes half-way between its middle and its sides. A shoulder part then has 19.6 % of
/// the mass (2.3 kg of 73): shoulder blade, collar bone and the muscles about them.
/// The three parts together have the mass and the inertia of the whole.
#[derive(Debug, Clone, Copy)]
pub(super) struct UpperTrunkParts {
    /// The middle part. Its centre of mass is that of the whole.
    pub thorax: Segment,
    /// The left or the right part; its `center` is measured from the middle of the trunk, as a fraction of
    /// the way to its side.
    pub shoulder: Segment,
}

/// Where the cut lies, as a fraction of the way from the middle of the trunk to its side.
const CUT: f64 = 0.5;

impl UpperTrunkParts {
    pub(super) fn new() -> Self {
        let whole = UPPER_TRUNK;
        let [depth, breadth, height] = second_moments(whole.gyration);

        // The outer part of a unit disc beyond x = CUT: with x = cos θ, all integrals are elementary.
        let angle = libm::acos(CUT);
        let sine = libm::sin(angle);
        let (sine_2, sine_4) = (libm::sin(2.0 * angle), libm::sin(4.0 * angle));
        let area = angle - sine * CUT;
        let center = 2.0 / 3.0 * sine * sine * sine / area;
        let mean_x2 = (angle / 4.0 - sine_4 / 16.0) / area;
        let mean_y2 = (2.0 / 3.0) * (3.0 * angle / 8.0 - sine_2 / 4.0 + sine_4 / 32.0) / area;
        let share = area / core::f64::consts::PI;
        let rest = 1.0 - 2.0 * share;

        // A quarter is the mean square of either coordinate over the whole disc.
        let scale = |moment: f64, mean_square: f64| moment * mean_square / 0.25;
        let shoulder = [scale(depth, mean_y2), scale(breadth, mean_x2 - center * center), height];
        let thorax = [
            scale(depth, (0.25 - 2.0 * share * mean_y2) / rest),
            scale(breadth, (0.25 - 2.0 * share * mean_x2) / rest),
            height,
        ];
        Self {
            thorax: Segment { mass: whole.mass * rest, gyration: gyration(thorax), ..whole },
            shoulder: Segment {
                mass: whole.mass * share,
                center,
                gyration: gyration(shoulder),
                ..whole
            },
        }
    }
}

/// Mean squares of the mass's distances along the sagittal, transverse and longitudinal axis, from the radii of
/// gyration about them.
fn second_moments([s, t, l]: [f64; 3]) -> [f64; 3] {
    let half_trace = 0.5 * (s * s + t * t + l * l);
    [half_trace - s * s, half_trace - t * t, half_trace - l * l]
}

/// The inverse of [`second_moments`].
fn gyration([s, t, l]: [f64; 3]) -> [f64; 3] {
    [libm::sqrt(t + l), libm::sqrt(s + l), libm::sqrt(s + t)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rows_sum_to_the_whole_body() {
        let limbs = [UPPER_ARM, FOREARM, HAND, THIGH, SHANK, FOOT];
        let middle = [HEAD, UPPER_TRUNK, MID_TRUNK, LOWER_TRUNK];
        let sum: f64 = middle.iter().map(|row| row.mass).sum::<f64>()
            + 2.0 * limbs.iter().map(|row| row.mass).sum::<f64>();
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    }

    #[test]
    fn the_three_parts_of_the_upper_trunk_are_the_whole() {
        let parts = UpperTrunkParts::new();
        let (thorax, shoulder) = (parts.thorax, parts.shoulder);
        assert!((thorax.mass + 2.0 * shoulder.mass - UPPER_TRUNK.mass).abs() < 1e-15);
        let whole = second_moments(UPPER_TRUNK.gyration);
        let half_breadth = 2.0 * whole[1].sqrt();
        for (axis, whole) in whole.into_iter().enumerate() {
            // Parallel axes: the shoulder parts' centres are away from the middle along the breadth only.
            let away = if axis == 1 { (shoulder.center * half_breadth).powi(2) } else { 0.0 };
            let sum = thorax.mass * second_moments(thorax.gyration)[axis]
                + 2.0 * shoulder.mass * (second_moments(shoulder.gyration)[axis] + away);
            let expected = UPPER_TRUNK.mass * whole;
            assert!((sum / expected - 1.0).abs() < 1e-12, "axis {axis}: {sum} {expected}");
        }
        // By numerical quadrature of the disc: area share 0.195501, centre 0.705020.
        assert!((shoulder.mass / UPPER_TRUNK.mass - 0.195_501).abs() < 1e-6);
        assert!((shoulder.center - 0.705_020).abs() < 1e-6);
    }
}
