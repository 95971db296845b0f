//! Reads the motion (AMC).

use glam::DQuat;

use super::Problem;
use super::asf::{Asf, Bone};
use super::channel::{Channel, composed};
use super::lines::{Failure, Line, Lines, Word};
use crate::recording::{self, FRAME_TIME_S, Frames};
use crate::skeleton::JointSample;
use crate::text::{counted, shown};

/// Maximum number of frames that the numbering may skip, in addition to the number of frames present. It exceeds
/// any gap that can be filled, and is small enough that a small file cannot request much memory.
const MISSING_FRAMES_MAX: u64 = 10_000;

/// The frames, and the frame time if the file contains it.
pub(super) struct Amc {
    pub(super) frames: Frames,
    pub(super) frame_time_s: Option<f64>,
}

/// Reads the motion. `sample_count_max` is the maximum of joints times frames.
pub(super) fn parse(text: &str, skeleton: &Asf, sample_count_max: usize) -> Result<Amc, Failure> {
    let mut parser = Parser {
        lines: Lines::new(text),
        skeleton,
        sample_count_max,
        degrees: skeleton.degrees,
        frame_time_s: None,
        frames: Vec::new(),
        may_be_missing: MISSING_FRAMES_MAX,
    };
    parser.file()?;
    Ok(Amc { frames: parser.frames, frame_time_s: parser.frame_time_s })
}

struct Parser<'a> {
    lines: Lines<'a>,
    skeleton: &'a Asf,
    sample_count_max: usize,
    degrees: bool,
    frame_time_s: Option<f64>,
    frames: Frames,
    /// Number of frames that the numbering may still skip.
    may_be_missing: u64,
}

impl Parser<'_> {
    fn file(&mut self) -> Result<(), Failure> {
        let mut number = None;
        // Index of the bone that is expected next, because files keep one order.
        let mut next_bone = 0;
        while let Some(line) = self.lines.next() {
            let key = line.key();
            if key.text.starts_with(':') && number.is_none() {
                self.header(&line)?;
            } else if let Ok(found) = key.text.parse::<u64>() {
                line.ends(1)?;
                self.frame(key, number, found)?;
                number = Some(found);
            } else if let Some(number) = number {
                next_bone = self.bone(&line, number, next_bone)?;
            } else {
                return Err(key.not("the number of the first frame"));
            }
        }
        if number.is_none() {
            let end = Word { text: "", at: self.lines.end() };
            return Err(end.not("the number of the first frame"));
        }
        Ok(())
    }

    fn header(&mut self, line: &Line<'_>) -> Result<(), Failure> {
        let key = line.key();
        match key.text.to_ascii_lowercase().as_str() {
            ":degrees" => self.degrees = true,
            ":radians" => self.degrees = false,
            ":samples-per-second" => {
                let rate = line.word(1);
                let frame_time_s = rate.finite()?.recip();
                if !FRAME_TIME_S.contains(&frame_time_s) {
                    return Err(rate.not("a rate from 1 to 100000 frames per second"));
                }
                self.frame_time_s = Some(recording::snapped_s(frame_time_s));
            }
            // Every frame is read as it is, and the skeleton file is found by its name.
            ":fully-specified" | ":frame-range" | ":asf-file" | ":asf-path" => {}
            _ => {
                return Err(key.not(
                    "`:FULLY-SPECIFIED`, `:DEGREES`, `:RADIANS`, `:SAMPLES-PER-SECOND` or the number \
                     of the first frame",
                ));
            }
        }
        Ok(())
    }

    /// Begins frame `found` after frame `last`, and adds the missing frames between them.
    fn frame(&mut self, key: Word<'_>, last: Option<u64>, found: u64) -> Result<(), Failure> {
        let mut new = 1;
        if let Some(last) = last {
            let (least, most) =
                (last.saturating_add(1), last.saturating_add(1 + self.may_be_missing));
            if !(least..=most).contains(&found) || found == last {
                return Err((key.at, Problem::FrameNumber { last, least, most, found }));
            }
            new = found - last;
            // `new - 1` frames are missing, and this one is present.
            self.may_be_missing = self.may_be_missing + 2 - new;
        }
        let joints = self.skeleton.bones.len();
        for missing in (0..new).rev() {
            if (self.frames.len() + 1) * joints > self.sample_count_max {
                let limit = self.sample_count_max / joints;
                return Err((key.at, Problem::TooMany { items: "frames", limit }));
            }
            let empty = |bone: &Bone| {
                // A bone that cannot rotate needs no values.
                (missing == 0 && bone.channels.is_empty()).then(|| JointSample {
                    rotation: DQuat::IDENTITY,
                    position_m: self.skeleton.offset(bone),
                })
            };
            self.frames.push(self.skeleton.bones.iter().map(empty).collect());
        }
        Ok(())
    }

    /// Reads the values of one bone in the last frame. Returns the index of the bone that is expected next.
    fn bone(&mut self, line: &Line<'_>, frame: u64, expected: usize) -> Result<usize, Failure> {
        let key = line.key();
        let bones = &self.skeleton.bones;
        let is_key = |bone: &Bone| bone.name == key.text;
        let index = match bones.get(expected) {
            Some(bone) if is_key(bone) => expected,
            _ => bones.iter().position(is_key).ok_or_else(|| {
                key.not(format!(
                    "a bone of the ASF file or the number of frame {}",
                    frame.saturating_add(1)
                ))
            })?,
        };
        let bone = &bones[index];
        let values = line.words.len() - 1;
        if values != bone.channels.len() {
            let problem = Problem::Values {
                frame,
                bone: shown(&bone.name),
                expected: format!(
                    "{} ({})",
                    counted(bone.channels.len(), "value"),
                    names(&bone.channels)
                ),
                found: values,
            };
            return Err((line.word(1 + bone.channels.len().min(values)).at, problem));
        }
        let mut position_m = self.skeleton.offset(bone);
        let mut turns = Vec::with_capacity(3);
        for (word, channel) in line.words[1..].iter().zip(&bone.channels) {
            let value = word.finite()?;
            match *channel {
                Channel::Position(axis) => position_m[axis] = value,
                Channel::Rotation(axis) => {
                    turns.push((axis, if self.degrees { value.to_radians() } else { value }));
                }
            }
        }
        let rotation = (bone.axes * composed(turns) * bone.axes.inverse()).normalize();
        let sample = self.frames.last_mut().and_then(|frame| frame.get_mut(index));
        if let Some(sample) = sample {
            if sample.is_some() && !bone.channels.is_empty() {
                return Err(key.not(format!("each bone once in frame {frame}")));
            }
            *sample = Some(JointSample { rotation, position_m });
        }
        Ok(index + 1)
    }
}

fn names(channels: &[Channel]) -> String {
    let name = |channel: &Channel| match *channel {
        Channel::Position(axis) => ["tx", "ty", "tz"][axis],
        Channel::Rotation(axis) => ["rx", "ry", "rz"][axis],
    };
    channels.iter().map(name).collect::<Vec<_>>().join(" ")
}
