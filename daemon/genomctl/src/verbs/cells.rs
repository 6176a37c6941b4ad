//! `genomctl cells`: the processes that run components apart from the daemon.

use clap_complete::engine::ArgValueCompleter;
use genom_protocol::{Cell, CellEnds, Cells, routes};

use crate::complete::Names;
use crate::failure::Failure;
use crate::session::Session;
use crate::table::Table;

/// List the cells, processes of their own for components, or restart or end one.
///
/// A component is put into one by `cell` in a configuration, or by `genomctl load --cell NAME`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Kill this cell's process, as a fault would, and let its components come back; start the
    /// process of one that has failed.
    #[arg(long, value_name = "CELL", conflicts_with = "end", add = ArgValueCompleter::from(Names::Cells))]
    restart: Option<String>,
    /// End this cell: its components stop as they do when they are unloaded.
    #[arg(long, value_name = "CELL", add = ArgValueCompleter::from(Names::Cells))]
    end: Option<String>,
}

pub(super) async fn run(args: Args, session: &Session) -> Result<(), Failure> {
    if let Some(cell) = args.restart {
        let reply = session.ask(routes::restart_cell(&cell)).await?;
        return session.show(&reply, |cell: &Cell| format!("{} is {}\n", cell.name, cell.state));
    }
    if let Some(cell) = args.end {
        let reply = session.ask(routes::end_cell(&cell)).await?;
        return session.show(&reply, |ends: &CellEnds| format!("{} has ended\n", ends.cell));
    }
    let reply = session.ask(routes::cells()).await?;
    session.show_table(&reply, render)
}

fn render(reply: &Cells) -> Table {
    let row = |cell: &Cell| {
        vec![
            cell.name.clone(),
            cell.state.to_string(),
            cell.pid.map_or_else(|| "-".to_owned(), |pid| pid.to_string()),
            cell.starts.to_string(),
            cell.components.join(", "),
            cell.last_end.clone().unwrap_or_else(|| "-".to_owned()),
        ]
    };
    let rows = reply.cells.iter().map(row).collect();
    Table { header: vec!["CELL", "STATE", "PID", "STARTS", "COMPONENTS", "LAST END"], rows }
}

#[cfg(test)]
mod tests {
    use genom_protocol::CellState;

    use super::*;

    #[test]
    fn a_cell_is_told_with_how_its_last_process_ended() {
        let cell = Cell {
            name: "vision".into(),
            state: CellState::Running,
            pid: Some(42),
            components: vec!["camera".into(), "tracker".into()],
            starts: 2,
            last_end: Some("signal 11 (SIGSEGV)".into()),
            socket: "/run/genomd.sock.cells/vision/socket".into(),
        };
        let table = render(&Cells { cells: vec![cell] });
        let row = ["vision", "running", "42", "2", "camera, tracker", "signal 11 (SIGSEGV)"];
        assert_eq!(table.rows, [row]);
    }
}
