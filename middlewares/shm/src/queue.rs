//! Connections with policy `queue`, which keep their oldest samples.
//!
//! A port's own service overwrites the oldest unread sample, as policies `latest` and `ring` need.
//! Readers with policy `queue` use a second service, which refuses new samples when full; the
//! writer joins it only when there is such a reader. A reader shows that it is one by the name of
//! its subscriber on the port's own service.

use std::sync::Arc;

use genom_middleware::{Address, OpenError};
use genom_types::DataType;
use iceoryx2::prelude::*;

use crate::error::failed;
use crate::ground::{Ground, Shape};
use crate::raw::{RawPublisher, RawService, RawSubscriber};
use crate::typing::Wire;

/// Prefix of the names of queue services.
pub(crate) const PREFIX: &str = "genom.queue/";

/// Name of the subscriber that a reader with policy `queue` has on the port's own service.
const MARK: &str = "genom.queue";

pub(crate) fn mark() -> Option<PortName> {
    PortName::new(MARK).ok()
}

/// Whether some reader of the port has policy `queue`.
pub(crate) fn wanted(service: &RawService) -> bool {
    let mark = mark();
    let mut found = false;
    service.dynamic_config().list_subscribers(|reader| {
        if Some(reader.subscriber_name) == mark {
            found = true;
            return CallbackProgression::Stop;
        }
        CallbackProgression::Continue
    });
    found
}

fn open(
    ground: &Ground,
    at: &Address,
    ty: &DataType,
    port: Shape,
) -> Result<Arc<RawService>, OpenError> {
    let shape = Shape { overflow: false, history: false, ..port };
    ground.service(at, &format!("{PREFIX}{at}"), ty, shape)
}

/// Creates the writer's end.
pub(crate) fn join(
    ground: &Ground,
    at: &Address,
    ty: &DataType,
    wire: &Wire,
    port: Shape,
) -> Result<RawPublisher, OpenError> {
    let service = open(ground, at, ty, port)?;
    ground.writer(at, &service, wire)
}

/// A reader's end.
pub(crate) struct Queue {
    pub(crate) service: Arc<RawService>,
    pub(crate) subscriber: RawSubscriber,
}

impl Queue {
    pub(crate) fn new(
        ground: &Ground,
        at: &Address,
        ty: &DataType,
        port: Shape,
        depth: usize,
    ) -> Result<Self, OpenError> {
        let service = open(ground, at, ty, port)?;
        let subscriber = service
            .subscriber_builder()
            .buffer_size(depth)
            .create()
            .map_err(|error| failed(at, &error.to_string()))?;
        Ok(Self { service, subscriber })
    }

    /// Whether the writer has joined.
    pub(crate) fn is_joined(&self) -> bool {
        self.service.dynamic_config().number_of_publishers() > 0
    }
}
