//! The log: written to standard error, and the latest entries kept for supervisors.

use std::fmt::Write as _;
use std::io::IsTerminal as _;
use std::sync::LazyLock;
use std::time::{SystemTime, UNIX_EPOCH};

use genom_host::StandardError;
use genom_ports::dates::Dates;
use genom_protocol::{Level as Grade, LogEntry};
use genom_supervisor::bus::Numbers;
use tracing::field::{Field, Visit};
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::filter::{LevelFilter, ParseError, filter_fn};
use tracing_subscriber::layer::{Context, SubscriberExt as _};
use tracing_subscriber::util::{SubscriberInitExt as _, TryInitError};
use tracing_subscriber::{EnvFilter, Layer};

/// The crates that a filter for `genomd` includes: to users they are one program.
const PARTS: [&str; 11] = [
    "genomd",
    "genom_cells",
    "genom_systemd",
    "genom_telemetry",
    "genom_doors",
    "genom_web",
    "genom_supervisor",
    "genom_ports",
    "genom_plugin_host",
    "genom_registry",
    "genom_configuration",
];

/// The latest entries. There is one log per process.
static PAST: LazyLock<Numbers> = LazyLock::new(|| Numbers::new(Dates::default()));

/// The latest entries, to which listeners can subscribe.
pub fn past() -> &'static Numbers {
    &PAST
}

/// Levels of libraries that log too much. RustDDS logs each packet that it cannot send yet, also as
/// errors; actual failures are reported by those who use it. zenoh warns about intended settings:
/// Unix sockets without a name, and no gossip between them. A filter that names these modules
/// overrides this. Spans of services go to a collector only.
const QUIET: &str = "rustdds=off,zenoh_link_unixsock_stream=error,\
                     zenoh::net::routing::hat::peer=error,genom::service=off";

/// Why logging could not be started.
#[derive(Debug, thiserror::Error)]
pub enum LogsError {
    /// The filter is none.
    #[error("--log {filter}: {source}; write for instance info,genomd=debug")]
    Filter {
        /// The filter.
        filter: String,
        /// What is wrong with it.
        source: ParseError,
    },
    /// Another logger is installed in the process.
    #[error(transparent)]
    Taken(#[from] TryInitError),
}

/// Starts logging. With `spans`, spans of services are exported, whatever the filter of the log.
///
/// # Errors
/// The filter is none, or another logger is installed.
pub fn start(filter: &str, spans: bool) -> Result<(), LogsError> {
    let passes = || {
        EnvFilter::try_new(format!("{QUIET},{}", of_all_parts(filter)))
            .map_err(|source| LogsError::Filter { filter: filter.to_owned(), source })
    };
    let ours = filter_fn(crate::is_ours).with_max_level_hint(LevelFilter::INFO);
    let terminal = tracing_subscriber::fmt::layer()
        // Codels may have redirected descriptor 2, or a client's connection may have it.
        .with_writer(StandardError::get)
        .with_ansi(std::io::stderr().is_terminal())
        .with_target(false);
    tracing_subscriber::registry()
        .with(terminal.with_filter(passes()?))
        .with(Keep.with_filter(passes()?))
        .with(spans.then(|| crate::Exported.with_filter(ours)))
        .try_init()?;
    Ok(())
}

/// Extends what a filter says about `genomd` to all of its crates.
fn of_all_parts(filter: &str) -> String {
    let words = filter.split(',').flat_map(|word| match word.trim().strip_prefix("genomd") {
        // A part with brackets (a span or field, which may contain commas) is left unchanged.
        Some(rest) if rest.starts_with(['=', ':']) || rest.is_empty() => {
            PARTS.iter().map(|part| format!("{part}{rest}")).collect()
        }
        _ => vec![word.to_owned()],
    });
    words.collect::<Vec<_>>().join(",")
}

/// A layer that keeps the entries that pass the filter.
struct Keep;

impl<S: Subscriber> Layer<S> for Keep {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let mut words = Words::default();
        event.record(&mut words);
        let about = event.metadata();
        PAST.add(&LogEntry {
            time: now(),
            level: grade(*about.level()),
            origin: about.target().to_owned(),
            file: about.file().map(ToOwned::to_owned),
            line: about.line(),
            component: words.component,
            message: words.message + &words.rest,
        });
    }
}

/// Seconds since 1970.
fn now() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64()
}

/// An entry that stands for those a reader missed.
pub fn missed(count: u64) -> LogEntry {
    let message = format!("{count} entries before this one are not kept any more");
    LogEntry {
        time: now(),
        level: Grade::Warn,
        origin: "genomd".to_owned(),
        file: None,
        line: None,
        component: None,
        message,
    }
}

fn grade(level: Level) -> Grade {
    match level {
        Level::ERROR => Grade::Error,
        Level::WARN => Grade::Warn,
        Level::INFO => Grade::Info,
        Level::DEBUG => Grade::Debug,
        Level::TRACE => Grade::Trace,
    }
}

/// The fields of an event: the message, the component it is about, and the others as `key=value`.
#[derive(Default)]
struct Words {
    message: String,
    component: Option<String>,
    rest: String,
}

impl Visit for Words {
    fn record_str(&mut self, field: &Field, value: &str) {
        match field.name() {
            "instance" => self.component = Some(value.to_owned()),
            _ => self.record_debug(field, &value),
        }
    }

    fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
        let _ = match field.name() {
            "message" => write!(self.message, "{value:?}"),
            // Logged with `%`.
            "instance" => {
                self.component = Some(format!("{value:?}"));
                Ok(())
            }
            name => write!(self.rest, " {name}={value:?}"),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_filter_says_of_the_daemon_holds_for_all_its_crates() {
        let all = of_all_parts("info,genomd=debug");
        for part in PARTS {
            assert!(all.split(',').any(|word| word == format!("{part}=debug")), "{all}");
        }
        assert!(of_all_parts("genomd::loading=trace").contains("genom_supervisor::loading=trace"));
        for other in ["info", "genom_ros2=debug", "genomd[span{a=1,b=2}]=info", "genomdx=info"] {
            assert_eq!(of_all_parts(other), other);
        }
    }

    #[test]
    fn an_entry_names_its_component_and_level() {
        let logger = tracing_subscriber::registry().with(Keep);
        let here = tracing::subscriber::with_default(logger, || {
            tracing::warn!(instance = "arm", task = "main", "cannot run on {}", 3);
            line!() - 1
        });
        let kept = past().listen(Some(0)).take_past();
        let mine = |entry: &&genom_supervisor::bus::Numbered| entry.data["component"] == "arm";
        let entry = kept.iter().find(mine).expect("it was kept");
        assert_eq!(entry.data["level"], "warn");
        assert_eq!(entry.data["message"], "cannot run on 3 task=\"main\"");
        assert_eq!((&entry.data["file"], &entry.data["line"]), (&file!().into(), &here.into()));
    }
}
