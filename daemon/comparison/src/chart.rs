//! A comparison as a drawing (SVG), readable on light and dark backgrounds: bars of one metric under
//! each other, one for each way.

use std::fmt::Write as _;

use genom_drawing::xml::escaped;

use crate::report::{ConnectionReport, Report, WayReport, short};

/// Measures of the drawing, in its units: pixels unless it is scaled.
const WIDTH: f64 = 900.0;
const NAMES: f64 = 230.0;
const VALUES: f64 = 170.0;
const ROW: f64 = 22.0;
const TITLE: f64 = 40.0;
const MARGIN: f64 = 16.0;

/// Colours by role. A background of its own would not fit every page.
const STYLE: &str = "\
text{font:13px system-ui,sans-serif;fill:#222}\
.title{font-weight:600}.note{fill:#666}\
.half{fill:#2f6fb3}.most{fill:#2f6fb3;opacity:.35}.floor{stroke:#b3541e;stroke-width:2}\
@media(prefers-color-scheme:dark){text{fill:#ddd}.note{fill:#999}\
.half,.most{fill:#6aa9e9}.floor{stroke:#f0955a}}";

/// One bar.
struct Bar {
    name: String,
    /// Length of the bar, and that of the paler one behind it.
    value: f64,
    behind: Option<f64>,
    /// Where a line marks the floor.
    floor: Option<f64>,
    told: String,
}

/// The report as the text of an SVG file.
#[must_use]
pub fn svg(report: &Report) -> String {
    let mut body = String::new();
    let mut y = MARGIN + 14.0;
    text(&mut body, MARGIN, y, "title", &format!("{}: middlewares compared", report.deployment));
    y += 20.0;
    let how = format!(
        "{}, {} processors, {} s x {}; {}",
        report.genomd,
        report.processors,
        report.seconds,
        report.runs,
        if report.isolated { "each component in a process of its own" } else { "as deployed" },
    );
    text(&mut body, MARGIN, y, "note", &how);
    for (title, bars) in panels(report) {
        y = panel(&mut body, y, &title, &bars);
    }
    for way in report.ways.iter().filter(|way| way.error.is_some()) {
        y += ROW;
        let why = way.error.as_deref().unwrap_or_default();
        text(&mut body, MARGIN, y, "note", &format!("{}: {why}", way.way));
    }
    let height = y + MARGIN;
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height:.0}\" \
         width=\"{WIDTH}\" height=\"{height:.0}\" role=\"img\">\n<style>{STYLE}</style>\n\
         {body}</svg>\n"
    )
}

/// What is drawn: hops and rates of each connection, then what the processes take.
fn panels(report: &Report) -> Vec<(String, Vec<Bar>)> {
    let mut inports: Vec<&str> = Vec::new();
    for one in report.ways.iter().flat_map(|way| &way.connections) {
        if !inports.contains(&one.inport.as_str()) {
            inports.push(&one.inport);
        }
    }
    let mut panels = Vec::new();
    for inport in &inports {
        let of = |bar: fn(&WayReport, &ConnectionReport) -> Option<Bar>| {
            let each = report.ways.iter().filter_map(|way| {
                let one = way.connections.iter().find(|one| one.inport == *inport)?;
                bar(way, one)
            });
            each.collect::<Vec<_>>()
        };
        let title = "hop in us: median, paler 99th percentile; line: bare middleware";
        panels.push((format!("{inport}, {title}"), of(hop)));
        panels.push((format!("{inport}, samples read a second; paler: written"), of(rate)));
    }
    let each = |value: fn(&WayReport) -> Option<f64>, unit: &str| {
        let bar = |way: &WayReport| {
            let value = value(way)?;
            let (name, told) = (way.way.clone(), format!("{} {unit}", short(value)));
            Some(Bar { name, value, behind: None, floor: None, told })
        };
        report.ways.iter().filter_map(bar).collect::<Vec<_>>()
    };
    panels.push((
        "processor time, 100 % is one processor".to_owned(),
        each(|way| way.cpu_percent, "%"),
    ));
    #[allow(clippy::cast_precision_loss, reason = "a few digits are shown")]
    let memory = |way: &WayReport| way.memory_bytes.map(|bytes| bytes as f64 / 1e6);
    panels.push(("memory of all processes".to_owned(), each(memory, "MB")));
    panels.retain(|(_, bars)| !bars.is_empty());
    panels
}

fn hop(way: &WayReport, one: &ConnectionReport) -> Option<Bar> {
    let hop = one.hop_us?;
    Some(Bar {
        name: way.way.clone(),
        value: hop.p50,
        behind: Some(hop.p99),
        floor: one.floor_us.map(|floor| floor.hop.p50),
        told: format!("{} / {}", short(hop.p50), short(hop.p99)),
    })
}

fn rate(way: &WayReport, one: &ConnectionReport) -> Option<Bar> {
    let dropped = match one.dropped() {
        0 => String::new(),
        count => format!(", {count} dropped"),
    };
    Some(Bar {
        name: way.way.clone(),
        value: one.read_hz,
        behind: one.written_hz,
        floor: None,
        told: format!("{}{dropped}", short(one.read_hz)),
    })
}

/// Draws a panel below `y`, and returns where it ends.
fn panel(body: &mut String, mut y: f64, title: &str, bars: &[Bar]) -> f64 {
    y += TITLE;
    text(body, MARGIN, y, "title", title);
    let reach = |bar: &Bar| {
        [Some(bar.value), bar.behind, bar.floor].into_iter().flatten().fold(0.0, f64::max)
    };
    let longest = bars.iter().map(reach).fold(f64::MIN_POSITIVE, f64::max);
    let scale = (WIDTH - NAMES - VALUES - 2.0 * MARGIN) / longest;
    let left = MARGIN + NAMES;
    for bar in bars {
        y += ROW;
        text(body, MARGIN, y, "name", &bar.name);
        let mut rectangle = |class: &str, value: f64| {
            let (width, top) = ((value * scale).max(1.0), y - 12.0);
            let _ = writeln!(
                body,
                "<rect class=\"{class}\" x=\"{left}\" y=\"{top:.1}\" width=\"{width:.1}\" \
                 height=\"15\"/>"
            );
        };
        bar.behind.into_iter().for_each(|value| rectangle("most", value));
        rectangle("half", bar.value);
        if let Some(floor) = bar.floor {
            let (x, top, bottom) = (left + floor * scale, y - 15.0, y + 6.0);
            let _ = writeln!(
                body,
                "<line class=\"floor\" x1=\"{x:.1}\" y1=\"{top:.1}\" x2=\"{x:.1}\" y2=\"{bottom:.1}\"/>"
            );
        }
        text(body, left + reach(bar) * scale + 8.0, y, "value", &bar.told);
    }
    y
}

fn text(body: &mut String, x: f64, y: f64, class: &str, content: &str) {
    let content = escaped(content);
    let _ = writeln!(body, "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\">{content}</text>");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::report;

    #[test]
    fn every_metric_of_every_way_has_a_bar_within_the_drawing() {
        let drawn = svg(&report());
        // One way with one connection: hop and rate with a paler bar each, processor, memory.
        assert_eq!(drawn.matches("<rect ").count(), 2 + 2 + 1 + 1);
        assert_eq!(drawn.matches("<line ").count(), 1);
        assert!(drawn.contains(">3.00 / 3.00<") && drawn.contains(">ros2: no network<"), "{drawn}");
        for piece in drawn.split("<rect ").skip(1) {
            let number = |key: &str| -> f64 {
                let rest = piece.split(&format!("{key}=\"")).nth(1).unwrap();
                rest.split('"').next().unwrap().parse().unwrap()
            };
            assert!(number(" x") + number("width") <= WIDTH, "{piece}");
        }
    }

    #[test]
    fn names_are_no_markup() {
        let mut report = report();
        report.deployment = "<a&b>\u{1}.toml".to_owned();
        let drawn = svg(&report);
        assert!(drawn.contains("&lt;a&amp;b&gt; .toml"), "{drawn}");
    }
}
