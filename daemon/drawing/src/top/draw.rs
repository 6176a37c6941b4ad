//! Draws a snapshot: tasks, activities, ports, as many as fit.

use genom_protocol::Status;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::Line;
use ratatui::widgets::{Row, Table};

use super::snapshot::Snapshot;
use super::trend::Trends;
use crate::plain;
use crate::units::duration;

/// Maximum number of activities drawn.
const ACTIVITIES: usize = 8;

/// Draws the table; `scroll` is the number of ports left out at the top.
pub fn draw(
    frame: &mut Frame<'_>,
    now: &Snapshot,
    before: Option<&Snapshot>,
    trends: &Trends,
    scroll: usize,
    help: &str,
) {
    let [title, tasks, activities, ports, foot] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Length(height(now.tasks().count())),
        Constraint::Length(height(now.activities().len().min(ACTIVITIES))),
        Constraint::Min(1),
        Constraint::Length(u16::from(!help.is_empty())),
    ])
    .areas(frame.area());
    let activities_now = now.activities();
    let running = activities_now.iter().filter(|(_, one)| one.status == Status::Running).count();
    let wrong = now.components.iter().map(|one| &one.component).filter_map(|one| {
        let is = if one.state.starts_with("stuck") { "is " } else { "" };
        let wrong = !is.is_empty() || one.state.starts_with("spins");
        wrong.then(|| format!("{} {is}{}; ", one.name, one.state))
    });
    let broken = now.components.iter().map(|one| &one.component).filter_map(|one| {
        let rules = one.supervision.iter().filter(|rule| rule.violations > 0).count();
        let rules = if rules == 1 { "a rule".to_owned() } else { format!("{rules} rules") };
        let any = one.supervision.iter().any(|rule| rule.violations > 0);
        any.then(|| format!("{} broke {rules}; ", one.name))
    });
    let stuck: String = wrong.chain(broken).collect();
    // Problems come first, because the line may be cut.
    let text = format!(
        "{stuck}genomd on {}: {}, {running} running",
        now.daemon,
        if now.components.len() == 1 {
            "1 component".to_owned()
        } else {
            format!("{} components", now.components.len())
        },
    );
    let style = alarm(!stuck.is_empty()).add_modifier(Modifier::BOLD);
    frame.render_widget(Line::styled(text, style), title);
    draw_tasks(frame, tasks, now);
    draw_activities(frame, activities, now);
    draw_ports(frame, ports, now, before, trends, scroll);
    frame.render_widget(Line::styled(help, Modifier::DIM), foot);
}

/// Column of ports that has their rates; sparklines are beside it.
const RATE: usize = 3;

/// Height of a table: rows, header, and an empty line above.
fn height(rows: usize) -> u16 {
    u16::try_from(rows + 2).unwrap_or(u16::MAX)
}

fn alarm(bad: bool) -> Style {
    if bad { Style::new().fg(Color::Red) } else { Style::new() }
}

/// A row: its cells and its style.
type Cells = (Vec<String>, Style);

/// Draws the rows from `scroll` on. Columns with a minimum width ([`Constraint::Min`]) are names,
/// which users may want to copy: these are never cut in favour of other columns.
fn table(
    frame: &mut Frame<'_>,
    area: Rect,
    header: &[&str],
    rows: Vec<Cells>,
    scroll: usize,
    widths: &[Constraint],
) {
    let below = Rect { y: area.y + 1, height: area.height.saturating_sub(1), ..area };
    let header = Row::new(header.iter().map(|&cell| cell.to_owned()))
        .style(Style::new().add_modifier(Modifier::REVERSED));
    let whole = |(column, width): (usize, &Constraint)| match *width {
        Constraint::Min(least) => {
            let cells = rows.iter().filter_map(|(cells, _)| cells.get(column));
            let longest = cells.map(|name| Line::raw(name.as_str()).width()).max().unwrap_or(0);
            Constraint::Min(u16::try_from(longest).unwrap_or(u16::MAX).max(least))
        }
        other => other,
    };
    let widths: Vec<Constraint> = widths.iter().enumerate().map(whole).collect();
    let rows = rows.into_iter().skip(scroll).map(|(cells, style)| Row::new(cells).style(style));
    frame.render_widget(Table::new(rows, widths).header(header).column_spacing(2), below);
}

fn draw_tasks(frame: &mut Frame<'_>, area: Rect, now: &Snapshot) {
    let rows = now.tasks().map(|(component, task)| {
        let period = task.period_ns.map_or_else(|| "-".to_owned(), duration);
        let late = task.period_ns.is_some_and(|period| task.cycles.max_ns > period);
        let cells = vec![
            format!("{component}/{}", task.name),
            period,
            if task.real_time { "yes" } else { "no" }.to_owned(),
            task.cycles.count.to_string(),
            task.overruns.to_string(),
            duration(task.cycles.mean_ns),
            duration(task.cycles.max_ns),
            duration(task.lateness.p99_ns),
        ];
        (cells, alarm(task.overruns > 0 || late))
    });
    let header = ["TASK", "PERIOD", "RT", "CYCLES", "OVERRUNS", "WORK", "LONGEST", "LATE P99"];
    let widths = [16, 10, 3, 9, 8, 10, 10, 10].map(Constraint::Length);
    let widths = [&[Constraint::Min(16)], &widths[1..]].concat();
    table(frame, area, &header, rows.collect(), 0, &widths);
}

fn draw_activities(frame: &mut Frame<'_>, area: Rect, now: &Snapshot) {
    let rows = now.activities().into_iter().map(|(component, one)| {
        let exception = one.outcome.exception.clone();
        let style = alarm(exception.is_some());
        let state = exception.or_else(|| one.state.clone()).unwrap_or_default();
        let name = format!("{component}/{}", one.service);
        (vec![name, one.activity.to_string(), one.status.to_string(), state], style)
    });
    let widths =
        [Constraint::Min(16), Constraint::Length(8), Constraint::Length(10), Constraint::Fill(2)];
    table(frame, area, &["ACTIVITY", "NUMBER", "STATUS", "STATE"], rows.collect(), 0, &widths);
}

fn draw_ports(
    frame: &mut Frame<'_>,
    area: Rect,
    now: &Snapshot,
    before: Option<&Snapshot>,
    trends: &Trends,
    scroll: usize,
) {
    let lines = trends.say_something();
    let rows = now.ports.iter().map(|port| {
        let rate = before.and_then(|before| now.rate(port, before));
        let dash = || "-".to_owned();
        let dropped = port.traffic.map_or(0, |traffic| traffic.dropped);
        let mut cells = vec![
            port.address.clone(),
            port.direction.to_string(),
            port.over.clone().unwrap_or_else(|| port.backend.to_string()),
            rate.map_or_else(dash, |rate| format!("{rate:.1} Hz")),
            port.traffic.map_or_else(dash, |traffic| traffic.samples.to_string()),
            dropped.to_string(),
            port.connected.clone().unwrap_or_else(dash),
        ];
        if lines {
            cells.insert(RATE + 1, trends.line(&port.address));
        }
        (cells, alarm(dropped > 0))
    });
    let mut widths = vec![
        Constraint::Min(20),
        Constraint::Length(3),
        Constraint::Length(10),
        Constraint::Length(10),
        Constraint::Length(9),
        Constraint::Length(7),
        Constraint::Min(9),
    ];
    let mut header = vec!["PORT", "DIR", "BACKEND", "RATE", "SAMPLES", "DROPPED", "CONNECTED"];
    if lines {
        widths.insert(RATE + 1, Constraint::Length(20));
        header.insert(RATE + 1, "LATELY");
    }
    table(frame, area, &header, rows.collect(), scroll, &widths);
}

/// The whole table as plain text, `width` columns wide.
#[must_use]
pub fn text(now: &Snapshot, before: Option<&Snapshot>, width: u16) -> String {
    let activities = now.activities().len().min(ACTIVITIES);
    let rows = [now.tasks().count(), activities, now.ports.len()];
    let all: u16 = rows.iter().map(|&rows| height(rows)).sum();
    plain::text(width, all + 1, |frame| draw(frame, now, before, &Trends::default(), 0, ""))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::top::Seen;
    use expect_test::expect;
    use genom_protocol::{
        Activity, BackendNames, Component, Counts, Durations, Outcome, Port, PortDirection,
        TaskStatistics,
    };
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;
    use std::time::{Duration, Instant};

    fn durations(ns: u64) -> Durations {
        Durations {
            count: 900,
            last_ns: ns,
            mean_ns: ns,
            p50_ns: ns,
            p99_ns: ns,
            min_ns: ns,
            max_ns: ns,
        }
    }

    fn snapshot(samples: u64, taken: Instant) -> Snapshot {
        let task = TaskStatistics {
            name: "main".into(),
            period_ns: Some(5_000_000),
            real_time: false,
            cycles: durations(900),
            lateness: durations(85_000),
            overruns: 3,
            stuck: None,
            unpaused: None,
        };
        let activity = Activity {
            activity: 2,
            service: "goto".into(),
            status: Status::Running,
            state: Some("main".into()),
            outcome: Outcome::default(),
        };
        let port = |address: &str, direction, connected: Option<&str>, traffic| Port {
            address: address.into(),
            name: String::new(),
            direction,
            multiple: false,
            ty: "double".into(),
            digest: None,
            doc: None,
            value: None,
            backend: BackendNames::one("shm"),
            connected: connected.map(str::to_owned),
            over: None,
            traffic,
        };
        let component = Component {
            cell: None,
            name: "demo".into(),
            component: "demo".into(),
            state: "running".into(),
            stuck: Vec::new(),
            spins: Vec::new(),
            backend: BackendNames::one("shm"),
            port_backends: Default::default(),
            library: "demo.so".into(),
            notes: Vec::new(),
            activities: 1,
            supervision: Vec::new(),
            remotes: Vec::new(),
        };
        let passed = Counts { samples, ..Counts::default() };
        Snapshot {
            daemon: "/run/genomd.sock".into(),
            components: vec![Seen { component, tasks: vec![task], log: vec![activity] }],
            ports: vec![
                port("demo/position", PortDirection::Out, None, Some(passed)),
                port("demo/parameter", PortDirection::In, Some("joystick/gain"), None),
            ],
            taken,
        }
    }

    #[test]
    fn tasks_activities_and_ports_are_drawn_with_their_rates() {
        let begin = Instant::now();
        let before = snapshot(100, begin);
        let now = snapshot(500, begin + Duration::from_secs(2));
        expect![[r#"
            genomd on /run/genomd.sock: 1 component, 1 running

            TASK                        PERIOD      RT   CYCLES     OVERRUNS  WORK        LONGEST     LATE P99
            demo/main                   5.000 ms    no   900        3         900 ns      900 ns      85.000 us

            ACTIVITY                   NUMBER    STATUS      STATE
            demo/goto                  2         running     main

            PORT                       DIR  BACKEND     RATE        SAMPLES    DROPPED  CONNECTED
            demo/position              out  shm         200.0 Hz    500        0        -
            demo/parameter             in   shm         -           -          0        joystick/gain
        "#]]
        .assert_eq(&text(&now, Some(&before), 100));
    }

    #[test]
    fn each_port_has_a_line_of_its_rates_once_there_are_some() {
        let begin = Instant::now();
        let at = |second| snapshot(100 * second, begin + Duration::from_secs(second));
        let mut trends = Trends::default();
        trends.add(&at(1), &at(0));
        let shown = |trends: &Trends| {
            let mut terminal = Terminal::new(TestBackend::new(120, 14)).unwrap();
            terminal.draw(|frame| draw(frame, &at(3), None, trends, 0, "")).unwrap();
            let buffer = terminal.backend().buffer();
            buffer.content().iter().map(|cell| cell.symbol()).collect::<String>()
        };
        assert!(!shown(&trends).contains("LATELY"));
        trends.add(&at(2), &at(2));
        trends.add(&snapshot(250, begin + Duration::from_secs(3)), &at(2));
        assert!(
            shown(&trends).contains("LATELY") && shown(&trends).contains("█▅"),
            "{}",
            shown(&trends)
        );
    }

    #[test]
    fn names_stay_whole_where_the_screen_is_narrow_and_other_columns_give_room() {
        let mut now = snapshot(1, Instant::now());
        let long = "left_arm_controller/references/joint_positions";
        now.ports[0].address = long.into();
        let told = text(&now, None, 80);
        assert!(told.contains(long), "{told}");
        assert!(told.contains("joystick/gain"), "{told}");
    }

    #[test]
    fn a_component_that_is_stuck_is_told_in_the_title_in_red() {
        let mut now = snapshot(1, Instant::now());
        now.components[0].component.state = "stuck in demo_move for 12 s".into();
        let told = "demo is stuck in demo_move for 12 s; genomd on ";
        assert!(text(&now, None, 100).starts_with(told));
        let mut terminal = Terminal::new(TestBackend::new(100, 12)).unwrap();
        terminal.draw(|frame| draw(frame, &now, None, &Trends::default(), 0, "")).unwrap();
        assert_eq!(terminal.backend().buffer()[(0, 0)].fg, Color::Red);
    }

    #[test]
    fn a_component_that_broke_rules_is_told_in_the_title() {
        let mut now = snapshot(1, Instant::now());
        let rule = |violations| genom_protocol::Rule {
            rule: "codel demo_servo takes more than 2 ms".into(),
            kind: genom_protocol::Kind::Deadline,
            reactions: vec!["event".into()],
            violations,
            last: None,
        };
        now.components[0].component.supervision = vec![rule(7), rule(0), rule(1)];
        assert!(text(&now, None, 100).starts_with("demo broke 2 rules; genomd on "));
        now.components[0].component.supervision = vec![rule(7), rule(0)];
        assert!(text(&now, None, 100).starts_with("demo broke a rule; genomd on "));
    }

    #[test]
    fn a_missed_tick_is_drawn_in_red_and_a_small_screen_cuts_without_failing() {
        let now = snapshot(1, Instant::now());
        let mut terminal = Terminal::new(TestBackend::new(80, 12)).unwrap();
        terminal.draw(|frame| draw(frame, &now, None, &Trends::default(), 1, "q quits")).unwrap();
        let buffer = terminal.backend().buffer();
        assert_eq!(buffer[(0, 3)].symbol(), "d");
        assert_eq!(buffer[(0, 3)].fg, Color::Red);
        assert_eq!(buffer[(0, 6)].fg, Color::Reset);
        // Scrolled: the first port is not visible.
        let shown: String = buffer.content().iter().map(|cell| cell.symbol()).collect();
        assert!(!shown.contains("demo/position") && shown.contains("demo/parameter"), "{shown}");
        for (width, height) in [(1, 1), (3, 5), (200, 2), (20, 40)] {
            let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
            terminal
                .draw(|frame| draw(frame, &now, None, &Trends::default(), 99, "q quits"))
                .unwrap();
        }
    }
}
