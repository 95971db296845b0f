//! What a controller has told unasked.

use sinew_link::message::{Dof, FaultRecord, Part, Servo, Summary, Telemetry};

/// Telemetry, its frames put together again, and faults as they came.
#[derive(Debug, Clone, Default)]
pub struct Seen {
    /// The tick of the last frame.
    pub tick: u32,
    /// The newest summary.
    pub summary: Option<Summary>,
    /// The newest pose, the rig's coordinates.
    pub q: Vec<f32>,
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

impl Seen {
    /// Takes a frame: what it tells takes the place of what was there.
    pub(crate) fn take(&mut self, Telemetry { seq, tick, part }: Telemetry) {
        if let Some(next) = self.next {
            self.lost += u32::from(seq.wrapping_sub(next));
        }
        (self.next, self.tick) = (Some(seq.wrapping_add(1)), tick);
        match part {
            Part::Summary(summary) => {
                self.summary = Some(summary);
                self.summaries += 1;
            }
            Part::Pose { first, q } => put(&mut self.q, first, &q),
            Part::Dofs { first, dofs } => put(&mut self.dofs, first, &dofs),
            Part::Servos { first, servos } => put(&mut self.servos, first, &servos),
        }
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
