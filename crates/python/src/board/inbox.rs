//! Orders that wait for the session, the most urgent first.

use std::cmp::Reverse;
use std::sync::mpsc::{Receiver, TryRecvError};

use anyhow::{bail, ensure};

use super::order::{Asked, Cancel, Order, Urgency};

/// The orders of Python.
#[derive(Debug)]
pub(super) struct Inbox {
    orders: Receiver<Asked>,
    waiting: Vec<Asked>,
    /// Urgency of the running order, and the wish to end it.
    running: (Urgency, Cancel),
    is_dropped: bool,
}

impl Inbox {
    pub(super) fn new(orders: Receiver<Asked>) -> Self {
        Self { orders, waiting: Vec::new(), running: Default::default(), is_dropped: false }
    }

    /// Takes the orders that have arrived. An urgent order refuses the motions that wait.
    fn receive(&mut self) {
        loop {
            match self.orders.try_recv() {
                Ok(asked) => {
                    self.refuse_motions(&asked.order);
                    self.waiting.push(asked);
                }
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => {
                    self.is_dropped = true;
                    return;
                }
            }
        }
    }

    /// Refuses the motions that wait and are less urgent than an order.
    fn refuse_motions(&mut self, order: &Order) {
        let is_refused =
            |asked: &Asked| asked.order.moves() && asked.order.urgency() < order.urgency();
        for asked in self.waiting.extract_if(.., |asked| is_refused(asked)) {
            // Nobody waits if Python was interrupted.
            let _ = asked.reply.send(Err(ended_by(order)));
        }
    }

    /// Returns the order that is executed next: the first of the most urgent ones. An order that waited until Python
    /// was interrupted is left out, unless it is urgent.
    pub(super) fn next(&mut self) -> Option<Asked> {
        self.running = Default::default();
        self.receive();
        self.waiting
            .retain(|asked| asked.order.urgency() > Urgency::Waits || !asked.cancel.is_cancelled());
        let place = (0..self.waiting.len())
            .max_by_key(|place| (self.waiting[*place].order.urgency(), Reverse(*place)))?;
        let asked = self.waiting.remove(place);
        self.running = (asked.order.urgency(), asked.cancel.clone());
        Some(asked)
    }

    /// Fails if the running order must end: a more urgent order waits, or Python was interrupted.
    pub(super) fn check(&mut self) -> anyhow::Result<()> {
        self.receive();
        if let Some(order) = self.more_urgent() {
            bail!(ended_by(order));
        }
        ensure!(!self.running.1.is_cancelled(), "interrupted");
        Ok(())
    }

    /// Returns an order that is more urgent than the running one.
    pub(super) fn more_urgent(&self) -> Option<&Order> {
        let mut orders = self.waiting.iter().map(|asked| &asked.order);
        orders.find(|order| order.urgency() > self.running.0)
    }

    /// Returns whether Python has dropped the board.
    pub(super) fn is_dropped(&self) -> bool {
        self.is_dropped && self.waiting.is_empty()
    }
}

fn ended_by(order: &Order) -> String {
    format!("ended by `{}`", order.name())
}
