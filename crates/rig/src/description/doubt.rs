//! Values of a valid rig file that its author probably did not mean: another unit, a place far away.

use std::f64::consts::TAU;
use std::fmt;

use glam::DVec3;

use super::{Description, JointType};
use crate::number::text;

/// Largest absolute value of a range's end that may be in radians: a whole turn, with a margin for rounding.
const TURN: f64 = TAU + 0.02;
/// Power of ten for the digits after the point that people write, at most five. A range that was converted from another
/// unit has more digits.
const DIGITS: f64 = 1e5;
/// A length is doubted if it is more than this factor times all other lengths of the rig together.
const FAR: f64 = 10.0;
/// Minimum length that is doubted because of the factor [`FAR`], m.
const LEAST_M: f64 = 1.0;
/// Length that is doubted in any rig, m.
const MOST_M: f64 = 20.0;

/// A doubtful value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Doubt {
    /// Part that the value belongs to: `joint elbow`.
    pub about: String,
    /// Value, and the reason for the doubt.
    pub text: String,
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.about, self.text)
    }
}

/// A length of the file, and the part that has it.
struct Length {
    about: String,
    key: &'static str,
    metres: f64,
}

impl Description {
    /// Returns doubtful values: ranges that look like radians, and lengths that are far beyond the rest of the rig.
    pub fn doubts(&self) -> Vec<Doubt> {
        let mut doubts = self.radians();
        doubts.extend(self.distances());
        doubts
    }

    /// Finds `range_deg` whose numbers are probably radians: they are at most a turn if read as radians, have few
    /// digits, and are not whole numbers. Whole numbers are found too if all ranges of the rig are at most a turn in
    /// radians.
    fn radians(&self) -> Vec<Doubt> {
        let of_joints = self.joints.iter().flat_map(|joint| {
            joint.range_rad.iter().map(move |range| ("joint", &joint.name, range))
        });
        let of_servos = self.servos.iter().flat_map(|servo| {
            servo.range_rad.iter().map(move |range| ("servo", &servo.name, range))
        });
        let ranges: Vec<_> = of_joints
            .chain(of_servos)
            .map(|(part, name, range)| (part, name, range.map(f64::to_degrees)))
            .collect();
        let is_small = |[least, most]: [f64; 2]| least < most && -TURN <= least && most <= TURN;
        let all_are_small = ranges.iter().all(|(_, _, range)| is_small(*range));
        ranges
            .into_iter()
            .filter(|(_, _, range)| {
                let is_written = |end: f64| (end * DIGITS - (end * DIGITS).round()).abs() < 1e-4;
                let is_whole = |end: f64| (end - end.round()).abs() < 1e-9;
                is_small(*range)
                    && range.iter().all(|end| is_written(*end))
                    && (all_are_small || !range.iter().all(|end| is_whole(*end)))
            })
            .map(|(part, name, [least, most])| {
                let [as_least, as_most] = [least, most].map(|end| end.to_degrees().round());
                let [least, most] = [least, most].map(|end| text((end * DIGITS).round() / DIGITS));
                Doubt {
                    about: format!("{part} {name}"),
                    text: format!(
                        "range_deg = [{least}, {most}] looks like radians, which would be [{as_least}, {as_most}] deg"
                    ),
                }
            })
            .collect()
    }

    /// Finds lengths that are much longer than all the others together, and lengths that are too long for any rig.
    fn distances(&self) -> Vec<Doubt> {
        let length = |about: String, key, vector: [f64; 3]| Length {
            about,
            key,
            metres: DVec3::from_array(vector).length(),
        };
        let mut lengths = Vec::new();
        for body in &self.bodies {
            let about = || format!("body {}", body.name);
            lengths.push(length(about(), "center_of_mass_m", body.center_of_mass_m));
            lengths.extend(body.box_m.map(|size_m| length(about(), "box_m", size_m)));
        }
        for joint in &self.joints {
            let about = || match joint.kind {
                JointType::Fixed => {
                    format!("joint {}, which holds body {}", joint.name, joint.child)
                }
                _ => format!("joint {}, which moves body {}", joint.name, joint.child),
            };
            lengths.push(length(about(), "position_m", joint.position_m));
        }
        let all_m: f64 = lengths.iter().map(|length| length.metres).sum();
        let mount = length("mount".to_owned(), "position_m", self.mount.position_m);
        let is_doubtful = |length: &Length| {
            let rest_m = all_m - length.metres;
            length.metres >= MOST_M
                || (length.metres >= LEAST_M && rest_m > 0.0 && length.metres > FAR * rest_m)
        };
        let mut found: Vec<_> = lengths.iter().filter(|length| is_doubtful(length)).collect();
        found.extend(Some(&mount).filter(|mount| mount.metres >= MOST_M));
        let doubt = |length: &&Length| {
            let metres = length.metres;
            let rest_m = all_m - metres;
            let beside = if length.about == "mount" || rest_m <= 0.0 {
                String::new()
            } else {
                format!(", all other lengths of the rig together {rest_m:.3} m")
            };
            Doubt {
                about: length.about.clone(),
                text: format!(
                    "its {} is {metres:.1} m long{beside}: a number in mm? ({:.4} m)",
                    length.key,
                    metres * 1e-3
                ),
            }
        };
        found.iter().map(doubt).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{Body, Joint, Servo};

    /// Returns a rig of three bodies on joints with these ranges, deg, and distances, m.
    fn rig(joints: &[([f64; 2], f64)]) -> Description {
        let body = |name: String| Body { name, ..Body::default() };
        let mut bodies = vec![body("base".to_owned())];
        bodies.extend((0..joints.len()).map(|index| body(format!("b{index}"))));
        let joints = joints.iter().enumerate().map(|(index, (range_deg, metres))| Joint {
            name: format!("j{index}"),
            parent: bodies[index].name.clone(),
            child: format!("b{index}"),
            axis: Some([0.0, 0.0, 1.0]),
            range_rad: vec![range_deg.map(f64::to_radians)],
            position_m: [0.0, *metres, 0.0],
            ..Joint::default()
        });
        let joints = joints.collect();
        Description { name: "rig".to_owned(), bodies, joints, ..Description::default() }
    }

    fn told(rig: &Description) -> Vec<String> {
        rig.doubts().iter().map(ToString::to_string).collect()
    }

    #[test]
    fn radians_are_doubted_and_degrees_are_not() {
        let wide = ([-90.0, 90.0], 0.1);
        for range in [[-1.05, 1.05], [-1.2217, 1.2217], [0.0, 0.5], [-2.9671, 2.9671], [0.1, 6.1]] {
            let told = told(&rig(&[wide, (range, 0.1)]));
            assert!(told.len() == 1 && told[0].starts_with("joint j1: "), "{range:?}: {told:?}");
            assert!(told[0].contains("radians"));
        }
        let message = &told(&rig(&[wide, ([-1.05, 1.05], 0.1)]))[0];
        assert_eq!(
            message,
            "joint j1: range_deg = [-1.05, 1.05] looks like radians, which would be [-60, 60] deg"
        );
        // Whole numbers are radians only if no range of the rig is wider.
        assert_eq!(told(&rig(&[([-2.0, 2.0], 0.1), ([-1.0, 1.0], 0.1)])).len(), 2);
        for range in [[-2.0, 2.0], [-10.0, 5.0], [0.0, 0.0], [-5.729_577_951_3, 5.729_577_951_3]] {
            assert_eq!(told(&rig(&[wide, (range, 0.1)])), [""; 0], "{range:?}");
        }
        let mut rig = rig(&[wide]);
        let range_rad = vec![[-1.22, 1.22].map(f64::to_radians)];
        rig.servos.push(Servo { name: "s".to_owned(), range_rad, ..Servo::default() });
        assert!(
            told(&rig)[0].starts_with("servo s: range_deg = [-1.22, 1.22]"),
            "{:?}",
            told(&rig)
        );
    }

    #[test]
    fn a_place_far_away_is_doubted_by_name() {
        let range = [-90.0, 90.0];
        let lengths =
            |metres: &[f64]| rig(&metres.iter().map(|metres| (range, *metres)).collect::<Vec<_>>());
        let far = told(&lengths(&[0.1, 0.2, 50.0]));
        assert_eq!(
            far,
            [
                "joint j2, which moves body b2: its position_m is 50.0 m long, all other lengths of the rig together \
                 0.300 m: a number in mm? (0.0500 m)"
            ]
        );
        assert_eq!(told(&lengths(&[0.1, 4.0])).len(), 1);
        // All in mm.
        assert_eq!(told(&lengths(&[120.0, 95.0, 60.0])).len(), 3);
        // A long mast, a crane, an arm on a rail.
        for metres in [&[0.1, 0.9][..], &[3.0, 4.0, 5.0], &[0.0, 2.0], &[0.2, 1.9]] {
            assert_eq!(told(&lengths(metres)), [""; 0], "{metres:?}");
        }
        let mut rig = lengths(&[0.1, 0.2]);
        rig.mount.position_m = [0.0, 50.0, 0.0];
        rig.bodies[1].center_of_mass_m = [8.0, 0.0, 0.0];
        let told = told(&rig);
        assert!(told[0].starts_with("body b0: its center_of_mass_m is 8.0 m"), "{told:?}");
        assert!(told[1].starts_with("mount: its position_m is 50.0 m"), "{told:?}");
    }
}
