//! Separates excesses of ranges from the rounding of a show.

use sinew_retarget::feasibility::{Excess, Kind, Limits};
use sinew_rig::Mechanism;

/// Returns whether a position is beyond its range by no more than the rounding of the show. `rounding`: rounding of
/// each coordinate, see [`Written::rounding`](sinew_show::write::Written::rounding).
pub(crate) fn is_rounding(
    mechanism: &Mechanism,
    limits: &Limits,
    rounding: &[f64],
    excess: &Excess,
) -> bool {
    let beyond = (excess.value - excess.limit).abs();
    let ranges = mechanism.coordinate_ranges();
    let of = |body: usize| rounding.get(ranges[body].start).copied().unwrap_or(0.0);
    let joint = limits.dofs[excess.dof].joint;
    match excess.kind {
        Kind::Range => {
            let first = limits.dofs.iter().position(|dof| dof.joint == joint).unwrap_or(excess.dof);
            let own = &rounding[ranges[joint].clone()];
            let dofs = limits.dofs.iter().filter(|dof| dof.joint == joint).count();
            let most = if own.len() == dofs {
                own.get(excess.dof - first).copied().unwrap_or(0.0)
            } else {
                // A rotation is twice as large as the change of its unit quaternion.
                2.0 * libm::sqrt(own.iter().map(|each| each * each).sum())
            };
            beyond <= most
        }
        Kind::LinkedRange => {
            limits.linked.iter().filter(|linked| linked.body == joint).any(|linked| {
                let sum = linked.factor.abs() * of(linked.body)
                    + linked.other_factor.abs() * of(linked.other);
                beyond <= sum
            })
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use sinew_retarget::feasibility::{RigMotion, check};
    use sinew_rig::new::arm;
    use sinew_rig::review::Servos;
    use sinew_show::write::Settings;

    use super::*;
    use crate::{Baker, CHECK_HZ, ShowMarks, ShowPlayback};

    /// A joint moves exactly to the end of its range, or beyond it. With a tolerance of 0.25 deg a control value is
    /// rounded by at most 0.0625 deg.
    #[test]
    fn a_range_is_exceeded_by_more_than_the_rounding_or_not_at_all() {
        let rig = arm(3).unwrap();
        let mechanism = rig.mechanism().unwrap();
        let limits = Limits::of(&mechanism, &Servos::of(&rig, &mechanism).unwrap());
        let end = limits.dofs[1].range[1];
        let baker = Baker { mechanism: &mechanism, rig: 0, settings: Settings::default() };
        // The end of the range is no whole number of steps: the last value is rounded to either side.
        let beyond = |by_deg: f64| -> (usize, usize) {
            let row = |row: i32| {
                let mut q = mechanism.home();
                let share = (f64::from(row.min(150)) / 150.0 * std::f64::consts::PI).cos();
                q[1] = end + by_deg.to_radians() - 0.25 * (1.0 + share);
                q
            };
            let motion = RigMotion { dt_s: 0.01, rows: (0..=300).map(row).collect() };
            let baked = baker.bake(&motion, &ShowMarks::default()).unwrap();
            let played = ShowPlayback::new(&baked.written.bytes).unwrap();
            let report = check(&mechanism, &limits, &played, CHECK_HZ).unwrap();
            let rounding = &baked.written.rounding;
            let most_deg = rounding[1].to_degrees();
            assert!(most_deg > 1e-4 && most_deg <= 0.0626, "{most_deg}");
            let ranges: Vec<&Excess> =
                report.excesses.iter().filter(|excess| excess.kind == Kind::Range).collect();
            let is_own = |excess: &&&Excess| is_rounding(&mechanism, &limits, rounding, excess);
            (ranges.iter().filter(is_own).count(), ranges.len())
        };
        let of_many: Vec<(usize, usize)> =
            (0..8).map(|part| beyond(-0.03 * f64::from(part))).collect();
        assert!(of_many.iter().any(|(_, all)| *all > 0), "{of_many:?}");
        let within: Vec<_> = (0..5).map(|part| beyond(0.01 * f64::from(part) - 0.04)).collect();
        println!("{of_many:?} {within:?}");
        // 0.5 deg is more than rounding and the error of 0.25 deg together.
        assert_eq!(beyond(0.5), (0, 1));
    }
}
