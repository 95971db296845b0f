//! What a controller has told unasked.

use sinew_link::message::{Dof, FaultRecord, Servo, SnapshotPart, Summary, Telemetry};

/// A pose as it was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct TimedPose {
    /// In which tick of the controller.
    pub tick: u32,
    /// The rig's coordinates; fewer if not all of its frames have come.
    pub q: Vec<f32>,
}

/// Telemetry, its frames put together again, and faults as they came.
#[derive(Debug, Clone, Default)]
pub struct TelemetryLog {
    /// The tick of the last frame.
    pub tick: u32,
    /// The newest summary.
    pub summary: Option<Summary>,
    /// The newest pose, the rig's coordinates.
    pub q: Vec<f32>,
    /// All poses since this was put here, for those who record.
    pub poses: Option<Vec<TimedPose>>,
    /// The newest of degrees of freedom.
    pub dofs: Vec<Dof>,
    /// The newest of servos.
    pub servos: Vec<Servo>,
    /// Summaries that came.
    pub summaries: u32,
    /// Frames that did not come.
    pub lost: u32,
    /// Faults that came, the first of them first.
    pub faults: Vec<FaultRecord>,
    next: Option<u16>,
}

impl TelemetryLog {
    /// The number of the newest frame.
    pub(crate) fn heard(&self) -> Option<u16> {
        self.next.map(|next| next.wrapping_sub(1))
    }

    /// Takes a frame: what it tells takes the place of what was there.
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
        }
    }
}

/// Numbers of a tick's pose from `first` on. What comes behind a frame that was lost belongs to no pose.
fn keep(poses: &mut Vec<TimedPose>, tick: u32, first: u8, q: &[f32]) {
    if first == 0 {
        poses.push(TimedPose { tick, q: q.to_vec() });
    } else if let Some(pose) = poses.last_mut()
        && (pose.tick, pose.q.len()) == (tick, usize::from(first))
    {
        pose.q.extend_from_slice(q);
    }
}

/// Items of a list from `first` on. The part that begins a list ends what was there before.
fn put<T: Clone>(list: &mut Vec<T>, first: u8, items: &[T]) {
    let first = usize::from(first);
    // One that was lost leaves the old ones in their places.
    if first <= list.len() {
        let behind = first + items.len();
        let rest = list.get(behind..).map(<[T]>::to_vec).unwrap_or_default();
        list.truncate(first);
        list.extend_from_slice(items);
        list.extend(rest);
    }
}
