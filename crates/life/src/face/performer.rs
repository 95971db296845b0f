//! Joint positions from weights of shapes.

use std::fmt::Write as _;

use sinew_rig::Mechanism;
use sinew_rig::description::FaceShape;

use super::RATE_HZ;
use super::error::FaceError;
use super::names::{VISEMES, is_same};
use super::nnls::nnls;
use super::poses::{MovedJoint, Poses};
use super::track::Weights;
use crate::limit::within;

/// Smallest remaining share of a motion; with less, the joint counts as too slow.
const LEAST: f64 = 0.05;
/// Weights below this count as zero.
const NONE: f64 = 1e-6;

/// Measures of the motion of one joint.
#[derive(Debug, Clone, PartialEq)]
pub struct JointMeasure {
    /// Name of the joint.
    pub name: String,
    /// Whether the joint slides; its numbers are then in m.
    pub slides: bool,
    /// Difference between the largest and the smallest position, rad or m.
    pub way: f64,
    /// Largest speed as a share of the limit; 0 without a limit.
    pub speed_share: f64,
    /// Width of the smoothing, s.
    pub smoothed_s: f64,
    /// Share of the motion that is left after limiting.
    pub share: f64,
    /// Correlation of this motion with the motion in the file; 1 if one of both is constant.
    pub correlation: f64,
    /// Mean absolute jerk, rad/s³ or m/s³.
    pub jerk: f64,
}

/// Motion of the joints of a face.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceMotion {
    /// Time of the first row, s.
    pub start_s: f64,
    /// Positions of the moved joints at [`RATE_HZ`], rad or m.
    pub rows: Vec<Vec<f64>>,
    /// Each joint that a shape of the file moves.
    pub joints: Vec<JointMeasure>,
    /// Shapes of the file that move joints.
    pub used: Vec<String>,
    /// Shapes of the file that occur, but have no pose in the rig.
    pub not_shown: Vec<String>,
    /// Share of the rows in which the shapes together would exceed a range, so that their weights were fitted.
    pub fitted: f64,
}

/// Computes the motion of a rig's joints from weights of shapes.
///
/// A joint's offset from home is the weighted sum of the shapes' offsets. All visemes are shares of one mouth: if the
/// sum of their weights exceeds 1, they are divided by it. If a joint would exceed its range, the weights are fitted by
/// non-negative least squares: the shapes then make the nearest pose within the ranges, and each shape keeps its form.
///
/// # Errors
/// [`FaceError`] if no shape moves a joint, or a joint is too slow to keep a visible motion.
pub fn perform(
    mechanism: &Mechanism,
    shapes: &[FaceShape],
    weights: &Weights,
) -> Result<FaceMotion, FaceError> {
    if shapes.is_empty() {
        let example = weights.names.first().cloned().unwrap_or_default();
        return Err(FaceError::NoShapes { example });
    }
    let poses = Poses::of(mechanism, shapes);
    let found: Vec<Option<usize>> = weights.names.iter().map(|name| poses.find(name)).collect();
    let is_active = |column: usize| weights.rows.iter().any(|row| row[column].abs() > 0.01);
    let names = |has_pose: bool| -> Vec<String> {
        (0..found.len())
            .filter(|column| found[*column].is_some() == has_pose && is_active(*column))
            .map(|column| weights.names[column].clone())
            .collect()
    };
    if found.iter().all(Option::is_none) {
        let list = |names: Vec<&str>| match names.len() {
            0 => "none".to_owned(),
            count => {
                let more = if count > 12 { format!(", .. ({count})") } else { String::new() };
                format!("{}{more}", names[..count.min(12)].join(", "))
            }
        };
        return Err(FaceError::NothingMoves {
            file: list(weights.names.iter().map(String::as_str).collect()),
            rig: list(poses.shapes.iter().map(|(name, _)| name.as_str()).collect()),
        });
    }
    let is_viseme: Vec<bool> = weights
        .names
        .iter()
        .map(|name| VISEMES.iter().any(|viseme| is_same(name, viseme)))
        .collect();
    let (start_s, end_s) = (weights.times_s[0], weights.times_s[weights.times_s.len() - 1]);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below 7200 s")]
    let last = ((end_s - start_s) * RATE_HZ).ceil().max(1.0) as usize;
    let mut fitted = 0_usize;
    let rows: Vec<Vec<f64>> = (0..=last)
        .map(|row| {
            let mut given = weights.at(start_s + row as f64 / RATE_HZ);
            share_mouth(&mut given, &is_viseme);
            let (offsets, is_fitted) = offsets(&poses, &found, &given);
            fitted += usize::from(is_fitted);
            offsets
        })
        .collect();
    let mut limited = Vec::new();
    let (mut measures, mut places) = (Vec::new(), Vec::new());
    for (index, joint) in poses.joints.iter().enumerate() {
        let meant: Vec<f64> = rows.iter().map(|row| row[index]).collect();
        let kept = within(&meant, RATE_HZ, 1, [joint.speed, joint.acceleration]);
        if kept.share < LEAST {
            let percent = 100.0 * kept.share;
            return Err(FaceError::TooSlow { joint: joint.name.clone(), percent });
        }
        let speed_share = if joint.speed.is_finite() { kept.fastest / joint.speed } else { 0.0 };
        let measure = JointMeasure {
            name: joint.name.clone(),
            slides: joint.slides,
            way: way(&kept.values),
            speed_share,
            smoothed_s: kept.smoothed_s,
            share: kept.share,
            correlation: correlation(&meant, &kept.values),
            jerk: jerk(&kept.values),
        };
        // Joints that only other shapes move are left out, so that another motion, such as idle life, can move them.
        let moves = |shape: &usize| poses.shapes[*shape].1[index].abs() > 0.0;
        if found.iter().flatten().any(moves) {
            measures.push(measure);
            places.push(index);
        }
        limited.push(kept.values);
    }
    let row = |row: usize| {
        let mut offsets: Vec<f64> = limited.iter().map(|values| values[row]).collect();
        poses.hold(&mut offsets);
        places.iter().map(|place| poses.joints[*place].home + offsets[*place]).collect()
    };
    Ok(FaceMotion {
        start_s,
        rows: (0..rows.len()).map(row).collect(),
        joints: measures,
        used: names(true),
        not_shown: names(false),
        fitted: fitted as f64 / rows.len() as f64,
    })
}

/// Divides the weights of visemes by their sum, if it is above 1.
fn share_mouth(weights: &mut [f64], is_viseme: &[bool]) {
    let of_mouth = weights.iter().zip(is_viseme).filter(|(_, is)| **is);
    let sum: f64 = of_mouth.map(|(weight, _)| *weight).sum();
    if sum > 1.0 {
        let of_mouth = weights.iter_mut().zip(is_viseme).filter(|(_, is)| **is);
        of_mouth.for_each(|(weight, _)| *weight /= sum);
    }
}

/// Returns the offsets of all joints from home, and whether the weights were fitted.
fn offsets(poses: &Poses, found: &[Option<usize>], weights: &[f64]) -> (Vec<f64>, bool) {
    let active: Vec<(usize, f64)> = found
        .iter()
        .zip(weights)
        .filter_map(|(shape, weight)| Some(((*shape)?, *weight)))
        .filter(|(_, weight)| *weight > NONE)
        .collect();
    let sum = |weights: &[f64]| {
        let mut sum = vec![0.0; poses.joints.len()];
        for ((shape, _), weight) in active.iter().zip(weights) {
            for (sum, offset) in sum.iter_mut().zip(&poses.shapes[*shape].1) {
                *sum += weight * offset;
            }
        }
        sum
    };
    let given: Vec<f64> = active.iter().map(|(_, weight)| *weight).collect();
    let mut target = sum(&given);
    if !poses.hold(&mut target) {
        return (target, false);
    }
    // Offsets are compared as shares of each joint's largest offset.
    let scaled = |offsets: &[f64]| -> Vec<f64> {
        let scale = |joint: &MovedJoint| if joint.scale > 0.0 { joint.scale } else { 1.0 };
        offsets.iter().zip(&poses.joints).map(|(offset, joint)| offset / scale(joint)).collect()
    };
    let columns: Vec<Vec<f64>> =
        active.iter().map(|(shape, _)| scaled(&poses.shapes[*shape].1)).collect();
    let mut offsets = sum(&nnls(&columns, &scaled(&target), &given));
    poses.hold(&mut offsets);
    (offsets, true)
}

fn way(values: &[f64]) -> f64 {
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most - values.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Returns the Pearson correlation of two series; 1 if a series is constant.
fn correlation(one: &[f64], other: &[f64]) -> f64 {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (mean_one, mean_other) = (mean(one), mean(other));
    let [mut both, mut squares, mut others] = [0.0; 3];
    for (a, b) in one.iter().zip(other) {
        let (a, b) = (a - mean_one, b - mean_other);
        both += a * b;
        squares += a * a;
        others += b * b;
    }
    if squares > 1e-18 && others > 1e-18 { both / (squares * others).sqrt() } else { 1.0 }
}

/// Returns the mean absolute third derivative of a series.
fn jerk(values: &[f64]) -> f64 {
    let jerks = values.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs());
    let count = values.len().saturating_sub(3).max(1) as f64;
    jerks.sum::<f64>() * RATE_HZ * RATE_HZ * RATE_HZ / count
}

impl FaceMotion {
    /// Returns the motion as keys for `sinew bake`: a row every 10 ms, and a column for each joint.
    pub fn csv(&self) -> String {
        let mut text = String::from("time");
        for joint in &self.joints {
            let header = format!("{}_{}", joint.name, if joint.slides { "mm" } else { "deg" });
            let is_plain = !header.contains([',', '"', '\n', '\r']);
            let header =
                if is_plain { header } else { format!("\"{}\"", header.replace('"', "\"\"")) };
            text.push(',');
            text.push_str(&header);
        }
        text.push('\n');
        for (row, positions) in self.rows.iter().enumerate() {
            let time_s = self.start_s + row as f64 / RATE_HZ;
            write!(text, "{time_s:.3}").expect("a string takes everything");
            for (position, joint) in positions.iter().zip(&self.joints) {
                let number = if joint.slides { 1000.0 * position } else { position.to_degrees() };
                write!(text, ",{:.4}", number + 0.0).expect("a string takes everything");
            }
            text.push('\n');
        }
        text
    }
}
