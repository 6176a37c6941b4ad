//! Keeps clients up to date: looks at what there is while there are clients, and at nothing while
//! there are none.

use std::sync::Arc;
use std::time::Duration;

use foxglove::ws_protocol::BinaryMessage as _;
use foxglove::ws_protocol::server::Time;
use genom_protocol::routes;
use tokio::time::{MissedTickBehavior, interval};
use tokio_tungstenite::tungstenite::Message;
use tokio_util::sync::CancellationToken;

use crate::feed::{Changes, Feed};
use crate::graph::Graph;
use crate::hub::Hub;

/// How often channels and the graph are looked at while there are clients; besides, whenever the
/// daemon says that something changed.
const LOOK: Duration = Duration::from_secs(1);
/// How often a virtual clock is told.
const TIME: Duration = Duration::from_millis(50);

/// Keeps clients up to date until the daemon ends.
pub(crate) async fn keep(hub: Arc<Hub>, closed: CancellationToken) {
    let mut feed = Feed::new(Arc::clone(&hub));
    loop {
        tokio::select! {
            () = hub.changed() => {}
            () = closed.cancelled() => return,
        }
        if hub.wanted().is_some() {
            tokio::select! {
                () = attend(&hub, &mut feed) => {}
                () = closed.cancelled() => return,
            }
        }
    }
}

/// Attends to clients until the last one is gone.
async fn attend(hub: &Arc<Hub>, feed: &mut Feed) {
    let mut changes = Changes::follow(hub);
    let mut ticks = interval(LOOK);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut time = interval(TIME);
    time.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let is_virtual = hub.is_virtual();
    loop {
        tokio::select! {
            _ = ticks.tick() => hub.look(false).await,
            components = changes.next() => hub.look(components).await,
            _ = time.tick(), if is_virtual => tell_time(hub).await,
            () = hub.changed() => {}
        }
        if hub.shows_graph()
            && let Ok(now) = Graph::read(&hub.inside, &hub.own).await
        {
            hub.draw(now);
        }
        let wanted = hub.wanted();
        let last = wanted.is_none();
        feed.want(wanted.unwrap_or_default());
        if last {
            return;
        }
    }
}

/// Tells the time of a virtual clock.
async fn tell_time(hub: &Hub) {
    if let Ok(clock) = hub.inside.ask(&hub.own, &routes::clock(), "").await {
        hub.tell(&Message::Binary(Time::new(clock.now).to_bytes().into()));
    }
}
