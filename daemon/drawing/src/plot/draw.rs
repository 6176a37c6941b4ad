//! Draws curves with dots of braille: two beside and four above each other in a character.

use genom_protocol::Address;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout};
use ratatui::style::{Color, Modifier, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Chart, Dataset, GraphType};
use serde_json::{Value, json};

use super::columns::{Columns, TIMES};
use crate::plain;

/// Colours of curves, one after the other.
const COLOURS: [Color; 6] =
    [Color::Cyan, Color::Yellow, Color::Magenta, Color::Green, Color::Blue, Color::Red];
/// Curves of different colours that are the same without any.
const NS: f64 = 1e9;

/// What is plotted, with all samples of its time.
#[derive(Debug)]
pub struct Plot {
    /// The time that it shows, in nanoseconds.
    pub span: u64,
    curves: Vec<Curve>,
    /// Date of the latest sample.
    end: u64,
    /// Documentation of ports, which has their units.
    pub docs: Vec<(String, String)>,
    /// Samples that the daemon could not record.
    pub lost: u64,
    /// Numbers that are not plotted, because there are too many.
    pub left_out: usize,
}

/// One number over time.
#[derive(Debug)]
pub struct Curve {
    name: String,
    columns: Columns,
}

impl Curve {
    /// The number at this path in the values of a port, without samples yet; `span` is that of the
    /// plot.
    #[must_use]
    pub fn new(port: &Address, path: &str, span: u64) -> Self {
        let name = if path.is_empty() { port.to_string() } else { format!("{port}.{path}") };
        Self { name, columns: Columns::new(span) }
    }
}

impl Plot {
    /// A plot of `span` nanoseconds without any curve.
    #[must_use]
    pub fn new(span: u64) -> Self {
        Self { span, curves: Vec::new(), end: 0, docs: Vec::new(), lost: 0, left_out: 0 }
    }

    /// Adds a curve; returns its index.
    pub fn add(&mut self, curve: Curve) -> usize {
        self.curves.push(curve);
        self.curves.len() - 1
    }

    /// Adds a sample to a curve, by its index.
    pub fn take(&mut self, curve: usize, date: u64, value: f64) {
        self.end = self.end.max(date);
        if let Some(curve) = self.curves.get_mut(curve) {
            curve.columns.add(date, value);
        }
    }

    /// The plot as data: of each curve `[SECONDS, LEAST, GREATEST]`, seconds before the last sample.
    #[must_use]
    pub fn data(&self) -> Value {
        let curves = self.curves.iter().map(|curve| {
            let fitted = curve.columns.fit(self.end, TIMES).into_iter();
            let points =
                fitted.map(|(at, range)| json!([self.second(at, TIMES), range.least, range.most]));
            let points: Vec<_> = points.collect();
            json!({"name": curve.name, "samples": curve.columns.count, "points": points})
        });
        json!({"curves": curves.collect::<Vec<_>>(), "lost": self.lost})
    }

    /// Time of a column, in seconds before the end.
    #[allow(clippy::cast_precision_loss, reason = "of a few thousand columns")]
    fn second(&self, column: usize, columns: usize) -> f64 {
        let span = self.span as f64 / NS;
        (column as f64 + 0.5) / columns as f64 * span - span
    }

    /// Draws what there is, with a line of help below.
    pub fn draw(&self, frame: &mut Frame<'_>, help: &str) {
        let captions = self.captions();
        let rows = u16::try_from(captions.len()).unwrap_or(u16::MAX);
        let [area, below, foot] = Layout::vertical([
            Constraint::Min(3),
            Constraint::Length(rows),
            Constraint::Length(u16::from(!help.is_empty())),
        ])
        .areas(frame.area());
        // Each character has two columns of dots.
        let columns = usize::from(area.width) * 2;
        let points: Vec<Vec<(f64, f64)>> =
            self.curves.iter().map(|curve| self.points(curve, columns.max(2))).collect();
        let all = points.iter().flatten().map(|(_, y)| *y);
        let (low, high) = all
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
        let (low, high) = scale(low, high);
        let datasets = points.iter().enumerate().map(|(index, points)| {
            Dataset::default()
                .marker(Marker::Braille)
                .graph_type(GraphType::Line)
                .style(Style::new().fg(colour(index)))
                .data(points)
        });
        #[allow(clippy::cast_precision_loss, reason = "a plot is not that long")]
        let span = self.span as f64 / NS;
        let seconds =
            [format!("-{} s", short(span)), format!("-{} s", short(span / 2.0)), "0 s".to_owned()];
        let values = (0..5).map(|step| short(low + (high - low) * f64::from(step) / 4.0));
        let axis = Style::new().add_modifier(Modifier::DIM);
        let chart = Chart::new(datasets.collect())
            .x_axis(Axis::default().bounds([-span, 0.0]).labels(seconds).style(axis))
            .y_axis(Axis::default().bounds([low, high]).labels(values).style(axis))
            .legend_position(None);
        frame.render_widget(chart, area);
        for (line, row) in captions.into_iter().zip(below.rows()) {
            frame.render_widget(line, row);
        }
        frame.render_widget(Line::styled(help.to_owned(), Modifier::DIM), foot);
    }

    /// Least and greatest value of each column, as one line.
    fn points(&self, curve: &Curve, columns: usize) -> Vec<(f64, f64)> {
        let (mut points, mut up) = (Vec::new(), true);
        for (column, range) in curve.columns.fit(self.end, columns) {
            let x = self.second(column, columns);
            // Every other column downwards, so that the line between two is short.
            let (first, second) =
                if up { (range.least, range.most) } else { (range.most, range.least) };
            points.push((x, first));
            if range.least < range.most {
                points.push((x, second));
                up = !up;
            }
        }
        points
    }

    /// What the curves are, with their last values; what the ports say of their units.
    fn captions(&self) -> Vec<Line<'static>> {
        let mut lines = Vec::new();
        for (index, curve) in self.curves.iter().enumerate() {
            let last = curve.columns.last.map_or_else(|| "no sample".to_owned(), short);
            let count = curve.columns.count;
            lines.push(Line::from(vec![
                Span::styled("━ ", Style::new().fg(colour(index))),
                Span::raw(format!("{} = {last}", curve.name)),
                Span::styled(format!("  {count} samples"), Modifier::DIM),
            ]));
        }
        if self.curves.is_empty() {
            lines.push(Line::raw("no sample yet"));
        }
        for (port, doc) in &self.docs {
            let doc = doc.lines().next().unwrap_or_default();
            lines.push(Line::styled(format!("{port}: {doc}"), Modifier::DIM));
        }
        if self.left_out > 0 {
            let told = format!("{} more numbers: name those to plot", self.left_out);
            lines.push(Line::styled(told, Modifier::DIM));
        }
        if self.lost > 0 {
            let told = format!("{} samples were lost: there were too many", self.lost);
            lines.push(Line::styled(told, Style::new().fg(Color::Red)));
        }
        lines
    }
}

fn colour(index: usize) -> Color {
    COLOURS[index % COLOURS.len()]
}

/// Bounds of the axis: round numbers around the values, and some room where there is only one.
fn scale(low: f64, high: f64) -> (f64, f64) {
    if !low.is_finite() || !high.is_finite() {
        return (0.0, 1.0);
    }
    let room = if high > low { high - low } else { (low.abs() * 0.1).max(1e-3) };
    let (low, high) = if high > low { (low, high) } else { (low - room, high + room) };
    // A tenth of the power of ten of the range.
    let step = 10_f64.powf((high - low).log10().floor()) / 10.0;
    ((low / step).floor() * step, (high / step).ceil() * step)
}

/// A number in at most nine characters.
fn short(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) {
        return format!("{value:.2e}");
    }
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// The plot as plain text, `width` columns wide and `height` lines high.
#[must_use]
pub fn text(plot: &Plot, width: u16, height: u16) -> String {
    plain::text(width, height, |frame| plot.draw(frame, ""))
}

#[cfg(test)]
mod tests {
    use expect_test::expect;

    use super::*;

    fn plot(values: impl Iterator<Item = f64>) -> Plot {
        let mut plot = Plot::new(10_000_000_000);
        let columns = Columns::new(plot.span);
        let curve = plot.add(Curve { name: "demo/position.velocity".to_owned(), columns });
        for (number, value) in (0_u64..).zip(values) {
            plot.take(curve, number * 1_000_000, value);
        }
        plot.docs.push(("demo/position".to_owned(), "Velocity in m/s.".to_owned()));
        plot
    }

    #[test]
    fn a_curve_is_drawn_with_its_scale() {
        let plot = plot((0..10_000).map(|number| (f64::from(number) / 1000.0).sin()));
        expect![[r#"
            1   │     ⣠⠴⠚⠉⠉⠳⣄⡀                          ⢀⡴⠚⠉⠉⠳⢤⡀
                │   ⢀⡴⠃      ⠹⣆                        ⣠⠋      ⠙⢦⡀
                │  ⢠⡞⠁        ⠈⢳⡀                    ⢀⡾⠁         ⠳⡄
            0.5 │ ⣰⠏            ⢧⡀                  ⣠⠟            ⢹⡀
                │⡼⠃              ⠳⡄                ⢰⠋              ⠹⣄
            0   │⠁                ⠻⣄              ⣠⠏                ⠸⣆
                │                  ⠙⣦            ⡴⠃                  ⠘⢧⡀
            -0.5│                   ⠈⣇         ⢀⡞⠁                    ⠈⠳
                │                    ⠈⠳⣄      ⣰⠋
            -1  │                      ⠈⠳⢤⣀⣀⡤⠞⠁
                └───────────────────────────────────────────────────────
            -10 s                         -5 s                       0 s
            ━ demo/position.velocity = -0.5432  10000 samples
            demo/position: Velocity in m/s.
        "#]]
        .assert_eq(&text(&plot, 60, 14));
    }

    /// One sample of ten thousand that is high is as high in every terminal.
    #[test]
    fn a_peak_is_seen_whatever_the_width() {
        let value = |number| if number == 7777 { 100.0 } else { 0.0 };
        let plot = plot((0..10_000).map(value));
        for width in [20, 40, 80, 200] {
            let drawn = text(&plot, width, 12);
            let top = drawn.lines().next().unwrap();
            assert!(top.contains("100"), "{drawn}");
            let dots = top.chars().filter(|c| ('\u{2801}'..='\u{28ff}').contains(c)).count();
            assert_eq!(dots, 1, "{drawn}");
        }
    }

    #[test]
    fn small_terminals_and_strange_numbers_are_drawn_somehow() {
        for values in
            [vec![], vec![f64::NAN], vec![1e300, -1e300], vec![5.0; 3], vec![f64::INFINITY]]
        {
            let plot = plot(values.into_iter());
            for (width, height) in [(1, 1), (3, 5), (200, 2), (20, 40)] {
                let _ = text(&plot, width, height);
            }
        }
    }

    #[test]
    fn numbers_are_short_and_scales_round() {
        let all = [0.0, -0.0, 1.0, 0.5, 12.345_678, -3.25e-7, 6.02e23].map(short);
        assert_eq!(all, ["0", "0", "1", "0.5", "12.3457", "-3.25e-7", "6.02e23"]);
        for ((low, high), wanted) in [
            ((0.0, 0.97), (0.0, 0.97)),
            ((0.03, 9.81), (0.0, 9.9)),
            ((-1.0, 1.0), (-1.0, 1.0)),
            ((5.0, 5.0), (4.5, 5.5)),
        ] {
            let (least, most) = scale(low, high);
            assert!(
                (least - wanted.0).abs() < 1e-9 && (most - wanted.1).abs() < 1e-9,
                "{least} {most}"
            );
        }
    }
}
