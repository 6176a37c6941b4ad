//! What a plugin logs through `tracing`, in the log of genomd.

use std::cell::Cell;
use std::fmt::{self, Write as _};

use genom_plugin_abi::table::level;
use tracing::field::{Field, Visit};
use tracing::level_filters::LevelFilter;
use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Level, Metadata, Subscriber};

use crate::given::Functions;

/// Passes events on to the host; spans are not told.
struct ToHost(Functions);

/// Has events of this library told to the host. The first backend that is opened does so; a library
/// that has a subscriber of its own keeps it.
pub(crate) fn to(functions: Functions) {
    let _ = tracing::subscriber::set_global_default(ToHost(functions));
}

impl Subscriber for ToHost {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        *metadata.level() <= Level::INFO && metadata.is_event()
    }

    fn max_level_hint(&self) -> Option<LevelFilter> {
        Some(LevelFilter::INFO)
    }

    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(1)
    }

    fn record(&self, _: &Id, _: &Record<'_>) {}

    fn record_follows_from(&self, _: &Id, _: &Id) {}

    fn event(&self, event: &Event<'_>) {
        // Where host and plugin are one program, in tests, the host's own events come here, too.
        let Some(_told) = Telling::begin() else { return };
        let mut line = Line::default();
        event.record(&mut line);
        let level = match *event.metadata().level() {
            Level::ERROR => level::ERROR,
            Level::WARN => level::WARN,
            _ => level::INFO,
        };
        self.0.log(level, &format!("{}{}", line.message, line.fields));
    }

    fn enter(&self, _: &Id) {}

    fn exit(&self, _: &Id) {}
}

thread_local! {
    static TELLS: Cell<bool> = const { Cell::new(false) };
}

/// While this thread tells the host something.
struct Telling;

impl Telling {
    fn begin() -> Option<Self> {
        (!TELLS.replace(true)).then_some(Self)
    }
}

impl Drop for Telling {
    fn drop(&mut self) {
        TELLS.set(false);
    }
}

#[derive(Default)]
struct Line {
    message: String,
    fields: String,
}

impl Visit for Line {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        // Writing into a string does not fail.
        let _ = match field.name() {
            "message" => write!(self.message, "{value:?}"),
            name => write!(self.fields, " {name}={value:?}"),
        };
    }
}
