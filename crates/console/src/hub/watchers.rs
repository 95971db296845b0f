//! Commands in other terminals that watch the rig.

use std::sync::mpsc::{SyncSender, TrySendError};
use std::time::Duration;

use sinew_board_client::{Board, Line};
use sinew_link::message::FaultRecord;

use crate::local::View;

/// Interval between two views.
const EVERY: Duration = Duration::from_millis(100);
/// Maximum number of faults that are kept for a command that reads too slowly.
const FAULTS_MAX: usize = 64;

/// A command that watches. `faults` contains the faults that it has not received yet.
#[derive(Debug)]
struct Watcher {
    views: SyncSender<View>,
    faults: Vec<FaultRecord>,
}

/// All commands that watch.
#[derive(Debug, Default)]
pub(super) struct Watchers {
    all: Vec<Watcher>,
    summaries: u32,
    last: Option<Duration>,
}

impl Watchers {
    pub(super) fn add(&mut self, views: SyncSender<View>) {
        self.all.push(Watcher { views, faults: Vec::new() });
        self.last = None;
    }

    /// Sends the newest state to all watching commands, at most every 100 ms. `faults`: faults since the last call.
    pub(super) fn tell<L: Line>(&mut self, board: &Board<L>, faults: &[FaultRecord]) {
        for watcher in &mut self.all {
            let room = FAULTS_MAX.saturating_sub(watcher.faults.len());
            watcher.faults.extend(faults.iter().take(room));
        }
        let (now, log) = (board.now(), &board.log);
        let Some(summary) = log.summary else { return };
        let is_due = self.last.is_none_or(|last| now.saturating_sub(last) >= EVERY);
        if self.all.is_empty() || !is_due || log.summaries == self.summaries {
            return;
        }
        (self.summaries, self.last) = (log.summaries, Some(now));
        self.all.retain_mut(|watcher| {
            let (servos, faults) = (log.servos.clone(), watcher.faults.clone());
            match watcher.views.try_send(View { summary, servos, faults }) {
                Ok(()) => watcher.faults.clear(),
                Err(TrySendError::Full(_)) => {}
                Err(TrySendError::Disconnected(_)) => return false,
            }
            true
        });
    }
}
