//! Tables whose columns are as wide as their content, separated by two blanks. Cells are cut to fit
//! the terminal, except names, which users may want to copy.

use crate::escape;
use crate::terminal::{Terminal, Tone};

/// Rows under a header.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    /// One word per column.
    pub(crate) header: Vec<&'static str>,
    pub(crate) rows: Vec<Vec<String>>,
}

/// Columns with names that are arguments of other verbs: these are never cut.
const NAMES: [&str; 14] = [
    "ACTIVITY",
    "BACKEND",
    "COMPONENT",
    "CONNECTED",
    "CONTEXT",
    "DAEMON",
    "IN",
    "NAME",
    "OUT",
    "PORT",
    "SERVICE",
    "STATE",
    "TASK",
    "TOPIC",
];

/// Columns are not made narrower than this.
const NARROW: usize = 6;
const BETWEEN: usize = 2;

impl Table {
    /// The table as text; empty if it has no rows. Cut only if there is a terminal.
    pub(crate) fn text(&self, terminal: Terminal) -> String {
        if self.rows.is_empty() {
            return String::new();
        }
        // A cell is one line without control characters.
        let lines = |row: &Vec<String>| row.iter().map(|cell| escape::line(cell)).collect();
        let rows: Vec<Vec<String>> = self.rows.iter().map(lines).collect();
        Self { header: self.header.clone(), rows }.laid_out(terminal)
    }

    fn laid_out(&self, terminal: Terminal) -> String {
        let widths = self.widths(terminal.width);
        let head = self.header.iter().map(|&cell| cell.to_owned()).collect::<Vec<_>>();
        let mut out = String::new();
        for (rank, row) in std::iter::once(&head).chain(&self.rows).enumerate() {
            let mut line = String::new();
            for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
                let cut = cut(cell, *width);
                let blanks = width.saturating_sub(cut.chars().count()) + BETWEEN;
                let tone = Tone::of(cell).filter(|_| terminal.colour && self.tells(column));
                match tone {
                    _ if rank == 0 && terminal.colour => {
                        line.push_str(&format!("\x1b[1m{cut}\x1b[0m"));
                    }
                    Some(tone) => line.push_str(&tone.paint(&cut)),
                    None => line.push_str(&cut),
                }
                line.push_str(&" ".repeat(blanks));
            }
            out.push_str(line.trim_end());
            out.push('\n');
        }
        out
    }

    /// Whether a column holds states. Only these are coloured: a component named `failed` is not.
    fn tells(&self, column: usize) -> bool {
        self.header.get(column).is_some_and(|name| ["STATE", "STATUS"].contains(name))
    }

    fn widths(&self, most: Option<usize>) -> Vec<usize> {
        let mut widths: Vec<usize> = self.header.iter().map(|cell| cell.chars().count()).collect();
        for row in &self.rows {
            for (width, cell) in widths.iter_mut().zip(row) {
                *width = (*width).max(cell.chars().count());
            }
        }
        let Some(most) = most else { return widths };
        // The widest columns are narrowed first, until the line fits or all have the minimum width.
        let gives =
            |column: &usize| !self.header.get(*column).is_some_and(|name| NAMES.contains(name));
        loop {
            let line = widths.iter().sum::<usize>() + BETWEEN * (widths.len().saturating_sub(1));
            let Some(over) = line.checked_sub(most).filter(|over| *over > 0) else { return widths };
            let giving = (0..widths.len()).filter(gives);
            let Some(column) = giving.clone().max_by_key(|column| widths[*column]) else {
                return widths;
            };
            let widest = widths[column];
            if widest <= NARROW {
                return widths;
            }
            let next = giving.map(|column| widths[column]).filter(|width| *width < widest).max();
            let floor = next.unwrap_or(0).max(NARROW).min(widest - 1);
            widths[column] = widest.saturating_sub(over).max(floor);
        }
    }
}

/// The text, with a sign in place of its end if it is too long.
fn cut(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    let mut cut: String = text.chars().take(width.saturating_sub(1)).collect();
    cut.push('~');
    cut
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    fn table() -> Table {
        let row = |cells: [&str; 3]| cells.map(str::to_owned).to_vec();
        Table {
            header: vec!["NAME", "STATE", "LIBRARY"],
            rows: vec![
                row(["demo", "running", "/a/long/way/to/the/library/of/demo.so"]),
                row(["running", "failed", "x.so"]),
            ],
        }
    }

    #[test]
    fn columns_line_up() {
        expect![[r"
            NAME     STATE    LIBRARY
            demo     running  /a/long/way/to/the/library/of/demo.so
            running  failed   x.so
        "]]
        .assert_eq(&table().text(Terminal::default()));
    }

    #[test]
    fn a_table_fits_the_terminal_as_far_as_names_let_it() {
        for width in [20, 24, 30, 40, 56, 80] {
            let text = table().text(Terminal { width: Some(width), colour: false });
            for line in text.lines() {
                assert!(line.chars().count() <= width.max(24), "{width}: {line}");
            }
        }
        expect![[r"
            NAME     STATE    LIBRARY
            demo     running  /a/long/way~
            running  failed   x.so
        "]]
        .assert_eq(&table().text(Terminal { width: Some(30), colour: false }));
    }

    #[test]
    fn names_stay_whole() {
        let long = "left/a_port_with_a_name_that_is_longer_than_any_terminal_is_wide".to_owned();
        let table = Table {
            header: vec!["PORT", "TYPE", "VALUE"],
            rows: vec![vec![
                long.clone(),
                "::a::type::of::it".to_owned(),
                "[1,2,3,4,5]".to_owned(),
            ]],
        };
        let text = table.text(Terminal { width: Some(40), colour: false });
        let row = text.lines().nth(1).unwrap();
        assert_eq!(row, format!("{long}  ::a::~  [1,2,~"));
    }

    #[test]
    fn only_what_tells_how_things_are_is_coloured() {
        let text = table().text(Terminal { width: None, colour: true });
        assert!(text.contains("\x1b[32mrunning\x1b[0m  /a"), "{text:?}");
        assert!(text.contains("\nrunning  \x1b[31mfailed\x1b[0m"), "{text:?}");
    }
}
