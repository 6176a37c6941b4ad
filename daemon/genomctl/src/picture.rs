//! What runs, asked of the daemon for a picture.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use genom_drawing::picture::{System, Told};
use genom_protocol::{MiddlewareParameters, Port, PortParameters, routes};

use crate::failure::Failure;
use crate::session::Session;

/// Asks the daemon; rates are of this time.
pub(crate) async fn read(session: &Session, window: Option<Duration>) -> Result<System, Failure> {
    let ports = || routes::ports().with(&PortParameters { values: Some(false) });
    let mut rates = BTreeMap::new();
    let mut before = None;
    if let Some(window) = window {
        before = Some((session.ask(ports()).await?.content.ports, Instant::now()));
        tokio::time::sleep(window).await;
    }
    let told = Told {
        ports: session.ask(ports()).await?.content.ports,
        components: session.ask(routes::components()).await?.content.components,
        connections: session.ask(routes::connections()).await?.content.connections,
        middlewares: session
            .ask(
                routes::middlewares()
                    .with(&MiddlewareParameters { visible: true, ..Default::default() }),
            )
            .await
            .ok()
            .map(|reply| reply.content),
    };
    if let Some((before, since)) = before {
        let span = since.elapsed().as_secs_f64();
        let counts = |ports: &[Port]| -> BTreeMap<String, u64> {
            let counted = ports.iter();
            counted.filter_map(|one| Some((one.address.clone(), one.traffic?.samples))).collect()
        };
        let (before, now) = (counts(&before), counts(&told.ports));
        rates.extend(now.into_iter().filter_map(|(address, count)| {
            #[allow(clippy::cast_precision_loss, reason = "a few digits are shown")]
            let passed = count.checked_sub(*before.get(&address)?)? as f64;
            Some((address, passed / span))
        }));
    }
    Ok(System::of(told, &rates))
}
