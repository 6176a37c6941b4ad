//! Work that is done once for all who ask for it meanwhile.

use std::time::Instant;

use tokio::sync::Mutex;

/// The latest result, and when its work began.
pub(crate) struct Together<T>(Mutex<Option<(Instant, T)>>);

impl<T: Clone> Together<T> {
    pub(crate) const fn new() -> Self {
        Self(Mutex::const_new(None))
    }

    /// The result of `work`, which is done by one caller at a time. Callers that waited for their
    /// turn share a result if its work began after they called: however many they are, it is done
    /// once more for all of them.
    pub(crate) async fn get<E>(&self, work: impl Future<Output = Result<T, E>>) -> Result<T, E> {
        let called = Instant::now();
        let mut latest = self.0.lock().await;
        if let Some((begun, result)) = &*latest
            && *begun >= called
        {
            return Ok(result.clone());
        }
        let begun = Instant::now();
        let result = work.await?;
        *latest = Some((begun, result.clone()));
        Ok(result)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use tokio::sync::Semaphore;

    #[tokio::test]
    async fn those_who_ask_while_work_is_under_way_share_the_next() {
        static SHARED: Together<usize> = Together::new();
        static DONE: AtomicUsize = AtomicUsize::new(0);
        static GO_ON: Semaphore = Semaphore::const_new(0);
        let ask = || async {
            let work = async {
                let _ = GO_ON.acquire().await;
                Ok::<_, ()>(DONE.fetch_add(1, Ordering::Relaxed) + 1)
            };
            SHARED.get(work).await
        };
        // A task runs on this thread until it waits: the first one works, fifty wait for it.
        let first = tokio::spawn(ask());
        tokio::task::yield_now().await;
        let others: Vec<_> = (0..50).map(|_| tokio::spawn(ask())).collect();
        tokio::task::yield_now().await;
        GO_ON.add_permits(1);
        assert_eq!(first.await.unwrap(), Ok(1));
        for other in others {
            assert_eq!(other.await.unwrap(), Ok(2));
        }
        assert_eq!(ask().await, Ok(3), "nobody gets what began before they asked");
    }

    #[tokio::test]
    async fn work_that_failed_is_done_again_for_the_next() {
        let shared = Together::new();
        assert_eq!(shared.get(async { Err("once") }).await, Err("once"));
        assert_eq!(shared.get(async { Ok::<_, &str>(1) }).await, Ok(1));
    }
}
