//! Telemetry and faults that a controller sends on its own.

use sinew_link::message::{
    Dof, FaultRecord, SUPPLY_UNIT, Servo, SnapshotPart, Summary, TARGET_UNIT, Telemetry,
};

/// A measured pose with its tick.
#[derive(Debug, Clone, PartialEq)]
pub struct TimedPose {
    /// Tick of the controller.
    pub tick: u32,
    /// Coordinates of the rig; fewer if a frame did not arrive.
    pub q: Vec<f32>,
}

/// Received telemetry, assembled from frames, and received faults.
#[derive(Debug, Clone, Default)]
pub struct TelemetryLog {
    /// Tick of the newest frame.
    pub tick: u32,
    /// Newest summary; `None` before the first one.
    pub summary: Option<Summary>,
    /// Newest measured pose: the rig's coordinates.
    pub q: Vec<f32>,
    /// All poses that have arrived since this field was set to a list; with `None` poses are not recorded.
    pub poses: Option<Vec<TimedPose>>,
    /// Newest data of dofs.
    pub dofs: Vec<Dof>,
    /// Newest data of servos.
    pub servos: Vec<Servo>,
    /// For each dof, the newest commanded position minus the measured position, rad or m. Valid only if the summary has
    /// `errors`.
    pub targets: Vec<f32>,
    /// For each servo, the newest supply voltage, V; 0 if the servo does not report it.
    pub supplies: Vec<f32>,
    /// Number of received summaries.
    pub summaries: u32,
    /// Number of frames that did not arrive.
    pub lost: u32,
    /// Received faults, oldest first.
    pub faults: Vec<FaultRecord>,
    next: Option<u16>,
}

impl TelemetryLog {
    /// Returns the number of the newest frame; `None` before the first.
    pub(crate) fn heard(&self) -> Option<u16> {
        self.next.map(|next| next.wrapping_sub(1))
    }

    /// Stores the content of a frame in place of the older content.
    pub(crate) fn take(&mut self, Telemetry { seq, tick, part }: Telemetry) {
        if let Some(next) = self.next {
            self.lost += u32::from(seq.wrapping_sub(next));
        }
        (self.next, self.tick) = (Some(seq.wrapping_add(1)), tick);
        match part {
            SnapshotPart::Summary(summary) => {
                self.summary = Some(summary);
                self.summaries += 1;
            }
            SnapshotPart::Pose { first, q } => {
                if let Some(poses) = &mut self.poses {
                    keep(poses, tick, first, &q);
                }
                put(&mut self.q, first, &q);
            }
            SnapshotPart::Dofs { first, dofs } => put(&mut self.dofs, first, &dofs),
            SnapshotPart::Servos { first, servos } => put(&mut self.servos, first, &servos),
            SnapshotPart::Targets { first, offsets } => {
                let offsets: Vec<f32> =
                    offsets.iter().map(|offset| f32::from(*offset) * TARGET_UNIT).collect();
                put(&mut self.targets, first, &offsets);
            }
            SnapshotPart::Supplies { first, supplies } => {
                let supplies: Vec<f32> =
                    supplies.iter().map(|supply| f32::from(*supply) * SUPPLY_UNIT).collect();
                put(&mut self.supplies, first, &supplies);
            }
        }
    }
}

/// Appends coordinates of a tick's pose; `first` is the index of the first. Drops them if an earlier frame of the tick
/// is lost.
fn keep(poses: &mut Vec<TimedPose>, tick: u32, first: u8, q: &[f32]) {
    if first == 0 {
        poses.push(TimedPose { tick, q: q.to_vec() });
    } else if let Some(pose) = poses.last_mut()
        && (pose.tick, pose.q.len()) == (tick, usize::from(first))
    {
        pose.q.extend_from_slice(q);
    }
}

/// Replaces the items of a list from index `first` on. The items after the new ones stay.
fn put<T: Clone>(list: &mut Vec<T>, first: u8, items: &[T]) {
    let first = usize::from(first);
    // After a lost part, the older items stay in their places.
    if first <= list.len() {
        let behind = first + items.len();
        let rest = list.get(behind..).map(<[T]>::to_vec).unwrap_or_default();
        list.truncate(first);
        list.extend_from_slice(items);
        list.extend(rest);
    }
}
