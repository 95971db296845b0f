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

    /// A joint rests at the end of its range, or near it: its curve is exact except for the rounding.
    #[test]
    fn a_range_that_only_rounding_exceeds_is_not_exceeded() {
        let rig = arm(3).unwrap();
        let mechanism = rig.mechanism().unwrap();
        let limits = Limits::of(&mechanism, &Servos::of(&rig, &mechanism).unwrap());
        let end = limits.dofs[1].range[1];
        let found = |by_deg: f64, tolerance_deg: f64| -> [usize; 2] {
            let mut q = mechanism.home();
            q[1] = end + by_deg.to_radians();
            let motion = RigMotion { dt_s: 0.01, rows: vec![q; 100] };
            let settings =
                Settings { angle_rad: tolerance_deg.to_radians(), ..Settings::default() };
            let baker = Baker { mechanism: &mechanism, rig: 0, settings };
            let baked = baker.bake(&motion, &ShowMarks::default()).unwrap();
            let rounding = &baked.written.rounding;
            // A step is half of the tolerance, and a rounded number is at most half a step off.
            assert!(rounding[1].to_degrees() <= 0.2501 * tolerance_deg, "{rounding:?}");
            let played = ShowPlayback::new(&baked.written.bytes).unwrap();
            let report = check(&mechanism, &limits, &played, CHECK_HZ).unwrap();
            let all = report.excesses.iter().filter(|excess| excess.kind == Kind::Range);
            let own = all.clone().filter(|own| is_rounding(&mechanism, &limits, rounding, own));
            [own.count(), all.count()]
        };
        let mut rounded_up = 0;
        for tolerance_deg in [0.25, 0.2, 0.15, 0.11] {
            for by_deg in [0.0, -0.01, -0.02] {
                let [own, all] = found(by_deg, tolerance_deg);
                assert_eq!(own, all, "{by_deg} {tolerance_deg}");
                rounded_up += all;
            }
        }
        assert!(rounded_up > 0);
        // 0.2 deg are more than the rounding of 0.0625 deg, twice.
        assert_eq!(found(0.2, 0.25), [0, 1]);
    }
}
