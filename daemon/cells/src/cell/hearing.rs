//! What a cell tells while it lives, and the report of an end that nobody asked for.

use std::io::Write as _;
use std::path::Path;
use std::sync::{Arc, PoisonError};

use genom_protocol::{Change, Crash, CrashReport};
use genom_supervisor::bus::Teller;

use super::Cell;
use super::supervised::VIOLATED;
use crate::crashes::{DumpError, Known};
use crate::end::End;
use crate::follow::Events;
use crate::setup::Told;
use crate::shelf::create;

/// Name of a minidump in a report.
const MINIDUMP: &str = "minidump.dmp";

impl Cell {
    fn with_known<T>(&self, work: impl FnOnce(&mut Known) -> T) -> T {
        work(&mut self.known.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Tells on what it tells, until its streams are over.
    pub(super) async fn follow(&self, after: Option<u64>) {
        let changes = async {
            let Ok(mut events) = Events::open(&self.client, "/events", after).await else { return };
            let mut leaves = false;
            let cell: Arc<str> = self.name.as_str().into();
            while let Some((id, change)) = events.next().await {
                if change["event"] == "stopping" {
                    leaves = true;
                    continue;
                }
                // A codel raised the signal for the process to stop: what it unloads now, it has
                // again when it starts again.
                if leaves && !self.is_stopping() {
                    continue;
                }
                // Of what it held it is asked until it has ended.
                if !self.is_stopping() {
                    self.heard(&change);
                }
                // Its last component went by itself (service `kill`), and none is being loaded.
                if self.is_empty() && change["event"] == "component_unloaded" {
                    let turn = self.changing.try_lock();
                    if turn.is_ok() {
                        self.ask_to_stop();
                    }
                }
                if change["event"] == VIOLATED {
                    self.supervised(&change).await;
                }
                let of = id.zip(self.pid());
                let teller =
                    of.map(|(id, process)| Teller { cell: Arc::clone(&cell), process, id });
                self.setup.tell(Told::Change(change, teller));
            }
        };
        let logs = async {
            let path = "/logs/stream?last=1024";
            let Ok(mut events) = Events::open(&self.client, path, None).await else { return };
            while let Some((_, entry)) = events.next().await {
                self.with_known(|known| known.hear(&entry));
                self.setup.tell(Told::Log(entry));
            }
        };
        tokio::join!(changes, logs);
    }

    /// Begins the report of an end, unless somebody asked for it; it is written while the cell
    /// starts again. Returns whether somebody did.
    pub(super) fn report(&self, end: &End) -> bool {
        let (asked, pid) = self.with(|state| (std::mem::take(&mut state.asked), state.pid));
        let known = self.with_known(std::mem::take);
        let left = self.setup.boxes.end(&self.name);
        let dump = self.with(|state| state.dump.taken());
        let in_order = matches!(end, End::Exited(0) | End::NotStarted(_));
        if asked || in_order || self.is_stopping() {
            return asked;
        }
        let held = self.journal.read().unwrap_or_default();
        let (reports, cell) = (&self.setup.reports, (self.name.as_str(), pid));
        let seen = reports.look(cell, end, &self.place.note(), &held.component, &known);
        let (Some(seen), setup) = (seen, std::sync::Arc::clone(&self.setup)) else { return false };
        let (cell, ended) = (self.name.clone(), end.to_string());
        tokio::task::spawn_blocking(move || {
            let boxes = &setup.boxes;
            let left = left.filter(|_| boxes.is_for_crashes());
            let more = |directory: &Path, report: &mut CrashReport| {
                let name = report.crash.name.clone();
                let put = |left| boxes.put_beside(directory, &cell, &name, (&ended, left));
                report.blackbox = left.map(put);
                report.minidump = dump.map(|dump| keep_dump(directory, &name, dump));
            };
            match setup.reports.write(seen, &setup.program, more) {
                Ok(Crash { name: report, end, codel, .. }) => {
                    tracing::warn!("cell {cell}: `genomctl crashes {report}` shows how it ended");
                    setup.tell(Told::Cell(Change::CellCrashed { cell, report, end, codel }));
                }
                Err(error) => tracing::error!("cell {cell}: no report of its end: {error}"),
            }
        });
        false
    }

    /// The same of a process that crashed while no daemon was there.
    pub(super) fn report_left(&self) {
        let noted = std::fs::symlink_metadata(self.place.note());
        if noted.is_ok_and(|found| found.len() > 0) {
            self.report(&End::Unknown);
        }
    }
}

/// Puts a minidump into the directory of a report; where it is then, or why it is not.
fn keep_dump(directory: &Path, report: &str, dump: Result<Vec<u8>, DumpError>) -> String {
    let kept = dump.map_err(|error| error.to_string()).and_then(|bytes| {
        let kept = create(&directory.join(MINIDUMP)).and_then(|mut file| file.write_all(&bytes));
        kept.map_err(|error| format!("not written: {error}"))
    });
    match kept {
        Ok(()) => directory.with_file_name(report).join(MINIDUMP).display().to_string(),
        Err(why) => why,
    }
}
