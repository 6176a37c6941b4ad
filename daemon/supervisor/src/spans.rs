//! Spans of `tracing` for calls of services; subscribers may export them.

use tracing::Span;

use crate::outcome::Outcome;

/// Target of these spans.
pub const TARGET: &str = "genom::service";

/// The span of a call to a service; [`ended`] completes it.
pub fn service(component: &str, service: &str) -> Span {
    tracing::info_span!(
        target: "genom::service", "service", component, service,
        activity = tracing::field::Empty, exception = tracing::field::Empty,
    )
}

/// Sets the outcome of the service in its span, which lasts until it is dropped.
pub fn ended(span: &Span, activity: Option<u64>, outcome: &Outcome) {
    if let Some(number) = activity {
        span.record("activity", number);
    }
    if let Some(name) = outcome.exception() {
        span.record("exception", name);
    }
}
