//! Telemetry: a snapshot of a rig, cut into frames.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use super::{Limit, POSE_MAX, State};
use crate::finite;

/// Maximum number of dofs in a frame.
pub const DOFS_A_FRAME: usize = 42;

/// Maximum number of servos in a frame.
pub const SERVOS_A_FRAME: usize = 32;

/// Maximum number of dofs in a frame of targets.
pub const TARGETS_A_FRAME: usize = 64;

/// Maximum number of servos in a frame of supply voltages.
pub const SUPPLIES_A_FRAME: usize = 64;

/// Unit of a servo's supply voltage, V.
pub const SUPPLY_UNIT: f32 = 0.1;

/// Unit of a target offset, rad or m.
pub const TARGET_UNIT: f32 = 1e-4;

/// A frame of telemetry. All frames of a tick form a snapshot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Telemetry {
    /// Number of the frame; it rises by one, and wraps from 65535 to 0.
    pub seq: u16,
    /// The tick of the snapshot.
    pub tick: u32,
    /// Content of the frame.
    pub part: SnapshotPart,
}

/// A part of a snapshot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum SnapshotPart {
    /// State of the whole rig.
    Summary(Summary),
    /// The measured pose.
    Pose {
        /// Index of the first coordinate.
        first: u8,
        /// Coordinates: rad, m, unit quaternions xyzw.
        #[serde(with = "finite::list")]
        q: Vec<f32, POSE_MAX>,
    },
    /// Data of dofs.
    Dofs {
        /// Index of the first dof.
        first: u8,
        /// Dofs in order.
        dofs: Vec<Dof, DOFS_A_FRAME>,
    },
    /// Data of servos.
    Servos {
        /// Index of the first servo.
        first: u8,
        /// Servos in order.
        servos: Vec<Servo, SERVOS_A_FRAME>,
    },
    /// Commanded minus measured position of dofs. Since version 1.2.
    Targets {
        /// Index of the first dof.
        first: u8,
        /// Offsets of dofs in order, in [`TARGET_UNIT`].
        offsets: Vec<i16, TARGETS_A_FRAME>,
    },
    /// Supply voltages of servos. Since version 1.3.
    Supplies {
        /// Index of the first servo.
        first: u8,
        /// Voltages of servos in order, in [`SUPPLY_UNIT`]; 0 for a servo that does not report it.
        supplies: Vec<u8, SUPPLIES_A_FRAME>,
    },
}

/// The state of the whole rig. Counts are since power-on, and stop at their maximum.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// State of the rig.
    pub state: State,
    /// Latched fault with the lowest number in `docs/faults.md`; if none is latched, a present warning.
    pub fault: Option<u8>,
    /// Difference between pose and target; `None` without a target.
    pub errors: Option<Errors>,
    /// Mean duration of a tick since the last snapshot, us.
    pub tick_us: u16,
    /// Longest tick since the last snapshot, us.
    pub tick_max_us: u16,
    /// Number of ticks that took too long.
    pub overruns: u32,
    /// Bytes of the stack that were never used.
    pub stack_free: u32,
    /// Lowest supply voltage that a servo reports, V; 0 if none reports it.
    #[serde(with = "finite")]
    pub supply_v: f32,
    /// Number of frames that arrived damaged.
    pub link_damaged: u32,
    /// Number of frames that did not arrive.
    pub link_lost: u32,
    /// Age of the newest live frame, ms; `None` without a live source.
    pub live_age_ms: Option<u16>,
    /// Position in the show, ms.
    pub show_ms: u32,
}

/// Difference between the measured and the commanded pose.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Mean error of the dofs, deg.
    #[serde(with = "finite")]
    pub mean_deg: f32,
    /// Largest error of a dof, deg.
    #[serde(with = "finite")]
    pub largest_deg: f32,
    /// Mean distance of joints from their target positions, cm.
    #[serde(with = "finite")]
    pub mean_cm: f32,
    /// Largest distance of a joint from its target position, cm.
    #[serde(with = "finite")]
    pub largest_cm: f32,
    /// Index of the dof with the largest error.
    pub worst: u8,
}

/// Data of a dof.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Dof {
    /// Commanded effort, N m or N.
    #[serde(with = "finite")]
    pub effort: f32,
    /// Limit that reduced the effort, or `None`.
    pub limiter: Option<Limit>,
    /// Commanded minus measured position in [`TARGET_UNIT`], limited to the range of `i16`; for a dof of a ball joint a
    /// component of the rotation vector, in body axes. It is sent in [`SnapshotPart::Targets`], not in
    /// [`SnapshotPart::Dofs`].
    #[serde(skip)]
    pub target: i16,
}

/// Data of a servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Servo {
    /// Temperature, degC; `None` if the servo does not report it.
    pub temperature_c: Option<i8>,
    /// Heat of the winding by the model, as a percentage of its maximum.
    pub heat_percent: u8,
    /// Number of bus errors: missing replies, and readings that were not believed.
    pub bus_errors: u16,
    /// Last error number in a reply, in the numbering of the servo's protocol; 0 for none.
    pub hardware_error: u8,
    /// Supply voltage in [`SUPPLY_UNIT`], at most 25.5 V; 0 if the servo does not report it. It is sent in
    /// [`SnapshotPart::Supplies`], not in [`SnapshotPart::Servos`].
    #[serde(skip)]
    pub supply: u8,
}

/// Minor version from which on a host acknowledges telemetry.
pub const ACKNOWLEDGED_SINCE: u8 = 2;

/// Minimum rate of summaries to a host that acknowledges them, Hz, while torque is on.
pub const TELEMETRY_LEAST_HZ: f32 = 5.0;

/// A set of parts of a snapshot, one bit each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct TelemetryParts(pub u8);

impl TelemetryParts {
    /// The state of the whole rig.
    pub const SUMMARY: Self = Self(1);
    /// The measured pose.
    pub const POSE: Self = Self(2);
    /// Data of dofs.
    pub const DOFS: Self = Self(4);
    /// Data of servos.
    pub const SERVOS: Self = Self(8);
    /// Commanded minus measured position of dofs, while torque is on. Since version 1.2; an older controller leaves it
    /// out of the setting that it answers.
    pub const TARGETS: Self = Self(16);
    /// Supply voltages of servos. Since version 1.3; an older controller leaves it out of the setting that it answers.
    pub const SUPPLIES: Self = Self(32);
    /// All parts of a snapshot but the targets and the supply voltages.
    pub const ALL: Self = Self(15);

    /// Returns the union of both sets.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Returns `true` if this set contains all parts of `other`.
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

/// Parts and rate of telemetry.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TelemetrySetting {
    /// Snapshots per second; 0 for none.
    #[serde(with = "finite")]
    pub rate_hz: f32,
    /// Parts of each snapshot.
    pub parts: TelemetryParts,
}

/// The whole telemetry of a tick. The caller keeps it until all its frames are sent.
#[derive(Debug, Clone, Copy)]
pub struct Snapshot<'a> {
    /// Number of the tick.
    pub tick: u32,
    /// State of the whole rig.
    pub summary: &'a Summary,
    /// The measured pose, at most 256 numbers.
    pub q: &'a [f32],
    /// Data of dofs, at most 256.
    pub dofs: &'a [Dof],
    /// Data of servos, at most 256.
    pub servos: &'a [Servo],
}

impl Snapshot<'_> {
    /// Returns the number of frames for these parts.
    pub fn frames(&self, parts: TelemetryParts) -> usize {
        let count = |part: TelemetryParts, frames: usize| if parts.has(part) { frames } else { 0 };
        count(TelemetryParts::SUMMARY, 1)
            .saturating_add(count(TelemetryParts::POSE, self.q.len().div_ceil(POSE_MAX)))
            .saturating_add(count(TelemetryParts::DOFS, self.dofs.len().div_ceil(DOFS_A_FRAME)))
            .saturating_add(count(
                TelemetryParts::SERVOS,
                self.servos.len().div_ceil(SERVOS_A_FRAME),
            ))
            .saturating_add(count(
                TelemetryParts::TARGETS,
                self.dofs.len().div_ceil(TARGETS_A_FRAME),
            ))
            .saturating_add(count(
                TelemetryParts::SUPPLIES,
                self.servos.len().div_ceil(SUPPLIES_A_FRAME),
            ))
    }

    /// Returns frame `index` of these parts, with the number `seq`; `None` after the last. O(numbers of the frame).
    pub fn frame(&self, parts: TelemetryParts, index: usize, seq: u16) -> Option<Telemetry> {
        let mut index = index;
        let part = self.part(parts, &mut index)?;
        Some(Telemetry { seq, tick: self.tick, part })
    }

    /// Returns the content of frame `index`, or `None` after the last frame. Subtracts from `index` the number of
    /// frames of each earlier part.
    fn part(&self, parts: TelemetryParts, index: &mut usize) -> Option<SnapshotPart> {
        if parts.has(TelemetryParts::SUMMARY) && take(index, 1).is_some() {
            return Some(SnapshotPart::Summary(*self.summary));
        }
        if parts.has(TelemetryParts::POSE)
            && let Some((first, q)) = chunk(self.q, index, |q| *q)
        {
            return Some(SnapshotPart::Pose { first, q });
        }
        if parts.has(TelemetryParts::DOFS)
            && let Some((first, dofs)) = chunk(self.dofs, index, |dof| *dof)
        {
            return Some(SnapshotPart::Dofs { first, dofs });
        }
        if parts.has(TelemetryParts::SERVOS)
            && let Some((first, servos)) = chunk(self.servos, index, |servo| *servo)
        {
            return Some(SnapshotPart::Servos { first, servos });
        }
        if parts.has(TelemetryParts::TARGETS)
            && let Some((first, offsets)) = chunk(self.dofs, index, |dof| dof.target)
        {
            return Some(SnapshotPart::Targets { first, offsets });
        }
        if parts.has(TelemetryParts::SUPPLIES)
            && let Some((first, supplies)) = chunk(self.servos, index, |servo| servo.supply)
        {
            return Some(SnapshotPart::Supplies { first, supplies });
        }
        None
    }
}

/// Returns `index` if it is less than `frames`. Otherwise subtracts `frames` from `index` and returns `None`.
fn take(index: &mut usize, frames: usize) -> Option<usize> {
    match index.checked_sub(frames) {
        Some(behind) => {
            *index = behind;
            None
        }
        None => Some(*index),
    }
}

/// Returns chunk `index` of a list, as `of` converts its items, with the index of its first item. If the list has no
/// such chunk, subtracts its number of chunks from `index` and returns `None`.
fn chunk<T, U, const N: usize>(
    list: &[T],
    index: &mut usize,
    of: impl FnMut(&T) -> U,
) -> Option<(u8, Vec<U, N>)> {
    let index = take(index, list.len().div_ceil(N))?;
    let first = index.checked_mul(N)?;
    let items = list.get(first..)?;
    Some((u8::try_from(first).ok()?, items.iter().take(N).map(of).collect()))
}
