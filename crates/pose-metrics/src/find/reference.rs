//! References to a pose or a part of a clip: `FILE@12`, `FILE@1.25s`, `FILE@1.0s..2.5s`, `FILE`.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use sinew_figure::pipeline::LoadedClip;

/// A file, and the part of it that is meant.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Path of the file.
    pub file: PathBuf,
    /// Part of the clip in the file.
    pub part: ClipPart,
}

/// A part of a clip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClipPart {
    /// The whole clip.
    Whole,
    /// A single pose.
    Pose(ClipTime),
    /// A range from one place to another, both included.
    Range(ClipTime, ClipTime),
}

/// A place in a clip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClipTime {
    /// A frame of the file, counted from 0 and including an inserted T-pose.
    Frame(usize),
    /// The frame nearest to a time, in seconds from frame 0.
    Seconds(f64),
}

/// The error of an invalid reference.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ReferenceError {
    /// The text after `@` is not a place.
    #[error(
        "`{text}`: expected FILE@FRAME (from 0), FILE@SECONDSs, FILE@FROM..TO with both in frames or both in seconds, or FILE; \
         found `{part}` after the last @"
    )]
    Syntax {
        /// Whole text of the reference.
        text: String,
        /// Text after `@`.
        part: String,
    },
    /// The place is not in the clip.
    #[error("{file}: expected a place from {first} to {last}, found {found}")]
    Outside {
        /// Path of the file.
        file: String,
        /// First valid frame.
        first: FrameTime,
        /// Last valid frame.
        last: FrameTime,
        /// Requested place.
        found: ClipTime,
    },
    /// The range does not end after its start.
    #[error("{file}: expected FROM before TO, found {from}..{to}")]
    Backwards {
        /// Path of the file.
        file: String,
        /// Requested start.
        from: ClipTime,
        /// Requested end.
        to: ClipTime,
    },
}

/// A frame with its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameTime {
    /// Index of the frame, from 0.
    pub frame: usize,
    /// Time in seconds from frame 0.
    pub seconds: f64,
}

impl fmt::Display for FrameTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "frame {} ({:.3} s)", self.frame, self.seconds)
    }
}

impl fmt::Display for ClipTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Frame(frame) => write!(f, "{frame}"),
            Self::Seconds(seconds) => write!(f, "{seconds}s"),
        }
    }
}

impl ClipTime {
    fn parse(text: &str) -> Option<Self> {
        match text.strip_suffix('s') {
            None => text.parse().ok().map(Self::Frame),
            Some(seconds) => {
                let seconds = seconds.parse().ok().filter(|s| (0.0..1e9).contains(s));
                seconds.map(Self::Seconds)
            }
        }
    }
}

impl FromStr for Reference {
    type Err = ReferenceError;

    fn from_str(text: &str) -> Result<Self, ReferenceError> {
        let whole = || Self { file: text.into(), part: ClipPart::Whole };
        let Some((file, after)) = text.rsplit_once('@') else { return Ok(whole()) };
        let part = match after.split_once("..") {
            None => ClipTime::parse(after).map(ClipPart::Pose),
            Some((from, to)) => match (ClipTime::parse(from), ClipTime::parse(to)) {
                (Some(from @ ClipTime::Frame(_)), Some(to @ ClipTime::Frame(_)))
                | (Some(from @ ClipTime::Seconds(_)), Some(to @ ClipTime::Seconds(_))) => {
                    Some(ClipPart::Range(from, to))
                }
                _ => None,
            },
        };
        match part {
            Some(part) => Ok(Self { file: file.into(), part }),
            // A file's name may contain the sign.
            None if Path::new(text).exists() => Ok(whole()),
            None => Err(ReferenceError::Syntax { text: text.into(), part: after.into() }),
        }
    }
}

impl Reference {
    /// Returns the first and the last frame of the part, in the clip without its T-pose.
    ///
    /// # Errors
    /// [`ReferenceError::Outside`] if a place is not in the clip, [`ReferenceError::Backwards`] if a range does not end
    /// after its start.
    pub fn frames(&self, recorded: &LoadedClip) -> Result<(usize, usize), ReferenceError> {
        let last = recorded.clip.frames.len() - 1;
        match self.part {
            ClipPart::Whole => Ok((0, last)),
            ClipPart::Pose(at) => self.frame(recorded, at).map(|frame| (frame, frame)),
            ClipPart::Range(from, to) => {
                let frames = (self.frame(recorded, from)?, self.frame(recorded, to)?);
                if frames.0 >= frames.1 {
                    let file = self.file.display().to_string();
                    return Err(ReferenceError::Backwards { file, from, to });
                }
                Ok(frames)
            }
        }
    }

    fn frame(&self, recorded: &LoadedClip, at: ClipTime) -> Result<usize, ReferenceError> {
        let LoadedClip { clip, skipped, .. } = recorded;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative, and saturates"
        )]
        let frame = match at {
            ClipTime::Frame(frame) => frame,
            ClipTime::Seconds(seconds) => libm::round(seconds / clip.frame_time_s) as usize,
        };
        let inside = frame.checked_sub(*skipped).filter(|frame| *frame < clip.frames.len());
        inside.ok_or_else(|| {
            let place =
                |frame: usize| FrameTime { frame, seconds: frame as f64 * clip.frame_time_s };
            let (first, last) = (place(*skipped), place(skipped + clip.frames.len() - 1));
            ReferenceError::Outside {
                file: self.file.display().to_string(),
                first,
                last,
                found: at,
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_read() {
        let of = |text: &str| text.parse::<Reference>().map(|reference| reference.part);
        assert_eq!(of("a.bvh"), Ok(ClipPart::Whole));
        assert_eq!(of("a.bvh@12"), Ok(ClipPart::Pose(ClipTime::Frame(12))));
        assert_eq!(of("a.bvh@1.25s"), Ok(ClipPart::Pose(ClipTime::Seconds(1.25))));
        assert_eq!(
            of("a.bvh@10..40"),
            Ok(ClipPart::Range(ClipTime::Frame(10), ClipTime::Frame(40)))
        );
        assert_eq!(
            of("a.bvh@1s..2.5s"),
            Ok(ClipPart::Range(ClipTime::Seconds(1.0), ClipTime::Seconds(2.5)))
        );
        assert_eq!("a@b@3".parse::<Reference>().unwrap().file, Path::new("a@b"));
        for bad in ["a@", "a@x", "a@-1", "a@1.5", "a@nans", "a@infs", "a@1..2s", "a@1s..", "a@-1s"]
        {
            let error = of(bad).unwrap_err().to_string();
            let part = bad.split_once('@').unwrap().1;
            assert!(error.ends_with(&format!("found `{part}` after the last @")), "{error}");
        }
    }
}
