//! Moves on a circle of time.

/// An instant at which a value begins to move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Event {
    /// Start, s, within the loop.
    pub(super) start_s: f64,
    /// Value at the end of the move; 1 is the whole amplitude of a joint.
    pub(super) target: f64,
    /// Shortest duration of the move, s.
    pub(super) least_s: f64,
}

/// Moves that begin and end at rest, in the order of time. The last move goes on into the next round until the first
/// move begins, so the loop has no seam.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Moves {
    events: Vec<Event>,
    /// Duration of each event's move, s.
    spans_s: Vec<f64>,
    loop_s: f64,
}

impl Moves {
    /// Creates moves. `span_s` returns the duration that a change of the value needs. The caller leaves enough time
    /// between two events.
    pub(super) fn new(loop_s: f64, events: Vec<Event>, span_s: impl Fn(f64) -> f64) -> Self {
        let before = |at: usize| events[(at + events.len() - 1) % events.len()].target;
        let spans_s = events
            .iter()
            .enumerate()
            .map(|(at, event)| span_s((event.target - before(at)).abs()).max(event.least_s))
            .collect();
        Self { events, spans_s, loop_s }
    }

    /// Returns the value at a time within the loop, s; 0 without moves.
    pub(super) fn at(&self, time_s: f64) -> f64 {
        let count = self.events.len();
        let Some(last) = count.checked_sub(1) else { return 0.0 };
        let next = self.events.partition_point(|event| event.start_s <= time_s);
        let (now, since_s) = match next.checked_sub(1) {
            Some(now) => (now, time_s - self.events[now].start_s),
            None => (last, time_s + self.loop_s - self.events[last].start_s),
        };
        let (from, to) = (self.events[(now + count - 1) % count].target, self.events[now].target);
        from + (to - from) * quintic((since_s / self.spans_s[now]).min(1.0))
    }
}

/// Returns the share of a move's way after a share of its time. The move has the least jerk, and is at rest at both
/// ends: 10 t³ - 15 t⁴ + 6 t⁵.
fn quintic(time: f64) -> f64 {
    time * time * time * (10.0 + time * (6.0 * time - 15.0))
}

/// Returns the duration of a move over a distance within a speed and an acceleration.
pub(super) fn span_s(distance: f64, speed: f64, acceleration: f64) -> f64 {
    // Largest slope and curvature of the quintic.
    f64::max(1.875 * distance / speed, (5.7736 * distance / acceleration).sqrt())
}
