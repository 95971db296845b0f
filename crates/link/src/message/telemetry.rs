//! How a rig is: a snapshot, cut into frames.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use super::{Limit, POSE_MAX, State};
use crate::finite;

/// Degrees of freedom in a frame, at most.
pub const DOFS_A_FRAME: usize = 42;

/// Servos in a frame, at most.
pub const SERVOS_A_FRAME: usize = 32;

/// A frame of telemetry. Frames of one tick are one snapshot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Telemetry {
    /// The number of the frame: rises by one, 65535 to 0 again.
    pub seq: u16,
    /// The tick of the snapshot.
    pub tick: u32,
    /// What it says.
    pub part: SnapshotPart,
}

/// A part of a snapshot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum SnapshotPart {
    /// The whole rig.
    Summary(Summary),
    /// The measured pose.
    Pose {
        /// Which coordinate the first number is.
        first: u8,
        /// Coordinates: rad, m, unit quaternions xyzw.
        #[serde(with = "finite::list")]
        q: Vec<f32, POSE_MAX>,
    },
    /// Degrees of freedom.
    Dofs {
        /// Which one the first is.
        first: u8,
        /// They.
        dofs: Vec<Dof, DOFS_A_FRAME>,
    },
    /// Servos.
    Servos {
        /// Which one the first is.
        first: u8,
        /// They.
        servos: Vec<Servo, SERVOS_A_FRAME>,
    },
}

/// The rig as a whole. Counts are since power-on, and stop at their largest value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// What the rig does.
    pub state: State,
    /// The latched fault with the lowest number in `docs/faults.md`; if none is latched, a warning that is there.
    pub fault: Option<u8>,
    /// How far the pose is from the target; none if there is no target.
    pub errors: Option<Errors>,
    /// How long a tick took on average since the last snapshot, us.
    pub tick_us: u16,
    /// The longest tick since the last snapshot, us.
    pub tick_max_us: u16,
    /// Ticks that took too long.
    pub overruns: u32,
    /// Bytes of the stack that were never used.
    pub stack_free: u32,
    /// The supply of the servos, V; 0 if it is not measured.
    #[serde(with = "finite")]
    pub supply_v: f32,
    /// Frames that came damaged.
    pub link_damaged: u32,
    /// Frames that did not come.
    pub link_lost: u32,
    /// Age of the newest live frame, ms; none without a live source.
    pub live_age_ms: Option<u16>,
    /// Where the show is, ms.
    pub show_ms: u32,
}

/// How far the pose is from the target, over all joints.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Mean angle, deg.
    #[serde(with = "finite")]
    pub mean_deg: f32,
    /// Largest angle, deg.
    #[serde(with = "finite")]
    pub largest_deg: f32,
    /// Mean distance of the joints, cm.
    #[serde(with = "finite")]
    pub mean_cm: f32,
    /// Largest distance of a joint, cm.
    #[serde(with = "finite")]
    pub largest_cm: f32,
    /// The joint with the largest angle.
    pub worst: u8,
}

/// A degree of freedom.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Dof {
    /// What it was commanded, N m or N.
    #[serde(with = "finite")]
    pub effort: f32,
    /// What limited it, if anything did.
    pub limiter: Option<Limit>,
}

/// A servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Servo {
    /// Its temperature, degC; none if it does not say.
    pub temperature_c: Option<i8>,
    /// How much of the heat that it may have its winding has, by the model, %.
    pub heat_percent: u8,
    /// Errors on the bus: replies that did not come, or were not believed.
    pub bus_errors: u16,
    /// What is wrong with it, bit by bit in its own way.
    pub hardware_error: u8,
}

/// The minor version from which on a host acknowledges telemetry.
pub const ACKNOWLEDGED_SINCE: u8 = 2;

/// Summaries a second that a host gets that acknowledges them, at least, while torque is on.
pub const TELEMETRY_LEAST_HZ: f32 = 5.0;

/// Which parts of a snapshot to send, bit by bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct TelemetryParts(pub u8);

impl TelemetryParts {
    /// The rig as a whole.
    pub const SUMMARY: Self = Self(1);
    /// The pose.
    pub const POSE: Self = Self(2);
    /// Degrees of freedom.
    pub const DOFS: Self = Self(4);
    /// Servos.
    pub const SERVOS: Self = Self(8);
    /// All parts.
    pub const ALL: Self = Self(15);

    /// These and those.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether all of `other` are among these.
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

/// Which telemetry to send, and how often.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TelemetrySetting {
    /// Snapshots a second; 0 for none.
    #[serde(with = "finite")]
    pub rate_hz: f32,
    /// Their parts.
    pub parts: TelemetryParts,
}

/// All that telemetry says of one tick. The caller keeps it until all its frames are sent.
#[derive(Debug, Clone, Copy)]
pub struct Snapshot<'a> {
    /// The tick.
    pub tick: u32,
    /// The rig as a whole.
    pub summary: &'a Summary,
    /// The measured pose, at most 256 numbers.
    pub q: &'a [f32],
    /// Degrees of freedom, at most 256.
    pub dofs: &'a [Dof],
    /// Servos, at most 256.
    pub servos: &'a [Servo],
}

impl Snapshot<'_> {
    /// How many frames these parts take.
    pub fn frames(&self, parts: TelemetryParts) -> usize {
        let count = |part: TelemetryParts, frames: usize| if parts.has(part) { frames } else { 0 };
        count(TelemetryParts::SUMMARY, 1)
            .saturating_add(count(TelemetryParts::POSE, self.q.len().div_ceil(POSE_MAX)))
            .saturating_add(count(TelemetryParts::DOFS, self.dofs.len().div_ceil(DOFS_A_FRAME)))
            .saturating_add(count(
                TelemetryParts::SERVOS,
                self.servos.len().div_ceil(SERVOS_A_FRAME),
            ))
    }

    /// Frame number `index` of these parts, with the number `seq`; none behind the last. O(numbers of the frame).
    pub fn frame(&self, parts: TelemetryParts, index: usize, seq: u16) -> Option<Telemetry> {
        let mut index = index;
        let part = self.part(parts, &mut index)?;
        Some(Telemetry { seq, tick: self.tick, part })
    }

    /// Counts `index` down, part after part.
    fn part(&self, parts: TelemetryParts, index: &mut usize) -> Option<SnapshotPart> {
        if parts.has(TelemetryParts::SUMMARY) && take(index, 1).is_some() {
            return Some(SnapshotPart::Summary(*self.summary));
        }
        if parts.has(TelemetryParts::POSE)
            && let Some((first, q)) = chunk(self.q, index)
        {
            return Some(SnapshotPart::Pose { first, q });
        }
        if parts.has(TelemetryParts::DOFS)
            && let Some((first, dofs)) = chunk(self.dofs, index)
        {
            return Some(SnapshotPart::Dofs { first, dofs });
        }
        if parts.has(TelemetryParts::SERVOS)
            && let Some((first, servos)) = chunk(self.servos, index)
        {
            return Some(SnapshotPart::Servos { first, servos });
        }
        None
    }
}

/// The index within `frames` frames; or none, and `index` counts from behind them.
fn take(index: &mut usize, frames: usize) -> Option<usize> {
    match index.checked_sub(frames) {
        Some(behind) => {
            *index = behind;
            None
        }
        None => Some(*index),
    }
}

/// The chunk of a list at `index`, with the place of its first item.
fn chunk<T: Clone, const N: usize>(list: &[T], index: &mut usize) -> Option<(u8, Vec<T, N>)> {
    let index = take(index, list.len().div_ceil(N))?;
    let first = index.checked_mul(N)?;
    let items = list.get(first..)?;
    let items = items.get(..N).unwrap_or(items);
    Some((u8::try_from(first).ok()?, Vec::from_slice(items).ok()?))
}
