//! Work that is given away, and whose end the giver waits for.

use tokio::sync::mpsc::{Receiver, Sender, channel};

/// Held by whoever does a part of the work; the work is done when all of these are dropped.
#[derive(Clone, Debug)]
pub struct Doing {
    _alive: Sender<()>,
}

/// Waits for the end of the work.
#[derive(Debug)]
pub(crate) struct Waiting(Receiver<()>);

/// Work that begins now.
pub(crate) fn work() -> (Doing, Waiting) {
    let (alive, over) = channel(1);
    (Doing { _alive: alive }, Waiting(over))
}

impl Waiting {
    pub(crate) async fn done(&mut self) {
        let _ = self.0.recv().await;
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use tokio::time::timeout;

    use super::*;

    #[tokio::test]
    async fn work_is_done_when_the_last_part_of_it_is() {
        let (doing, mut waiting) = work();
        let part = doing.clone();
        drop(doing);
        assert!(timeout(Duration::ZERO, waiting.done()).await.is_err());
        drop(part);
        waiting.done().await;
    }
}
