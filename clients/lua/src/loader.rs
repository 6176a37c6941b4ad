//! The scripts of this process.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde_json::{Value as Json, json};

use crate::foreign::{self, Function, Log, Scripts};
use crate::request::Request;
use crate::script::Script;

/// Loads scripts, and keeps what C code has the addresses of.
#[derive(Debug)]
pub(crate) struct Loader {
    log: Log,
    scripts: Mutex<Loaded>,
}

#[derive(Debug, Default)]
struct Loaded {
    last: u64,
    all: BTreeMap<u64, Script>,
}

impl Scripts for Loader {
    fn load(&self, request: &[u8]) -> Vec<u8> {
        let answer = catch_unwind(AssertUnwindSafe(|| self.answer(request)));
        let answer = answer.unwrap_or_else(|_| Err(vec!["genom-lua panicked".to_owned()]));
        answer.unwrap_or_else(|errors| json!({ "errors": errors })).to_string().into_bytes()
    }

    fn release(&self, number: u64) {
        let script = self.scripts().all.remove(&number);
        // Not while others wait.
        drop(script);
    }

    fn tell_where(&self, codel: &str) {
        let (told, threads): (Vec<String>, Vec<i32>) = {
            let scripts = self.scripts();
            let each = || scripts.all.values();
            let told = each().filter_map(|script| script.told(codel)).collect();
            (told, each().filter_map(|script| script.runs(codel)).collect())
        };
        told.iter().for_each(|told| self.log.error(told));
        threads.into_iter().for_each(|thread| foreign::tell_lines(thread, self.log));
    }
}

impl Loader {
    /// Errors of codels are written there.
    pub(crate) fn new(log: Log) -> Self {
        Self { log, scripts: Mutex::default() }
    }

    /// The C function of a codel.
    pub(crate) fn function(&self, codel: &str) -> Option<Function> {
        self.scripts().all.values().find_map(|script| script.function(codel))
    }

    /// The event of errors, of any script.
    pub(crate) fn unkex(&self) -> Option<usize> {
        self.scripts().all.values().find_map(Script::unkex)
    }

    fn answer(&self, request: &[u8]) -> Result<Json, Vec<String>> {
        let request: Request = serde_json::from_slice(request)
            .map_err(|why| vec![format!("genom-lua does not understand genomd: {why}")])?;
        let script = Script::load(request, self.log)?;
        let mut scripts = self.scripts();
        scripts.last += 1;
        let number = scripts.last;
        let answer = script.answer(number);
        scripts.all.insert(number, script);
        Ok(answer)
    }

    fn scripts(&self) -> MutexGuard<'_, Loaded> {
        self.scripts.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
