//! A place for one item between two threads. A new item replaces one that was not taken.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A place for one item.
#[derive(Debug)]
pub(crate) struct Mailbox<T> {
    slot: Mutex<Slot<T>>,
    changed: Condvar,
}

#[derive(Debug)]
struct Slot<T> {
    item: Option<T>,
    closed: bool,
}

/// What was in the mailbox.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Taken<T> {
    /// The latest item.
    Item(T),
    /// Nothing came in time.
    Nothing,
    /// Nothing is left, and nothing will come.
    Closed,
}

impl<T> Mailbox<T> {
    pub(crate) fn new() -> Self {
        let slot = Slot {
            item: None,
            closed: false,
        };
        Mailbox {
            slot: Mutex::new(slot),
            changed: Condvar::new(),
        }
    }

    /// Puts an item in place of the last one. Never waits for the taker.
    pub(crate) fn put(&self, item: T) {
        self.lock().item = Some(item);
        self.changed.notify_all();
    }

    /// Declares that nothing more will come.
    pub(crate) fn close(&self) {
        self.lock().closed = true;
        self.changed.notify_all();
    }

    /// Whether nothing more will come.
    pub(crate) fn is_closed(&self) -> bool {
        self.lock().closed
    }

    /// Takes the item; waits for one up to `time`.
    pub(crate) fn take(&self, time: Duration) -> Taken<T> {
        let empty = |slot: &mut Slot<T>| slot.item.is_none() && !slot.closed;
        let waited = self.changed.wait_timeout_while(self.lock(), time, empty);
        let (mut slot, _) = waited.unwrap_or_else(PoisonError::into_inner);
        match slot.item.take() {
            Some(item) => Taken::Item(item),
            None if slot.closed => Taken::Closed,
            None => Taken::Nothing,
        }
    }

    fn lock(&self) -> MutexGuard<'_, Slot<T>> {
        self.slot.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHORT: Duration = Duration::from_millis(1);

    #[test]
    fn the_latest_item_counts() {
        let mailbox = Mailbox::new();
        assert_eq!(mailbox.take(SHORT), Taken::Nothing);
        mailbox.put(1);
        mailbox.put(2);
        assert_eq!(mailbox.take(SHORT), Taken::Item(2));
        assert_eq!(mailbox.take(SHORT), Taken::Nothing);
        mailbox.put(3);
        mailbox.close();
        assert_eq!(mailbox.take(SHORT), Taken::Item(3));
        assert_eq!(mailbox.take(SHORT), Taken::Closed);
    }

    #[test]
    fn a_taker_wakes_up() {
        let mailbox = Mailbox::new();
        std::thread::scope(|scope| {
            let taker = scope.spawn(|| mailbox.take(Duration::from_secs(60)));
            mailbox.put(7);
            assert_eq!(taker.join().unwrap(), Taken::Item(7));
        });
    }
}
