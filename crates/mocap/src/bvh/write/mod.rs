//! Writes motions as BVH files, for animation programs.
//!
//! The files satisfy the assumptions of common readers: parents precede children, depth first; the root's channels are
//! its position, then its rotations Z, Y, X; all other joints have the rotations Z, Y, X, and before them a position if
//! it differs from the joint's offset; every joint without children has an `End Site`; each frame is one line.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use glam::{DMat3, DQuat, DVec3};

use crate::recording::{FRAME_TIME_S, MAGNITUDE_MAX};
use crate::text::shown;
use crate::{Clip, JointSample, Skeleton};

/// Minimum distance from a joint's offset, m, for the joint to get position channels. Rounding of an offset to
/// single precision is not a motion.
const MOVES_M: f64 = 1e-6;

/// Cosine of the middle angle, below which a rotation is in gimbal lock: it does not define the last angle, which
/// keeps its value.
const LOCKED: f64 = 1e-7;

/// The reason why a motion cannot be written as BVH.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The file system reported an error.
    #[error("{}: cannot be written: {source}", file.display())]
    Io {
        /// Path of the file.
        file: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A name that a reader would not return unchanged.
    #[error(
        "joint {joint}: expected a name in one line, without braces or blanks around it, found `{}`",
        shown(name)
    )]
    Name {
        /// Index of the joint.
        joint: usize,
        /// Name of the joint.
        name: String,
    },
    /// Two joints have the same name.
    #[error("joint {joint}: expected a new name, found `{}` again", shown(name))]
    SameName {
        /// Index of the second joint.
        joint: usize,
        /// Name of both joints.
        name: String,
    },
    /// The skeleton is not a tree in regular numbering, or a frame does not have one sample for each joint.
    #[error("{what}: expected {expected}, found {found}")]
    Shape {
        /// Description of the invalid part.
        what: String,
        /// Description of a valid value.
        expected: &'static str,
        /// Value that was found.
        found: String,
    },
    /// A number cannot be written.
    #[error("{what}: expected {expected}, found {value}")]
    Value {
        /// Name of the number, or its frame and joint.
        what: String,
        /// Description of the accepted values.
        expected: &'static str,
        /// Value that was found; for a quaternion the square of its length.
        value: f64,
    },
}

/// Writes a motion to a file, with lengths in units of `metres_per_unit`.
///
/// # Errors
/// Those of [`text`], and [`WriteError::Io`].
pub fn write(path: &Path, clip: &Clip, metres_per_unit: f64) -> Result<(), WriteError> {
    let text = text(clip, metres_per_unit)?;
    std::fs::write(path, text).map_err(|source| WriteError::Io { file: path.to_path_buf(), source })
}

/// Returns a motion as the text of a BVH file, with lengths in units of `metres_per_unit` (0.01 for centimetres).
///
/// The angles of a joint are those nearest to its angles in the previous frame: they continue beyond 180 deg and
/// through gimbal lock. After reading the text, rotations are equal within 2e-7 rad, and positions within 1e-7 m if the
/// unit is at most 100 m. A joint that is never more than 1e-6 m away from its offset is written at its offset. A joint
/// without children and end sites gets an end site at its origin, because many readers require one.
///
/// # Errors
/// [`WriteError`] for numbers that are not finite, names that cannot be read again, and an invalid skeleton or
/// frame.
pub fn text(clip: &Clip, metres_per_unit: f64) -> Result<String, WriteError> {
    check(clip, metres_per_unit)?;
    let writer = Writer::new(clip, metres_per_unit);
    let mut text = String::from("HIERARCHY\n");
    writer.joint(&mut text, 0, 0);
    let frame_time_s = clip.frame_time_s;
    writeln!(text, "MOTION\nFrames: {}\nFrame Time: {frame_time_s:.10}", clip.frames.len())
        .expect(TAKES_ALL);
    let mut angles = vec![DVec3::ZERO; clip.skeleton.joints.len()];
    for frame in &clip.frames {
        writer.frame(&mut text, frame, &mut angles);
    }
    Ok(text)
}

const TAKES_ALL: &str = "a string takes everything";

fn check(clip: &Clip, metres_per_unit: f64) -> Result<(), WriteError> {
    let value =
        |what: &str, expected, value| WriteError::Value { what: what.into(), expected, value };
    // The comparison also refuses NaN.
    if !(1e-6..=1e3).contains(&metres_per_unit) {
        return Err(value("metres per unit", "a number from 0.000001 to 1000", metres_per_unit));
    }
    if !FRAME_TIME_S.contains(&clip.frame_time_s) {
        return Err(value("frame time", "0.00001 to 1 second", clip.frame_time_s));
    }
    check_skeleton(&clip.skeleton, metres_per_unit)?;
    let count = clip.skeleton.joints.len();
    if clip.frames.is_empty() {
        let (expected, found) = ("at least one frame", "none".into());
        return Err(WriteError::Shape { what: "the motion".into(), expected, found });
    }
    for (index, frame) in clip.frames.iter().enumerate() {
        if frame.len() != count {
            let (what, found) = (format!("frame {index}"), format!("{} samples", frame.len()));
            return Err(WriteError::Shape { what, expected: "one sample for each joint", found });
        }
        for (joint, sample) in clip.skeleton.joints.iter().zip(frame) {
            let what = || format!("frame {index}, joint `{}`", shown(&joint.name));
            let squared = sample.rotation.length_squared();
            if !(1.0 - 1e-6..=1.0 + 1e-6).contains(&squared) {
                let expected = "a rotation by a unit quaternion";
                return Err(WriteError::Value { what: what(), expected, value: squared });
            }
            check_place(what, sample.position_m, metres_per_unit)?;
        }
    }
    Ok(())
}

fn check_skeleton(skeleton: &Skeleton, metres_per_unit: f64) -> Result<(), WriteError> {
    for (index, joint) in skeleton.joints.iter().enumerate() {
        let name = &joint.name;
        let is_bad = |c: char| c.is_control() || matches!(c, '{' | '}');
        if name.is_empty() || name.trim() != name || name.contains(is_bad) {
            return Err(WriteError::Name { joint: index, name: name.clone() });
        }
        if skeleton.find(name) != Some(index) {
            return Err(WriteError::SameName { joint: index, name: name.clone() });
        }
        if joint.parent.map_or(index > 0, |parent| parent >= index) {
            let what = format!("joint `{}`", shown(name));
            let expected = "a parent that comes before it, and only one root";
            let found = format!("{:?}", joint.parent);
            return Err(WriteError::Shape { what, expected, found });
        }
        for place in joint.end_sites_m.iter().chain([&joint.offset_m]) {
            check_place(|| format!("joint `{}`", shown(name)), *place, metres_per_unit)?;
        }
    }
    if skeleton.joints.is_empty() {
        let (expected, found) = ("at least one joint", "none".into());
        return Err(WriteError::Shape { what: "the skeleton".into(), expected, found });
    }
    Ok(())
}

fn check_place(
    what: impl Fn() -> String,
    place_m: DVec3,
    metres_per_unit: f64,
) -> Result<(), WriteError> {
    let is_far = |m: &f64| {
        let units = (m / metres_per_unit).abs();
        units.is_nan() || units > MAGNITUDE_MAX
    };
    let far = place_m.to_array().into_iter().find(is_far);
    let expected = "a finite position, at most 1e9 units away";
    far.map_or(Ok(()), |value| Err(WriteError::Value { what: what(), expected, value }))
}

struct Writer<'a> {
    clip: &'a Clip,
    metres_per_unit: f64,
    /// Children of every joint, in order.
    children: Vec<Vec<usize>>,
    /// Whether each joint has position channels.
    slides: Vec<bool>,
    /// Joints in the order of the file.
    order: Vec<usize>,
}

impl<'a> Writer<'a> {
    fn new(clip: &'a Clip, metres_per_unit: f64) -> Self {
        let joints = &clip.skeleton.joints;
        let mut children = vec![Vec::new(); joints.len()];
        for (index, joint) in joints.iter().enumerate() {
            if let Some(parent) = joint.parent {
                children[parent].push(index);
            }
        }
        let leaves = |index: usize| {
            let offset_m = joints[index].offset_m;
            clip.frames.iter().any(|frame| (frame[index].position_m - offset_m).length() > MOVES_M)
        };
        let slides = (0..joints.len()).map(|index| index == 0 || leaves(index)).collect();
        let (mut order, mut open) = (Vec::with_capacity(joints.len()), vec![0]);
        while let Some(index) = open.pop() {
            order.push(index);
            open.extend(children[index].iter().rev());
        }
        Self { clip, metres_per_unit, children, slides, order }
    }

    /// Writes a joint with all its descendants.
    fn joint(&self, text: &mut String, index: usize, depth: usize) {
        let joint = &self.clip.skeleton.joints[index];
        let (indent, inner) = ("  ".repeat(depth), "  ".repeat(depth + 1));
        let kind = if index == 0 { "ROOT" } else { "JOINT" };
        let positions = if self.slides[index] { "6 Xposition Yposition Zposition" } else { "3" };
        write!(
            text,
            "{indent}{kind} {name}\n{indent}{{\n{inner}OFFSET {offset}\n\
             {inner}CHANNELS {positions} Zrotation Yrotation Xrotation\n",
            name = joint.name,
            offset = self.place(joint.offset_m),
        )
        .expect(TAKES_ALL);
        for child in &self.children[index] {
            self.joint(text, *child, depth + 1);
        }
        let is_bare = self.children[index].is_empty() && joint.end_sites_m.is_empty();
        for end_m in joint.end_sites_m.iter().chain(is_bare.then_some(&DVec3::ZERO)) {
            let end = self.place(*end_m);
            write!(text, "{inner}End Site\n{inner}{{\n{inner}  OFFSET {end}\n{inner}}}\n")
                .expect(TAKES_ALL);
        }
        writeln!(text, "{indent}}}").expect(TAKES_ALL);
    }

    /// Writes the line of a frame. `angles` contains the angles of each joint in the previous frame, and is updated.
    fn frame(&self, text: &mut String, frame: &[JointSample], angles: &mut [DVec3]) {
        for (place, &index) in self.order.iter().enumerate() {
            let blank = if place == 0 { "" } else { " " };
            let JointSample { rotation, position_m } = frame[index];
            angles[index] = zyx_rad(rotation, angles[index]);
            let [z, y, x] = angles[index].to_array().map(|angle| number(angle.to_degrees(), 6));
            text.push_str(blank);
            if self.slides[index] {
                write!(text, "{} ", self.place(position_m)).expect(TAKES_ALL);
            }
            write!(text, "{z} {y} {x}").expect(TAKES_ALL);
        }
        text.push('\n');
    }

    fn place(&self, place_m: DVec3) -> String {
        let [x, y, z] = (place_m / self.metres_per_unit).to_array().map(|length| {
            // Decimals to 1e-7 m or finer, for units of up to 100 m.
            number(length, if self.metres_per_unit < 0.1 { 6 } else { 9 })
        });
        format!("{x} {y} {z}")
    }
}

/// Formats a number, without a negative zero.
fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let is_zero = text.bytes().all(|byte| matches!(byte, b'-' | b'0' | b'.'));
    if is_zero { text.trim_start_matches('-').to_owned() } else { text }
}

/// Returns the angles z, y, x with `rotation = Rz Ry Rx` that are nearest to the angles `near`.
fn zyx_rad(rotation: DQuat, near: DVec3) -> DVec3 {
    use std::f64::consts::PI;
    let matrix = DMat3::from_quat(rotation.normalize());
    let (across, along) = (matrix.y_axis.z, matrix.z_axis.z);
    let x = if libm::hypot(across, along) > LOCKED { libm::atan2(across, along) } else { near.z };
    // Without the last rotation, the other angles follow from large numbers, even close to gimbal lock.
    let rest = matrix * DMat3::from_rotation_x(-x);
    let z = libm::atan2(-rest.y_axis.x, rest.y_axis.y);
    let y = libm::atan2(-rest.x_axis.z, rest.z_axis.z);
    let next_to = |angles: DVec3| {
        let turns = ((near - angles) / (2.0 * PI)).round();
        angles + turns * (2.0 * PI)
    };
    let (one, other) = (next_to(DVec3::new(z, y, x)), next_to(DVec3::new(z + PI, PI - y, x + PI)));
    if one.distance_squared(near) <= other.distance_squared(near) { one } else { other }
}

#[cfg(test)]
mod tests;
