//! Streams of every sample of ports, in columns.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::Extension;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::response::sse::Event;
use genom_doors::{Events, Holder, Parameters, RpcError, Streams, Writer};
use genom_ports::dates::{Calendar, Dates};
use genom_ports::tape::Reel;
use genom_protocol::{Code, ColumnsOfPlot, Plot, PlotColumns, PlotParameters, Plots, StreamEnd};
use genom_supervisor::Supervisor;
use genom_supervisor::components::Hosted;
use genom_supervisor::recording::Watch;
use genom_types::{DataType, Leaf, Record, message};
use serde::Serialize;
use tokio::time::{MissedTickBehavior, interval};

use crate::columns::Columns;
use crate::named::{find, key};

/// How often tapes are emptied: they have room for a second of a port of 1 kHz.
const LOOK: Duration = Duration::from_millis(50);
/// A sample is on its tape at most this much after its date, unless its thread was preempted just
/// there; it counts for a later column then.
const LATEST: Duration = Duration::from_millis(2);
/// Numbers of a plot that are chosen if the client names none.
const USUAL: usize = 6;
/// Numbers of a port whose names are told.
const KNOWN: usize = 128;
/// A client that takes nothing for this long is given up.
const SLOWEST: Duration = Duration::from_secs(10);

/// Stream every sample of ports of a component, in columns.
///
/// Each parameter `plot` names a port, and the numbers of its values to plot, by default the first
/// six: `position`, `cameras/left#width,height`, `scan#ranges[17]`. Sends a server-sent event
/// `plots`, then `columns`: of each time as wide as a column, the first, the least, the greatest
/// and the last of all samples. Event `end` is sent when the component is unloaded. A reader that
/// is too slow misses columns, which are counted; one that reads nothing for 10 s is dropped.
#[utoipa::path(
    get,
    path = "/components/{component}/plots",
    tag = "ports",
    params(
        ("columns" = Option<f64>, Query, minimum = 0, maximum = 200, description =
            "Columns in a second, 30 by default: those that a plot has in a second of its width"),
        ("plot" = Vec<String>, Query, max_items = 64, description =
            "`PORT`, `PORT/ELEMENT`, each with `#NUMBER,NUMBER`")
    ),
    responses(
        (status = 200, content_type = "text/event-stream", body = String), (status = 404),
        (status = 422), (status = 503)
    )
)]
pub async fn plots(
    State(supervisor): State<Arc<Supervisor>>,
    State(streams): State<Streams>,
    Extension(holder): Extension<Holder>,
    Path(component): Path<String>,
    Parameters(query): Parameters<Vec<(String, String)>>,
) -> Result<Events, RpcError> {
    let (columns, wanted) = parse(query)?;
    let hosted = find(&supervisor.components, &component)?;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least 5 ms")]
    let width = (1e9 / columns) as u64;
    let drawn = wanted.iter().map(|text| Drawn::new(&hosted, text, width));
    let drawn = drawn.collect::<Result<Vec<_>, _>>()?;
    streams.open(&holder, move |writer| async move {
        let dates = Dates::of(&supervisor.clock);
        let calendar = dates.calendar();
        let sources = Vec::new();
        let feed = Feed { supervisor, hosted, writer, drawn, width, sources, dates, calendar };
        feed.run().await;
    })
}

/// Columns in a second, and what to plot.
fn parse(query: Vec<(String, String)>) -> Result<(f64, Vec<String>), RpcError> {
    let (mut columns, mut plots) = (PlotParameters::USUAL, Vec::new());
    for (name, value) in query {
        match name.as_str() {
            "columns" => columns = value.parse().unwrap_or(f64::NAN),
            "plot" => plots.push(value),
            _ => {
                let message = format!("`{name}` is neither `columns` nor `plot`");
                return Err(RpcError::new(StatusCode::BAD_REQUEST, Code::BadQuery, message));
            }
        }
    }
    if !(0.01..=PlotParameters::FASTEST).contains(&columns) {
        let most = PlotParameters::FASTEST;
        let message = format!("columns: at least 0.01 and at most {most} in a second");
        return Err(RpcError::bad_input(message).place("columns"));
    }
    let most = PlotParameters::MOST;
    if plots.is_empty() || plots.len() > most {
        let message = format!("{} plots: from 1 to {most} in a stream", plots.len());
        return Err(RpcError::bad_input(message).place("plot"));
    }
    Ok((columns, plots))
}

/// A plot of a port.
struct Drawn {
    address: String,
    ty: DataType,
    leaves: Vec<Leaf>,
    columns: Columns,
    /// Samples that tapes lost which are gone.
    lost: u64,
    /// Losses that were told.
    told: u64,
}

impl Drawn {
    /// `PORT`, `PORT/ELEMENT`, each with `#LEAF,LEAF`.
    fn new(hosted: &Hosted, text: &str, width: u64) -> Result<Self, RpcError> {
        let (port, leaves) = match text.rsplit_once('#') {
            Some((port, leaves)) => {
                (port, leaves.split(',').filter(|leaf| !leaf.is_empty()).collect())
            }
            None => (text, Vec::new()),
        };
        let (port, element) = match port.split_once('/') {
            Some((port, element)) => (port, Some(element.to_owned())),
            None => (port, None),
        };
        let key = key(hosted, port, element)?;
        let address = hosted.port_address(&key).to_string();
        let refused = |why: String| RpcError::bad_input(why).place("plot");
        let Some(ty) = hosted.port_type(key.port).cloned() else {
            return Err(RpcError::internal(format!("{address} has no type")));
        };
        if message::message_definition(&ty).is_none() {
            let why = "its type has native members, which only codels can read";
            return Err(refused(format!("{address} cannot be plotted: {why}")));
        }
        if leaves.len() > PlotParameters::LEAVES {
            let most = PlotParameters::LEAVES;
            return Err(refused(format!("{} numbers of {address}, {most} at most", leaves.len())));
        }
        let leaves = match leaves.is_empty() {
            true => Leaf::first(&ty, USUAL),
            false => {
                let found = leaves.into_iter().map(|leaf| Leaf::new(&ty, leaf));
                let found = found.collect::<Result<_, _>>();
                found.map_err(|error| refused(format!("{address}: {error}")))?
            }
        };
        if leaves.is_empty() {
            return Err(refused(format!("{address} has no numbers to plot")));
        }
        let columns = Columns::new(width, leaves.len());
        Ok(Self { address, ty, leaves, columns, lost: 0, told: 0 })
    }

    fn told(&self) -> Plot {
        let names = |leaves: &[Leaf]| leaves.iter().map(|leaf| leaf.name().to_owned()).collect();
        Plot {
            port: self.address.clone(),
            leaves: names(&self.leaves),
            known: names(&Leaf::first(&self.ty, KNOWN)),
        }
    }
}

/// What samples of a port come from, and the plots that show them.
struct Source {
    reel: Reel,
    record: Record,
    shown_in: Vec<usize>,
}

fn event(kind: &str, what: &impl Serialize) -> Event {
    Event::default().event(kind).data(serde_json::to_string(what).unwrap_or_default())
}

struct Feed {
    supervisor: Arc<Supervisor>,
    hosted: Arc<Hosted>,
    writer: Writer,
    drawn: Vec<Drawn>,
    width: u64,
    sources: Vec<Source>,
    dates: Dates,
    calendar: Calendar,
}

impl Feed {
    async fn run(mut self) {
        let plots = self.drawn.iter().map(Drawn::told).collect();
        let begun = event("plots", &Plots { plots, width_ns: self.width });
        if !self.writer.send(begun).await {
            return;
        }
        let ports = self.drawn.iter().map(|one| one.address.clone()).collect();
        let (supervisor, hosted) = (Arc::clone(&self.supervisor), Arc::clone(&self.hosted));
        let watching =
            tokio::task::spawn_blocking(move || Watching::begin(supervisor, &hosted, ports));
        let Ok(watching) = watching.await else { return };
        let mut ticks = interval(LOOK);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut waits: Option<Instant> = None;
        loop {
            tokio::select! {
                _ = ticks.tick() => {}
                () = self.writer.closed() => return,
                () = self.hosted.gone.raised() => {
                    let why = "the component was unloaded".to_owned();
                    self.writer.send(event("end", &StreamEnd { why })).await;
                    return;
                }
            }
            self.look(&watching);
            if !self.has_news() {
                waits = None;
            } else if self.writer.has_room() {
                waits = None;
                let news = event("columns", &self.news());
                if !self.writer.send(news).await {
                    return;
                }
            } else if waits.get_or_insert_with(Instant::now).elapsed() > SLOWEST {
                return;
            }
        }
    }

    /// Takes all samples until now.
    fn look(&mut self, watching: &Watching) {
        for (address, reel) in watching.take_new() {
            let all = self.drawn.iter().enumerate();
            let shown = all.filter(|(_, one)| one.address == address);
            let shown_in: Vec<_> = shown.map(|(at, _)| at).collect();
            let Some(first) = shown_in.first() else { continue };
            let record = Record::new(&self.drawn[*first].ty);
            self.sources.push(Source { reel, record, shown_in });
        }
        let moment = self.dates.moment();
        let (drawn, calendar) = (&mut self.drawn, self.calendar);
        self.sources.retain_mut(|Source { reel, record, shown_in }| {
            let over = reel.is_over();
            reel.wind(|sample| {
                if record.decode_message(sample.message).is_ok() {
                    let date = calendar.date(sample.moment);
                    for plot in shown_in.iter() {
                        let Drawn { columns, leaves, .. } = &mut drawn[*plot];
                        columns.add(date, |leaf| leaves[leaf].read(record));
                    }
                }
            });
            if over {
                shown_in.iter().for_each(|plot| drawn[*plot].lost += reel.lost());
            }
            !over
        });
        let latest = u64::try_from(LATEST.as_nanos()).unwrap_or_default();
        let date = self.calendar.date(moment).saturating_sub(latest);
        self.drawn.iter_mut().for_each(|one| one.columns.until(date));
    }

    /// Samples of each plot that were lost so far.
    fn lost(&self) -> BTreeMap<usize, u64> {
        let mut lost: BTreeMap<_, _> = self.drawn.iter().map(|one| one.lost).enumerate().collect();
        for source in &self.sources {
            for plot in &source.shown_in {
                *lost.entry(*plot).or_default() += source.reel.lost();
            }
        }
        lost
    }

    fn has_news(&self) -> bool {
        self.drawn.iter().any(|one| !one.columns.is_empty())
            || self.lost().iter().any(|(plot, lost)| self.drawn[*plot].told != *lost)
    }

    fn news(&mut self) -> PlotColumns {
        let lost = self.lost();
        let mut news = PlotColumns::default();
        for (plot, one) in self.drawn.iter_mut().enumerate() {
            let lost = lost.get(&plot).copied().unwrap_or_default();
            if !one.columns.is_empty() || one.told != lost {
                one.told = lost;
                news.plots.push(ColumnsOfPlot { plot, columns: one.columns.take(), lost });
            }
            news.skipped += one.columns.skipped();
        }
        news
    }
}

/// A watch that ends when it is dropped, however its stream ended.
struct Watching {
    supervisor: Arc<Supervisor>,
    component: String,
    watch: Option<Watch>,
}

impl Watching {
    /// Blocks while codels are excluded.
    fn begin(supervisor: Arc<Supervisor>, hosted: &Hosted, ports: Vec<String>) -> Self {
        let watch = Some(supervisor.watch_ports(hosted, ports));
        Self { supervisor, component: hosted.name.clone(), watch }
    }

    fn take_new(&self) -> Vec<(String, Reel)> {
        self.watch.as_ref().map(Watch::take_new).unwrap_or_default()
    }
}

impl Drop for Watching {
    fn drop(&mut self) {
        let Some(watch) = self.watch.take() else { return };
        let (supervisor, component) = (Arc::clone(&self.supervisor), self.component.clone());
        // Blocks while codels are excluded, which no thread of the control plane may.
        tokio::task::spawn_blocking(move || supervisor.unwatch_ports(&watch, &component));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(query: &[(&str, &str)]) -> Result<(f64, usize), RpcError> {
        let query = query.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned()));
        parse(query.collect()).map(|(columns, plots)| (columns, plots.len()))
    }

    #[test]
    fn a_stream_has_a_limited_number_of_plots_of_a_limited_number_of_columns() {
        assert_eq!(parsed(&[("plot", "a"), ("plot", "b")]).unwrap(), (PlotParameters::USUAL, 2));
        assert_eq!(parsed(&[("columns", "0.5"), ("plot", "a")]).unwrap(), (0.5, 1));
        for columns in ["0", "-1", "201", "NaN", "inf", "fast", ""] {
            assert!(parsed(&[("columns", columns), ("plot", "a")]).is_err(), "{columns}");
        }
        assert!(parsed(&[]).is_err());
        assert!(parsed(&vec![("plot", "a"); PlotParameters::MOST]).is_ok());
        assert!(parsed(&vec![("plot", "a"); PlotParameters::MOST + 1]).is_err());
        assert!(parsed(&[("plots", "a")]).is_err());
    }
}
