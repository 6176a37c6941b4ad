//! Reports of crashes: what is known of a cell whose process ended without being asked to.

use std::fmt;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::{BlackBoxLeft, LogEntry, Statistics};

/// The reports that are kept.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Crashes {
    /// The directory that holds them; absent if there is no place for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(value_type = Option<String>))]
    pub directory: Option<PathBuf>,
    /// The newest first.
    pub crashes: Vec<Crash>,
}

/// A report in a few words.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Crash {
    /// Name of the report, and of its directory.
    pub name: String,
    /// When the end was noticed, in seconds since 1970.
    pub time: f64,
    /// The cell.
    pub cell: String,
    /// How its process ended: `signal 11 (SIGSEGV)`, `exit status 1`, ...
    pub end: String,
    /// The codel that ran in the thread that ended the process.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub codel: Option<String>,
}

/// A report of a crash.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct CrashReport {
    /// What the list has.
    #[serde(flatten)]
    pub crash: Crash,
    /// Version of the daemon.
    pub genomd: String,
    /// The daemon's socket.
    #[cfg_attr(feature = "openapi", schema(value_type = String))]
    pub socket: PathBuf,
    /// The process that ended, if it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pid: Option<u32>,
    /// Whether the system ended it for want of memory; absent if that cannot be told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub out_of_memory: Option<bool>,
    /// The components that were in the cell.
    pub components: Vec<CrashedComponent>,
    /// What the dying process told; absent if it could tell nothing (SIGKILL).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<CrashFault>,
    /// What the black box kept, if it is on: a file in the report's directory, or why there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blackbox: Option<BlackBoxLeft>,
    /// A minidump of the process, if one was asked for: a file in the report's directory, or why
    /// there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub minidump: Option<String>,
    /// Where the system has put a core dump, if one was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub core: Option<String>,
    /// The latest entries of the cell's log, oldest first.
    pub log: Vec<LogEntry>,
}

/// A component that was in the cell.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct CrashedComponent {
    /// Instance name.
    pub name: String,
    /// Path of its library.
    #[cfg_attr(feature = "openapi", schema(value_type = String))]
    pub library: PathBuf,
    /// GNU build id of the library that was loaded, in hexadecimal; absent if it has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub build_id: Option<String>,
    /// Statistics of its tasks as last known, up to a few seconds before the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub statistics: Option<Statistics>,
}

/// What a dying process told.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct CrashFault {
    /// What ended it: a signal (`SIGSEGV`) or a function (`exit`).
    pub what: String,
    /// Number of the signal, and its `si_code`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signal: Option<i32>,
    /// As above.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signal_code: Option<i32>,
    /// The address that could not be used, in hexadecimal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub address: Option<String>,
    /// Number and name of the thread.
    pub thread: String,
    /// The foreign code that the thread ran: ``codel `demo_servo` of /opt/demo.so``.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub words: Option<String>,
    /// Instance name of the component whose codel that is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub component: Option<String>,
    /// `service NAME` or `task NAME`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub owner: Option<String>,
    /// Number of the activity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub activity: Option<u64>,
    /// Inputs of the service, up to 4 KiB.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inputs: Option<Value>,
    /// The native frames, innermost first.
    pub frames: Vec<CrashFrame>,
    /// Whether the frames are words found on the stack that may be return addresses, since the
    /// stack could not be unwound.
    pub guessed: bool,
    /// Whether the note ends early: the process died while it wrote it.
    pub cut: bool,
}

/// A native frame.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct CrashFrame {
    /// Address in the process, in hexadecimal.
    pub address: String,
    /// The file that is mapped there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Address in that file as its symbols and `addr2line` count it, in hexadecimal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file_address: Option<String>,
    /// The function, with the offset in it: `crashes_segfault+0x18`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub function: Option<String>,
}

impl fmt::Display for CrashReport {
    /// For people, in lines.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Crash { name, cell, end, .. } = &self.crash;
        let pid = self.pid.map_or_else(String::new, |pid| format!(", process {pid}"));
        writeln!(f, "{name}\ncell {cell}{pid}: {end}")?;
        match self.out_of_memory {
            Some(true) => writeln!(f, "the system was out of memory")?,
            Some(false) => writeln!(f, "killed, and not for want of memory")?,
            None => {}
        }
        if let Some(fault) = &self.fault {
            write!(f, "{fault}")?;
        }
        match &self.blackbox {
            Some(BlackBoxLeft { error: Some(error), .. }) => writeln!(f, "no black box: {error}")?,
            Some(BlackBoxLeft { file, messages, .. }) => {
                writeln!(f, "black box: {} ({messages} messages)", file.display())?;
            }
            None => {}
        }
        for (what, told) in [("minidump", &self.minidump), ("core dump", &self.core)] {
            if let Some(told) = told {
                writeln!(f, "{what}: {told}")?;
            }
        }
        for component in &self.components {
            let id = component.build_id.as_deref().unwrap_or("none");
            let (name, library) = (&component.name, component.library.display());
            writeln!(f, "\ncomponent {name}: {library}, build id {id}")?;
            for task in component.statistics.iter().flat_map(|statistics| &statistics.tasks) {
                let (name, cycles, overruns) = (&task.name, task.cycles, task.overruns);
                let late = task.lateness.max_ns;
                writeln!(
                    f,
                    "  task {name}: {} cycles, mean {} ns, most {} ns, late {late} ns at most, \
                     {overruns} overruns",
                    cycles.count, cycles.mean_ns, cycles.max_ns
                )?;
            }
        }
        if !self.log.is_empty() {
            writeln!(f, "\nits log:")?;
        }
        for entry in &self.log {
            let LogEntry { level, component, message, .. } = entry;
            let time = entry.time_of_day();
            let component = component.as_ref().map_or_else(String::new, |name| format!("{name}: "));
            writeln!(f, "  {time} {level} {component}{message}")?;
        }
        Ok(())
    }
}

impl fmt::Display for CrashFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let address = self.address.as_ref().map_or_else(String::new, |at| format!(" at {at}"));
        let words = self.words.as_deref().unwrap_or("code outside codels");
        writeln!(f, "{}{address} in {words}, thread {}", self.what, self.thread)?;
        if let (Some(component), Some(owner)) = (&self.component, &self.owner) {
            let number = self.activity.map_or_else(String::new, |n| format!(", activity {n}"));
            writeln!(f, "{owner} of {component}{number}")?;
        }
        if let Some(inputs) = &self.inputs {
            writeln!(f, "inputs {inputs}")?;
        }
        if !self.frames.is_empty() {
            let guessed = if self.guessed { ", guessed from words of its stack" } else { "" };
            writeln!(f, "\nbacktrace{guessed}:")?;
        }
        for (rank, frame) in self.frames.iter().enumerate() {
            let function = frame.function.as_deref().unwrap_or("?");
            let file = frame.file.as_deref().unwrap_or("?");
            let at = frame.file_address.as_deref().unwrap_or(&frame.address);
            writeln!(f, "  {rank:>2} {function} in {file} ({at})")?;
        }
        if self.cut {
            writeln!(f, "the process died while it told this")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_report_tells_people_what_ran_and_where() {
        let report: CrashReport = serde_json::from_value(json!({
            "name": "crash-1-arm", "time": 1.5, "cell": "arm", "end": "signal 11 (SIGSEGV)",
            "codel": "go", "genomd": "0.1.0", "socket": "/s", "pid": 42,
            "components": [{"name": "demo", "library": "/opt/demo.so", "build_id": "ab"}],
            "fault": {
                "what": "SIGSEGV", "address": "0x0", "thread": "43 main",
                "words": "codel `go` of /opt/demo.so", "component": "demo",
                "owner": "service goto", "activity": 3, "inputs": {"by": 1},
                "frames": [{"address": "0x7f10", "file": "/opt/demo.so", "file_address": "0x10",
                    "function": "go+0x4"}],
                "guessed": false, "cut": false,
            },
            "log": [{"time": 1.0, "level": "warn", "origin": "o", "message": "odd"}],
        }))
        .unwrap();
        let told = report.to_string();
        for line in [
            "cell arm, process 42: signal 11 (SIGSEGV)",
            "SIGSEGV at 0x0 in codel `go` of /opt/demo.so, thread 43 main",
            "service goto of demo, activity 3",
            "inputs {\"by\":1}",
            "   0 go+0x4 in /opt/demo.so (0x10)",
            "component demo: /opt/demo.so, build id ab",
            "  00:00:01.000 warn odd",
        ] {
            assert!(told.lines().any(|found| found == line), "{line} in\n{told}");
        }
    }
}
