//! Share of each joint's motion that a fit has left: the share of the joint's way, and the correlation with the given
//! motion.

use std::fmt::Write as _;

use sinew_retarget::feasibility::RigMotion;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;

/// Way of a joint, rad or m, below which the joint counts as still.
const STILL: f64 = 5e-3;
/// Share of the way and correlation below which the headline names a joint.
const LEAST_WAY: f64 = 0.5;
const LEAST_ALIKE: f64 = 0.9;
/// Share of the way and correlation above which a joint gets no line.
const WHOLE_WAY: f64 = 0.98;
const WHOLE_ALIKE: f64 = 0.995;

/// Motion of a joint, or of one axis of a universal joint, after a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct JointLeft {
    /// Name of the joint or axis.
    pub name: String,
    /// Way of the joint as a share of its way in the given motion.
    pub way: f64,
    /// Correlation with the given motion at equal times; 0 if the joint no longer moves.
    pub alike: f64,
}

impl JointLeft {
    /// Compares the joints of a motion with those of the given motion, at equal times. Omits a free base, joints that
    /// follow others, and joints that are still in the given motion.
    pub fn each(mechanism: &Mechanism, motion: &RigMotion, given: &RigMotion) -> Vec<Self> {
        let ties = mechanism.ties();
        let mut names = mechanism.dof_names().into_iter();
        let mut all = Vec::new();
        for (body, (link, range)) in
            mechanism.bodies.iter().zip(mechanism.coordinate_ranges()).enumerate()
        {
            let own: Vec<String> = names.by_ref().take(link.joint.kind().dof_count()).collect();
            if link.joint == JointModel::Free || ties.of(body).is_some() {
                continue;
            }
            let parts: Vec<(String, Vec<usize>)> = if own.len() == range.len() {
                own.into_iter().zip(range.map(|k| vec![k])).collect()
            } else {
                vec![(link.joint_name.clone(), range.collect())]
            };
            let of =
                |(name, numbers): (String, Vec<usize>)| Self::of(name, &numbers, motion, given);
            all.extend(parts.into_iter().filter_map(of));
        }
        all
    }

    fn of(name: String, numbers: &[usize], motion: &RigMotion, given: &RigMotion) -> Option<Self> {
        let meant: Vec<Vec<f64>> = given.rows.iter().map(|row| at(row, numbers)).collect();
        let given_way = way(given, numbers);
        if given_way < STILL {
            return None;
        }
        let done: Vec<Vec<f64>> = (0..meant.len())
            .map(|row| {
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "rows")]
                let place = (row as f64 * given.dt_s / motion.dt_s).round() as usize;
                at(&motion.rows[place.min(motion.rows.len() - 1)], numbers)
            })
            .collect();
        let way = (way(motion, numbers) / given_way).min(1.0);
        Some(Self { name, way, alike: correlation(&done, &meant) })
    }

    /// Returns whether the headline names the joint, because little of its motion is left.
    pub fn is_far(&self) -> bool {
        self.way < LEAST_WAY || self.alike < LEAST_ALIKE
    }

    fn is_whole(&self) -> bool {
        self.way >= WHOLE_WAY && self.alike >= WHOLE_ALIKE
    }
}

/// Returns a line for each joint whose motion has visibly changed.
pub(super) fn lines(all: &[JointLeft]) -> String {
    let mut out = String::new();
    for JointLeft { name, way, alike } in all.iter().filter(|joint| !joint.is_whole()) {
        let _ = writeln!(
            out,
            "left of {name}: {:.0} % of its way, correlation {} with what was meant",
            100.0 * way,
            shown(*alike)
        );
    }
    out
}

/// Returns the headline of a fit, or `None` if the change is not worth a headline. If the motion became slower, the
/// headline has both durations and the share of the way that is left. Otherwise it has this share, and, for a fit that
/// keeps the time, the joints with little motion left. `way`: share of the way of all joints.
pub(super) fn headline(
    [given_s, fitted_s]: [f64; 2],
    way: f64,
    in_time: Option<&[JointLeft]>,
) -> Option<String> {
    let percent = 100.0 * way;
    if fitted_s > given_s + 0.005 {
        let line = format!(
            "SLOWED DOWN: {given_s:.1} s became {fitted_s:.1} s, {percent:.0} % of the way is left"
        );
        return Some(line);
    }
    let far: Vec<String> = in_time
        .unwrap_or_default()
        .iter()
        .filter(|joint| joint.is_far())
        .map(|joint| {
            let alike = shown(joint.alike);
            format!("{} ({:.0} %, correlation {alike})", joint.name, 100.0 * joint.way)
        })
        .collect();
    let far =
        if far.is_empty() { String::new() } else { format!("; little of {}", far.join(", ")) };
    let is_whole = way >= WHOLE_WAY && far.is_empty();
    let what = if in_time.is_some() { "TIME KEPT" } else { "SMALLER" };
    (!is_whole).then(|| format!("{what}: {fitted_s:.1} s, {percent:.0} % of the way is left{far}"))
}

/// Returns the selected numbers of a row. A quaternion is returned with a positive last number.
fn at(row: &[f64], numbers: &[usize]) -> Vec<f64> {
    let mut at: Vec<f64> = numbers.iter().map(|k| row[*k]).collect();
    if let [.., w] = at[..]
        && at.len() == 4
        && w < 0.0
    {
        for x in &mut at {
            *x = -*x;
        }
    }
    at
}

/// Returns the length of the path of the selected numbers over all rows.
fn way(motion: &RigMotion, numbers: &[usize]) -> f64 {
    let step = |pair: &[Vec<f64>]| {
        let [from, to] = [0, 1].map(|row| at(&pair[row], numbers));
        from.iter().zip(to).map(|(from, to)| (to - from).powi(2)).sum::<f64>().sqrt()
    };
    motion.rows.windows(2).map(step).sum()
}

/// Returns the correlation of two sequences of vectors; 0 if a sequence is constant.
fn correlation(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let [mut cross, mut of_a, mut of_b] = [0.0_f64; 3];
    for k in 0..a.first().map_or(0, Vec::len) {
        let mean =
            |rows: &[Vec<f64>]| rows.iter().map(|row| row[k]).sum::<f64>() / rows.len() as f64;
        let [mean_a, mean_b] = [mean(a), mean(b)];
        for (a, b) in a.iter().zip(b) {
            let [a, b] = [a[k] - mean_a, b[k] - mean_b];
            cross += a * b;
            of_a += a * a;
            of_b += b * b;
        }
    }
    let both = (of_a * of_b).sqrt();
    if both > 1e-12 { cross / both } else { 0.0 }
}

/// Formats a correlation with two decimals, and zero without a sign.
fn shown(alike: f64) -> String {
    let alike = if alike.abs() < 0.005 { 0.0 } else { alike };
    format!("{alike:.2}")
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sinew_rig::mechanism::Link;

    use super::*;

    fn rig() -> Mechanism {
        let joint = |name: &str| Link {
            joint_name: name.to_owned(),
            ..Link::on(Some(0), JointModel::Revolute(DVec3::Z), DVec3::ZERO)
        };
        let base = Link::on(None, JointModel::Fixed, DVec3::ZERO);
        Mechanism { bodies: vec![base, joint("jaw"), joint("brow")], linked: vec![] }
    }

    fn motion(dt_s: f64, jaw: impl Fn(f64) -> f64) -> RigMotion {
        #[expect(clippy::cast_possible_truncation, reason = "10 s")]
        let rows = (10.0 / dt_s) as i32;
        let row = |row: i32| vec![jaw(f64::from(row) * dt_s), 0.0];
        RigMotion { dt_s, rows: (0..=rows).map(row).collect() }
    }

    #[test]
    fn way_and_correlation_are_those_of_each_joint_that_moves() {
        let given = motion(0.02, f64::sin);
        let half = motion(0.01, |t| 0.4 * t.sin());
        let all = JointLeft::each(&rig(), &half, &given);
        assert_eq!(all.len(), 1);
        assert!(all[0].name == "jaw" && (all[0].way - 0.4).abs() < 1e-3 && all[0].alike > 0.9999);
        assert!(all[0].is_far() && lines(&all).contains("left of jaw: 40 % of its way"));
        // A motion that is late by a quarter of a period has no correlation.
        let late = motion(0.02, |t| (t - 1.57).sin());
        let [late] = &JointLeft::each(&rig(), &late, &given)[..] else { panic!() };
        assert!(late.way > 0.9 && late.alike < 0.3, "{late:?}");
        let still = motion(0.02, |_| 0.3);
        assert!(JointLeft::each(&rig(), &still, &given)[0].alike.abs() < 1e-9);
    }

    #[test]
    fn a_headline_tells_slowness_and_what_is_lost() {
        let told = headline([12.0, 27.7], 0.2, None).unwrap();
        assert_eq!(told, "SLOWED DOWN: 12.0 s became 27.7 s, 20 % of the way is left");
        let joint = |way, alike| JointLeft { name: "jaw".into(), way, alike };
        let told = headline([6.1, 6.1], 0.8, Some(&[joint(0.9, 0.96), joint(0.4, 0.93)])).unwrap();
        let expected =
            "TIME KEPT: 6.1 s, 80 % of the way is left; little of jaw (40 %, correlation 0.93)";
        assert_eq!(told, expected);
        assert_eq!(headline([6.1, 6.1], 1.0, Some(&[joint(1.0, 1.0)])), None);
        assert_eq!(headline([6.1, 6.1], 1.0, None), None);
    }
}
