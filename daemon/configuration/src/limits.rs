//! What a cell may use: `[cells.limits]` for all cells, `[cell.NAME]` for one of them.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::error::UsageError;

/// What a cell may use. What is not given is not limited; in `[cell.NAME]`, it is as in
/// `[cells.limits]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct CellLimits {
    /// Private memory that may be written (heap, stacks, static variables), in MiB.
    pub memory: Option<u64>,
    /// Files that may be open at once.
    pub files: Option<u64>,
    /// Processes and threads that the user may have when one more is made; 0: no other process.
    pub processes: Option<u64>,
    /// How long a thread may run at `SCHED_FIFO` without waiting for anything, in ms.
    pub rttime: Option<u64>,
    /// Its niceness, from -20 to 19.
    pub nice: Option<i32>,
    /// Processors that its threads run on, unless a task names its own.
    pub cpus: Option<Vec<usize>>,
    /// Whether its threads may be real-time.
    pub real_time: Option<bool>,
    /// How willingly the kernel kills it when memory runs out, from -1000 to 1000.
    pub oom_score_adj: Option<i32>,
    /// Directories and files that it may read.
    pub read: Option<Vec<PathBuf>>,
    /// Directories and files that it may read and write.
    pub write: Option<Vec<PathBuf>>,
    /// Whether it may use the network.
    pub network: Option<bool>,
    /// Whether the cell is refused when one of these cannot be had.
    pub strict: Option<bool>,
}

impl CellLimits {
    /// These; those of `defaults` where nothing is given.
    #[must_use]
    pub fn over(&self, defaults: &Self) -> Self {
        let (own, all) = (self.clone(), defaults.clone());
        Self {
            memory: own.memory.or(all.memory),
            files: own.files.or(all.files),
            processes: own.processes.or(all.processes),
            rttime: own.rttime.or(all.rttime),
            nice: own.nice.or(all.nice),
            cpus: own.cpus.or(all.cpus),
            real_time: own.real_time.or(all.real_time),
            oom_score_adj: own.oom_score_adj.or(all.oom_score_adj),
            read: own.read.or(all.read),
            write: own.write.or(all.write),
            network: own.network.or(all.network),
            strict: own.strict.or(all.strict),
        }
    }

    /// Whether files and network are denied where they are not granted.
    #[must_use]
    pub fn is_sandbox(&self) -> bool {
        self.read.is_some() || self.write.is_some() || self.network.is_some()
    }

    /// The paths in it.
    pub(crate) fn paths(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        self.read.iter_mut().chain(&mut self.write).flatten()
    }

    /// Checks the numbers; `section` is for the message.
    ///
    /// # Errors
    /// One is out of its range.
    pub fn check(&self, section: &str) -> Result<(), UsageError> {
        let refuse = |key: &str, value: i128, what: &str| {
            let (key, what) = (format!("{section}.{key}"), what.to_owned());
            Err(UsageError::Limit { key, value, what })
        };
        match self {
            Self { memory: Some(value), .. } if !(16..=1 << 30).contains(value) => {
                refuse("memory", (*value).into(), "16 MiB or more, what a cell itself takes")
            }
            Self { files: Some(value), .. } if !(64..=1 << 30).contains(value) => {
                refuse("files", (*value).into(), "64 or more, what a cell itself takes")
            }
            Self { processes: Some(value), .. } if *value > 1 << 22 => {
                refuse("processes", (*value).into(), "4194304 at most, as many as the system has")
            }
            Self { rttime: Some(value), .. } if !(1..=86_400_000).contains(value) => {
                refuse("rttime", (*value).into(), "1 to 86400000 ms")
            }
            Self { nice: Some(value), .. } if !(-20..=19).contains(value) => {
                refuse("nice", (*value).into(), "-20 to 19")
            }
            Self { oom_score_adj: Some(value), .. } if !(-1000..=1000).contains(value) => {
                refuse("oom_score_adj", (*value).into(), "-1000 to 1000")
            }
            Self { cpus: Some(cpus), .. } if cpus.is_empty() => {
                refuse("cpus.len", 0, "name one processor at least, or leave `cpus` out")
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_has_the_limits_of_all_where_it_names_none() {
        let all = CellLimits { memory: Some(512), network: Some(false), ..CellLimits::default() };
        let own = CellLimits { memory: Some(1024), nice: Some(5), ..CellLimits::default() };
        let both = own.over(&all);
        assert_eq!((both.memory, both.nice, both.network), (Some(1024), Some(5), Some(false)));
        assert!(both.is_sandbox() && !own.is_sandbox());
    }

    #[test]
    fn a_number_out_of_its_range_is_refused_by_its_key() {
        let refused = |limits: CellLimits| limits.check("cell.arm").unwrap_err().to_string();
        let told = refused(CellLimits { nice: Some(20), ..CellLimits::default() });
        assert_eq!(told, "cell.arm.nice = 20: -20 to 19");
        let told = refused(CellLimits { memory: Some(1), ..CellLimits::default() });
        assert_eq!(told, "cell.arm.memory = 1: 16 MiB or more, what a cell itself takes");
    }
}
