//! What is drawn for a terminal, as plain text.

use ratatui::backend::TestBackend;
use ratatui::{Frame, Terminal};

/// What `draw` draws into a terminal of this many columns and lines, without colours.
pub(crate) fn text(width: u16, height: u16, draw: impl FnOnce(&mut Frame<'_>)) -> String {
    // This backend draws into memory and cannot fail.
    let Ok(mut terminal) = Terminal::new(TestBackend::new(width, height));
    let Ok(_) = terminal.draw(draw);
    let mut out = String::new();
    for line in terminal.backend().buffer().content().chunks(usize::from(width)) {
        let line: String = line.iter().map(|cell| cell.symbol()).collect();
        out.push_str(line.trim_end());
        out.push('\n');
    }
    out
}
