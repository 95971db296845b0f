//! Fits and writes shows, in f64.

mod channels;
mod check;
mod curve;
mod error;
mod fit;
mod measure;
mod motion;
mod pack;
mod refine;
mod settings;

use std::ops::Range;

use crate::layout::{
    CHANNEL_LEN, ChannelRecord, HEADER_LEN, Header, LARGEST_CONTROL, LOOP, SLOWED,
};
use crate::show::CHECKSUM;
use channels::groups;
use check::{check, per_sample};
use curve::Curve;
pub use error::WriteError;
pub use measure::Errors;
use measure::measure;
pub use motion::Motion;
use pack::BitWriter;
use refine::{Aim, Refined, refine};
pub use settings::Settings;

/// Minimum number of spans of a loop: a player looks three knots ahead, and not beyond the next round.
const LEAST_SPANS: i32 = 6;

/// A written show, and its errors.
#[derive(Debug, Clone)]
pub struct Written {
    /// Content of the show.
    pub bytes: Vec<u8>,
    /// Errors of angles and rotations, rad.
    pub angles: Errors,
    /// Errors of displacements and positions, m.
    pub lengths: Errors,
    /// Number of knots of all channels.
    pub knots: usize,
    /// Rounding of each coordinate: half a step of its control values. A value of the curve is a weighted mean of
    /// control values, so the rounding changes the value by at most as much. rad or m, without a unit for a component
    /// of a quaternion.
    pub rounding: Vec<f64>,
}

/// Writes a show of a motion, with few knots for the given error bounds.
///
/// # Errors
/// [`WriteError`] with the invalid part of the motion or the settings, or as in [`Writer::write`].
pub fn write(motion: &Motion<'_>, settings: &Settings) -> Result<Written, WriteError> {
    Writer::new(*motion, *settings)?.write()
}

/// A writer of successive shows of a motion, each closer to the motion than the previous one in some places.
/// Unchanged parts are reused.
pub struct Writer<'a> {
    motion: Motion<'a>,
    settings: Settings,
    /// Length of the show and of a block, in samples.
    length: i32,
    block: i32,
    joints: Vec<JointCurves>,
    ties: Vec<ShowTie>,
}

/// A joint of one coordinate that follows another such joint, the leader: `value = factor · leader + offset`, rad or m.
/// It gets the leader's knots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShowTie {
    /// Index of the joint that follows.
    pub joint: usize,
    /// Index of the joint that it follows, which follows none.
    pub leader: usize,
    /// Motion of the follower per motion of the leader; not zero.
    pub factor: f64,
    /// Position of the follower with the leader at zero.
    pub offset: f64,
}

/// Share of the error bound that a leader may use, so that a follower, with its offset in whole steps, keeps the bound
/// too. A step is half of the bound.
const OF_LEADER: f64 = 0.8;

/// The written curves of a joint.
struct JointCurves {
    /// Maximum error at each sample, as a share of the bound; empty while the bound applies everywhere.
    shares: Vec<f64>,
    channels: Vec<Channel>,
    /// Whether the channels fulfil the shares.
    is_written: bool,
}

/// A written curve.
struct Channel {
    curve: Curve,
    record: ChannelRecord,
    /// Bits of the channel, by block.
    streams: Vec<BitWriter>,
    knots: usize,
    /// Knots from the start to the end: the search for the next curve starts from them.
    laid: Vec<i32>,
}

impl<'a> Writer<'a> {
    /// Creates a writer of a motion, without any show yet.
    ///
    /// # Errors
    /// [`WriteError`] with the invalid part of the motion or the settings.
    pub fn new(motion: Motion<'a>, settings: Settings) -> Result<Self, WriteError> {
        let samples = check(&motion, &settings)?;
        let length = if motion.is_loop { samples } else { samples - 1 };
        let rate = motion.rate;
        let block = settings.block_s * f64::from(rate.samples) / f64::from(rate.seconds);
        #[expect(clippy::cast_possible_truncation, reason = "clamped")]
        let block = block.clamp(16.0, 8192.0) as i32;
        let length = i32::try_from(length).expect("checked");
        let nothing = |_| JointCurves { shares: vec![], channels: vec![], is_written: false };
        let joints = motion.joints.iter().map(nothing).collect();
        Ok(Self { motion, settings, length, block, joints, ties: Vec::new() })
    }

    /// Ties joints to leaders: a tied joint follows its leader's curve. Leaders and followers keep the error bound.
    pub fn tie(&mut self, ties: impl IntoIterator<Item = ShowTie>) {
        let count = self.motion.q.len() / per_sample(&self.motion);
        for tie in ties {
            let Some(of_leader) = self.joints.get_mut(tie.leader) else { continue };
            let most = (OF_LEADER / tie.factor.abs()).min(1.0);
            of_leader.shares.resize(count, 1.0);
            of_leader.shares.iter_mut().for_each(|share| *share = f64::min(*share, most));
            of_leader.is_written = false;
            self.ties.push(tie);
        }
    }

    /// Reduces the error bound of a joint at some samples: to a share of the previous bound, but not below `least` of
    /// the original bound. Over `beside` samples before and after, the reduction fades out: with a sudden change of
    /// the bound, the curve would have to jump. Returns `true` if the bound is now lower anywhere among `samples`.
    pub fn bring_nearer(
        &mut self,
        joint: usize,
        samples: Range<usize>,
        beside: usize,
        [share, least]: [f64; 2],
    ) -> bool {
        let count = self.motion.q.len() / per_sample(&self.motion);
        let joint = self.ties.iter().find(|tie| tie.joint == joint).map_or(joint, |tie| tie.leader);
        let Some(of_joint) = self.joints.get_mut(joint) else { return false };
        of_joint.shares.resize(count, 1.0);
        let shares = &mut of_joint.shares;
        let end = samples.end.min(count);
        let Some(least_now) = shares.get(samples.start..end).map(least_of) else {
            return false;
        };
        let wanted = (least_now * share).max(least);
        let mut is_less = false;
        for (sample, of_sample) in shares
            .iter_mut()
            .enumerate()
            .take((end + beside).min(count))
            .skip(samples.start.saturating_sub(beside))
        {
            let away = samples.start.saturating_sub(sample).max((sample + 1).saturating_sub(end));
            let part = away as f64 / (beside + 1) as f64;
            let of_place = wanted + (1.0 - wanted) * part * part;
            is_less |= away == 0 && of_place < *of_sample;
            *of_sample = f64::min(*of_sample, of_place);
        }
        of_joint.is_written &= !is_less;
        is_less
    }

    /// Writes the show.
    ///
    /// # Errors
    /// [`WriteError`] with the count that exceeds a show's limits, or with the error that could not be brought within
    /// its bound.
    pub fn write(&mut self) -> Result<Written, WriteError> {
        let (length, block) = (self.length, self.block);
        let blocks = (length + block - 1) / block;
        let most = if self.motion.is_loop { length / LEAST_SPANS } else { i32::MAX };
        let longest = (block / 4).min(most).max(1);
        self.refine(longest, blocks)?;
        let channels = || self.joints.iter().flat_map(|of_joint| &of_joint.channels);
        let records: Vec<ChannelRecord> = channels().map(|channel| channel.record).collect();
        let blocks: Vec<Vec<u8>> = (0..blocks.unsigned_abs() as usize)
            .map(|k| {
                pack::block(&channels().map(|channel| &channel.streams[k]).collect::<Vec<_>>())
            })
            .collect();
        let knots = channels().map(|channel| channel.knots).sum();
        let (motion, settings) = (&self.motion, &self.settings);
        let mut parts = Parts { motion, records: &records, blocks: &blocks, errors: [0.0; 2] };
        let timing = (length.unsigned_abs(), block.unsigned_abs());
        let (angles, lengths) = measure(&parts.bytes(timing)?, motion, settings)?;
        #[expect(clippy::cast_possible_truncation, reason = "errors are rounded")]
        {
            parts.errors = [angles.largest as f32, lengths.largest as f32];
        }
        let rounding = records.iter().map(|record| 0.5 * f64::from(record.step)).collect();
        Ok(Written { bytes: parts.bytes(timing)?, angles, lengths, knots, rounding })
    }

    /// Recomputes the channels that do not fulfil the requested shares, and those of the joints that follow them.
    fn refine(&mut self, longest: i32, blocks: i32) -> Result<(), WriteError> {
        let Self { motion, settings, block, .. } = *self;
        let per_sample = per_sample(&motion);
        let mut first = 0;
        let mut is_new = vec![false; self.joints.len()];
        for (index, (joint, of_joint)) in motion.joints.iter().zip(&mut self.joints).enumerate() {
            let range = first..first + joint.coordinate_count();
            first = range.end;
            let follows = self.ties.iter().any(|tie| tie.joint == index);
            if follows || std::mem::replace(&mut of_joint.is_written, true) {
                continue;
            }
            is_new[index] = true;
            let columns =
                range.map(|c| motion.q.iter().skip(c).step_by(per_sample).copied().collect());
            let groups = groups(*joint, columns.collect(), motion.is_loop, &settings);
            let mut before = std::mem::take(&mut of_joint.channels).into_iter();
            for (group, bound) in groups {
                let before: Vec<Vec<i32>> =
                    before.by_ref().take(group.len()).map(|channel| channel.laid).collect();
                let aim = Aim { bound, step: settings.step, shares: &of_joint.shares, longest };
                for refined in refine(&group, &aim, &before) {
                    of_joint.channels.push(Channel::new(refined, block, blocks)?);
                }
            }
        }
        for tie in &self.ties {
            let is_written = self.joints.get(tie.joint).is_some_and(|own| own.is_written);
            if is_written && !is_new.get(tie.leader).is_some_and(|is_new| *is_new) {
                continue;
            }
            let of_leader = self.joints.get(tie.leader).and_then(|leader| leader.channels.first());
            let Some(refined) = of_leader.map(|leader| leader.tied(tie)) else { continue };
            let channel = Channel::new(refined, block, blocks)?;
            if let Some(own) = self.joints.get_mut(tie.joint) {
                (own.channels, own.is_written) = (vec![channel], true);
            }
        }
        Ok(())
    }
}

impl Channel {
    fn new(refined: Refined, block: i32, blocks: i32) -> Result<Self, WriteError> {
        let Refined { curve, step, flips, laid } = refined;
        let record = pack::record(&curve, step, flips, block, blocks);
        let found = record.most.max(-record.least);
        if found > LARGEST_CONTROL {
            let [found, most] = [found, LARGEST_CONTROL].map(|n| n.unsigned_abs() as usize);
            return Err(WriteError::TooMuch { what: "steps in a channel", found, most });
        }
        let streams = pack::streams(&record, &curve, block, blocks);
        let knots = curve.knots.len();
        Ok(Self { curve, record, streams, knots, laid })
    }

    /// Returns the curve of a joint that follows this one: the same knots, with steps of another size.
    fn tied(&self, tie: &ShowTie) -> Refined {
        /// Maximum offset in steps: a quarter of the largest control value. If the follower's step is so small that its
        /// offset exceeds this, the step is made larger.
        const OFFSET_STEPS: f64 = 0.25 * LARGEST_CONTROL as f64;
        let own = f64::from(self.record.step) * tie.factor.abs();
        // A step that is too small for the offset is coarsened by a whole number, which rounds the curve.
        let coarser = (tie.offset.abs() / own / OFFSET_STEPS).ceil().max(1.0);
        #[expect(clippy::cast_possible_truncation, reason = "any number near it is as good")]
        let step = (own * coarser) as f32;
        let (factor, offset) = (tie.factor.signum() / coarser, tie.offset / f64::from(step));
        #[expect(clippy::cast_possible_truncation, reason = "saturates, and is checked")]
        let moved = |control: &i32| (f64::from(*control) * factor + offset).round() as i32;
        let controls = self.curve.controls.iter().map(moved).collect();
        let curve = Curve { knots: self.curve.knots.clone(), controls };
        Refined { curve, step, flips: false, laid: self.laid.clone() }
    }
}

fn least_of(shares: &[f64]) -> f64 {
    shares.iter().copied().fold(1.0, f64::min)
}

/// The parts of a show file.
struct Parts<'a> {
    motion: &'a Motion<'a>,
    records: &'a [ChannelRecord],
    blocks: &'a [Vec<u8>],
    /// Maximum errors, rad and m.
    errors: [f32; 2],
}

impl Parts<'_> {
    /// Returns the show. `length` and `block` are in samples.
    fn bytes(&self, (length, block): (u32, u32)) -> Result<Vec<u8>, WriteError> {
        let Self { motion, records, blocks, errors: [error_rad, error_m] } = *self;
        let mut cues = Vec::new();
        for (sample, name) in motion.cues {
            cues.extend(sample.to_le_bytes());
            cues.push(u8::try_from(name.len()).expect("checked"));
            cues.extend(name.bytes());
        }
        let mut course = Vec::new();
        if !motion.course.is_empty() {
            course.extend(u16::try_from(motion.course.len()).expect("checked").to_le_bytes());
            course.extend(
                motion.course.iter().flat_map(|(at, of)| [*at, *of]).flat_map(u32::to_le_bytes),
            );
        }
        let tables = motion.joints.len() + records.len() * CHANNEL_LEN;
        let head_len = HEADER_LEN + tables + cues.len() + course.len() + blocks.len() * 4;
        let total_len = head_len + 4 + blocks.iter().map(Vec::len).sum::<usize>();
        for (what, found, most) in
            [("bytes", total_len, 1 << 28), ("bytes of cues", cues.len(), usize::from(u16::MAX))]
        {
            if found > most {
                return Err(WriteError::TooMuch { what, found, most });
            }
        }
        let count = |count: usize| u16::try_from(count).expect("checked");
        let header = Header {
            flags: if motion.is_loop { LOOP } else { 0 }
                | if course.is_empty() { 0 } else { SLOWED },
            total_len: u32::try_from(total_len).expect("checked"),
            head_len: u32::try_from(head_len).expect("checked"),
            rig: motion.rig,
            rate: motion.rate,
            length,
            block: count(block as usize),
            joints: count(motion.joints.len()),
            channels: count(records.len()),
            cues: count(motion.cues.len()),
            cues_len: count(cues.len()),
            time_code: motion.time_code,
            error_rad,
            error_m,
        };
        let mut bytes = Vec::with_capacity(total_len);
        header.write(&mut bytes);
        bytes.extend(motion.joints.iter().map(|joint| joint.code()));
        for record in records {
            record.write(&mut bytes);
        }
        bytes.extend(&cues);
        bytes.extend(&course);
        let mut start = head_len + 4;
        for block in blocks {
            bytes.extend(u32::try_from(start).expect("checked").to_le_bytes());
            start += block.len();
        }
        bytes.extend(CHECKSUM.checksum(&bytes).to_le_bytes());
        bytes.extend(blocks.iter().flatten());
        Ok(bytes)
    }
}
