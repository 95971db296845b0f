//! Reads and writes Biovision Hierarchy (BVH) files, including common deviations from the format.
//!
//! A file contains one skeleton (`HIERARCHY`) and the channel values of every frame (`MOTION`). Rotations of a
//! joint are composed in the order of its channels, `R = R_first R_second R_third`; a position channel replaces
//! that component of the joint's `OFFSET`. White space and line ends are free. The format has no unit of length:
//! see [`Recording::in_metres`].

mod error;
mod token;
mod write;

use std::path::Path;

use glam::{DQuat, DVec3};

pub use error::{Error, Problem};
use token::{Token, Tokens};
pub use write::{WriteError, text, write};

use super::recording::{self, FRAME_TIME_S, Frames, JOINT_COUNT_MAX, MAGNITUDE_MAX, Recording};
use super::text::{Position, found, shown};
use crate::skeleton::{JointSample, Skeleton, SkeletonJoint};
use crate::{encoding, placed};

/// Reads the file at `path`. The clip's name is the stem of the file.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read, [`Error::Syntax`] with line and column if it is not a
/// complete BVH motion of finite numbers.
pub fn read(path: &Path) -> Result<Recording, Error> {
    let bytes = crate::read::bytes(path)
        .map_err(|source| Error::Io { file: path.to_path_buf(), source })?;
    parse(&bytes, path)
}

/// Reads the text of a BVH file. `path` is used in errors, and its stem is the name of the clip.
///
/// Bytes that are not valid characters can only matter in joint names, and are replaced there.
///
/// # Errors
/// [`Error::Syntax`], for the same reasons as in [`read`].
pub fn parse(bytes: &[u8], path: &Path) -> Result<Recording, Error> {
    let text = encoding::lossy(bytes);
    let mut parser = Parser {
        tokens: Tokens::new(&text),
        sample_count_max: recording::sample_count_max(bytes.len()),
    };
    parser.file().map_or_else(
        |(at, problem)| Err(Error::Syntax { file: path.to_path_buf(), at, problem }),
        |(skeleton, frame_time_s, frames, notes)| {
            Ok(Recording {
                name: recording::stem(path),
                skeleton,
                frames,
                frame_time_s: Some(frame_time_s),
                metres_per_unit: None,
                notes,
            })
        },
    )
}

/// A channel: the coordinate of a joint that a value of a frame sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Channel {
    Position(usize),
    Rotation(usize),
}

impl Channel {
    fn from_word(word: &str) -> Option<Self> {
        let word = word.to_ascii_lowercase();
        let axis = "xyz".find(word.chars().next()?)?;
        match &word[1..] {
            "position" => Some(Self::Position(axis)),
            "rotation" => Some(Self::Rotation(axis)),
            _ => None,
        }
    }
}

/// The skeleton, and each joint's channels.
struct Hierarchy {
    skeleton: Skeleton,
    channels: Vec<Vec<Channel>>,
    lines: Vec<usize>,
}

type Failure = (Position, Problem);

struct Parser<'a> {
    tokens: Tokens<'a>,
    /// Maximum of joints times frames for this file.
    sample_count_max: usize,
}

impl<'a> Parser<'a> {
    fn file(&mut self) -> Result<(Skeleton, f64, Frames, Vec<String>), Failure> {
        self.keyword("HIERARCHY")?;
        self.keyword("ROOT")?;
        let hierarchy = self.hierarchy()?;
        let after = self.tokens.next();
        if after.is("ROOT") {
            return Err((after.at, Problem::SecondRoot));
        }
        expect(after, "MOTION")?;
        self.keyword("Frames")?;
        self.keyword(":")?;
        let frame_count = self.count(usize::MAX, "a whole number of frames")?;
        self.keyword("Frame")?;
        self.keyword("Time")?;
        self.keyword(":")?;
        let frame_time_s = self.frame_time_s()?;
        let (mut frames, mut notes) = self.frames(&hierarchy, frame_count)?;
        notes.extend(hierarchy.add_offsets(&mut frames));
        let mut skeleton = hierarchy.skeleton;
        notes.extend(placed::turn(&mut skeleton, &mut frames));
        Ok((skeleton, frame_time_s, frames, notes))
    }

    /// Reads all joints, from the root's name to its closing brace.
    fn hierarchy(&mut self) -> Result<Hierarchy, Failure> {
        let mut hierarchy = Hierarchy {
            skeleton: Skeleton { joints: Vec::new() },
            channels: Vec::new(),
            lines: Vec::new(),
        };
        // Joints whose brace is open, the outermost first.
        let mut open = Vec::new();
        self.joint(&mut hierarchy, &mut open)?;
        while let Some(&current) = open.last() {
            let token = self.tokens.next();
            if token.is("JOINT") {
                self.joint(&mut hierarchy, &mut open)?;
            } else if token.is("End") {
                self.keyword("Site")?;
                // Some writers name the end site; the name is not needed.
                self.tokens.rest_of_line();
                self.keyword("{")?;
                let end = self.offset()?;
                self.keyword("}")?;
                hierarchy.skeleton.joints[current].end_sites_m.push(end);
            } else if token.is("}") {
                open.pop();
            } else {
                let name = &hierarchy.skeleton.joints[current].name;
                let expected = format!("`JOINT`, `End Site` or the `}}` of joint `{name}`");
                return Err(unexpected(token, expected));
            }
        }
        Ok(hierarchy)
    }

    /// Reads one joint from its name to its channels, and adds it to the open joints.
    fn joint(&mut self, hierarchy: &mut Hierarchy, open: &mut Vec<usize>) -> Result<(), Failure> {
        let Hierarchy { skeleton, channels, lines } = hierarchy;
        let name = self.tokens.rest_of_line();
        if name.is_end() {
            return Err(unexpected(self.tokens.next(), "the joint's name on the same line"));
        }
        if let Some(first) = skeleton.find(name.text) {
            let problem =
                Problem::DuplicateJoint { name: shown(name.text), first_line: lines[first] };
            return Err((name.at, problem));
        }
        let index = skeleton.joints.len();
        if index == JOINT_COUNT_MAX {
            let problem = Problem::TooMany { items: "joints", limit: JOINT_COUNT_MAX };
            return Err((name.at, problem));
        }
        self.keyword("{")?;
        let offset = self.offset()?;
        self.keyword("CHANNELS")?;
        channels.push(self.channels(name.text)?);
        lines.push(name.at.line);
        skeleton.joints.push(SkeletonJoint {
            name: name.text.to_owned(),
            parent: open.last().copied(),
            offset_m: offset,
            end_sites_m: Vec::new(),
        });
        open.push(index);
        Ok(())
    }

    fn offset(&mut self) -> Result<DVec3, Failure> {
        self.keyword("OFFSET")?;
        Ok(DVec3::new(self.number()?, self.number()?, self.number()?))
    }

    fn channels(&mut self, joint: &str) -> Result<Vec<Channel>, Failure> {
        let count = self.count(6, "a number of channels from 0 to 6")?;
        let mut channels = Vec::with_capacity(count);
        for _ in 0..count {
            let token = self.tokens.next();
            let channel = Channel::from_word(token.text)
                .ok_or_else(|| unexpected(token, "a channel (`Xposition` to `Zrotation`)"))?;
            if channels.contains(&channel) {
                let problem =
                    Problem::DuplicateChannel { channel: shown(token.text), joint: shown(joint) };
                return Err((token.at, problem));
            }
            channels.push(channel);
        }
        Ok(channels)
    }

    fn frame_time_s(&mut self) -> Result<f64, Failure> {
        let token = self.tokens.next();
        let time_s: f64 = token.text.parse().unwrap_or(f64::NAN);
        if !FRAME_TIME_S.contains(&time_s) {
            return Err(unexpected(token, "a frame time from 0.00001 to 1 second"));
        }
        Ok(recording::snapped_s(time_s))
    }

    /// Reads the values of all frames, to the end of the file. Some writers count one row too many or too few,
    /// which is noted.
    fn frames(
        &mut self,
        hierarchy: &Hierarchy,
        frame_count: usize,
    ) -> Result<(Frames, Vec<String>), Failure> {
        let joint_count = hierarchy.skeleton.joints.len();
        let channel_count = hierarchy.channels.iter().map(Vec::len).sum();
        let mut token = self.tokens.next();
        if channel_count == 0 {
            return Err((token.at, Problem::NoChannels));
        }
        // Frames are allocated only for values that are present, so that a header cannot request much memory.
        let mut frames = Vec::new();
        let mut values = Vec::with_capacity(channel_count);
        let mut lines = LineLengths::new(channel_count);
        while frames.len() < frame_count && !token.is_end() {
            values.push(finite(token)?);
            lines.add(token.at.line);
            if values.len() == channel_count {
                if (frames.len() + 1) * joint_count > self.sample_count_max {
                    let limit = self.sample_count_max / joint_count;
                    return Err((token.at, Problem::TooMany { items: "frames", limit }));
                }
                frames.push(hierarchy.frame(&values));
                values.clear();
            }
            token = self.tokens.next();
        }
        if frames.len() + 1 == frame_count && !frames.is_empty() && values.is_empty() {
            let note = format!("has {} frames, one fewer than it says", frames.len());
            return Ok((frames, vec![note]));
        }
        if frames.len() < frame_count {
            let problem = Problem::MissingValues {
                frames: frame_count,
                channels: channel_count,
                complete: frames.len(),
                rest: values.len(),
                odd_line: lines.finish(),
            };
            return Err((token.at, problem));
        }
        if token.is_end() {
            return Ok((frames, Vec::new()));
        }
        let at = token.at;
        let (mut extra, mut is_numbers) = (0, true);
        while !token.is_end() {
            extra += 1;
            is_numbers &= finite(token).is_ok();
            lines.add(token.at.line);
            token = self.tokens.next();
        }
        if extra == channel_count && is_numbers && !frames.is_empty() {
            let note = format!("has a frame more than the {frame_count} that it says: left out");
            return Ok((frames, vec![note]));
        }
        let problem = Problem::ExtraValues {
            frames: frame_count,
            channels: channel_count,
            extra,
            odd_line: lines.finish(),
        };
        Err((at, problem))
    }

    fn keyword(&mut self, keyword: &str) -> Result<(), Failure> {
        expect(self.tokens.next(), keyword)
    }

    fn number(&mut self) -> Result<f64, Failure> {
        finite(self.tokens.next())
    }

    fn count(&mut self, max: usize, expected: &str) -> Result<usize, Failure> {
        let token: Token<'a> = self.tokens.next();
        token
            .text
            .parse()
            .ok()
            .filter(|&count| count <= max)
            .ok_or_else(|| unexpected(token, expected))
    }
}

impl Hierarchy {
    /// Returns the pose that the values of one frame describe. No joint is `None`, because a BVH file has no gaps.
    fn frame(&self, values: &[f64]) -> Vec<Option<JointSample>> {
        let mut values = values.iter();
        let joints = self.skeleton.joints.iter().zip(&self.channels);
        joints
            .map(|(joint, channels)| {
                let mut position_m = joint.offset_m;
                let mut rotation = DQuat::IDENTITY;
                for (channel, &value) in channels.iter().zip(&mut values) {
                    match *channel {
                        Channel::Position(axis) => position_m[axis] = value,
                        Channel::Rotation(axis) => {
                            rotation *=
                                DQuat::from_axis_angle(DVec3::AXES[axis], value.to_radians());
                        }
                    }
                }
                Some(JointSample { rotation: rotation.normalize(), position_m })
            })
            .collect()
    }

    /// Adds the joints' offsets to positions that are displacements from these offsets, which some exporters write.
    /// Such positions are near zero although the offsets are not, and no valid file has all joints at one place. The
    /// limit is 5 % of the bones' length. Returns a note for the user if offsets were added.
    fn add_offsets(&self, frames: &mut Frames) -> Option<String> {
        const NEAR: f64 = 0.05;
        let joints = &self.skeleton.joints;
        let is_placed = |joint: &usize| {
            let is_position = |channel: &&Channel| matches!(channel, Channel::Position(_));
            self.channels[*joint].iter().filter(is_position).count() == 3
        };
        let placed: Vec<usize> = (1..joints.len()).filter(is_placed).collect();
        let bones_m: f64 = placed.iter().map(|joint| joints[*joint].offset_m.length()).sum();
        let is_near = |frame: &Vec<Option<JointSample>>| {
            let places = placed.iter().filter_map(|joint| frame[*joint]);
            places.map(|sample| sample.position_m.length()).sum::<f64>() < NEAR * bones_m
        };
        if frames.is_empty() || !frames.iter().all(is_near) {
            return None;
        }
        for frame in frames {
            for joint in &placed {
                if let Some(sample) = &mut frame[*joint] {
                    sample.position_m += joints[*joint].offset_m;
                }
            }
        }
        Some(
            "positions are taken as displacements from the joints' offsets, as they are near zero"
                .to_owned(),
        )
    }
}

/// Finds the first line that does not have as many values as a frame.
struct LineLengths {
    channels: usize,
    line: usize,
    values: usize,
    odd: Option<(usize, usize)>,
}

impl LineLengths {
    fn new(channels: usize) -> Self {
        Self { channels, line: 0, values: channels, odd: None }
    }

    fn add(&mut self, line: usize) {
        if line != self.line {
            self.close();
            self.line = line;
            self.values = 0;
        }
        self.values += 1;
    }

    fn close(&mut self) {
        if self.odd.is_none() && self.values != self.channels {
            self.odd = Some((self.line, self.values));
        }
    }

    fn finish(mut self) -> Option<(usize, usize)> {
        self.close();
        self.odd
    }
}

fn expect(token: Token<'_>, keyword: &str) -> Result<(), Failure> {
    if token.is(keyword) { Ok(()) } else { Err(unexpected(token, format!("`{keyword}`"))) }
}

fn finite(token: Token<'_>) -> Result<f64, Failure> {
    let value: f64 = token.text.parse().unwrap_or(f64::NAN);
    // Comparisons with NaN are false, therefore NaN is refused too.
    if value.abs() <= MAGNITUDE_MAX { Ok(value) } else { Err(unexpected(token, "a finite number")) }
}

fn unexpected(token: Token<'_>, expected: impl Into<String>) -> Failure {
    let found = if token.is_end() { "the end of the file".to_owned() } else { found(token.text) };
    (token.at, Problem::Unexpected { expected: expected.into(), found })
}

#[cfg(test)]
mod tests;
