//! Opens a library once, checks its table, and never closes it, since its threads may go on.

#![allow(unsafe_code, reason = "it opens code, and reads the table that is in it")]

use std::fs;
use std::mem::offset_of;
use std::path::{Path, PathBuf};
use std::ptr;
use std::sync::{Arc, Mutex, PoisonError};

use genom_middleware::Middleware;
use genom_plugin_abi::table::{Plugin, can};
use genom_plugin_abi::{MAJOR, SYMBOL, lent};
use libloading::os::unix;

use crate::callbacks;
use crate::error::LibraryError;
use crate::library::Library;
use crate::middleware::Open;

/// The minor version since which there are requests between daemons, and reports.
const SINCE: u16 = 2;

/// Bytes of the table in version 1.0.
const LEAST: usize = offset_of!(Plugin, meeting_point) + size_of::<usize>();

/// Beyond, the first word is not the size of a table.
const MOST: usize = 1 << 16;

/// Most bytes of a name.
const NAME: usize = 32;

/// Those that are open.
static OPEN: Mutex<Vec<&'static Library>> = Mutex::new(Vec::new());

impl Library {
    /// Opens a library, unless it is open already, and checks its table. Nothing of its middleware
    /// is opened yet, but the library's own initialisers run.
    ///
    /// # Errors
    /// It is no middleware, or one for another version.
    pub fn open(path: &Path) -> Result<&'static Self, LibraryError> {
        let path = fs::canonicalize(path)
            .map_err(|why| LibraryError::Missing { path: path.to_owned(), why: why.to_string() })?;
        let mut open = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(library) = open.iter().find(|one| one.path == path) {
            return Ok(library);
        }
        let flags = unix::RTLD_NOW | unix::RTLD_LOCAL;
        // SAFETY: its initialisers run, which is what whoever names the library asks for.
        let library = unsafe { unix::Library::open(Some(&path), flags) }
            .map_err(|error| LibraryError::Linker { path: path.clone(), why: error.to_string() })?;
        // SAFETY: the symbol is only taken as an address here.
        let symbol = unsafe { library.get::<*const Plugin>(SYMBOL) };
        let table = symbol.map(|symbol| *symbol).unwrap_or(ptr::null());
        if table.is_null() {
            return Err(LibraryError::NoPlugin { path });
        }
        // SAFETY: the library exports a table under this name, and stays open from here on.
        let library = match unsafe { Self::of(path, table) } {
            Ok(checked) => {
                // Never closed: its threads and what they hold may outlive all ends.
                std::mem::forget(library);
                checked
            }
            Err(why) => return Err(why),
        };
        open.push(library);
        Ok(library)
    }

    /// The middleware of a table that is part of this program, as it is in tests.
    ///
    /// # Errors
    /// The table is not complete.
    pub fn built_in(table: &'static Plugin) -> Result<&'static Self, LibraryError> {
        // SAFETY: it is a table, and lives as long as the program.
        unsafe { Self::of(PathBuf::from("this program"), table) }
    }

    /// # Safety
    /// `table` points to the table of code that is never unloaded, or is refused here.
    unsafe fn of(path: PathBuf, table: *const Plugin) -> Result<&'static Self, LibraryError> {
        // SAFETY: every version begins with its size.
        let size = unsafe { table.cast::<usize>().read() };
        if !(size_of::<usize>() + 4..=MOST).contains(&size) {
            return Err(LibraryError::Short { path, size, least: LEAST });
        }
        // SAFETY: it has that size; zero is a value of all members.
        let Some(table) = (unsafe { lent::copied(table) }) else {
            return Err(LibraryError::NoPlugin { path });
        };
        if table.major != MAJOR {
            let (major, minor) = (table.major, table.minor);
            return Err(LibraryError::Version { path, major, minor });
        }
        if size < LEAST {
            return Err(LibraryError::Short { path, size, least: LEAST });
        }
        if let Some((function, why)) = lacking(&table) {
            return Err(LibraryError::Lacks { path, function, why });
        }
        // SAFETY: the strings are constants of the library.
        let (name, version) = unsafe { (table.name.read(), table.version.read()) };
        let (name, version) = (name.into_owned(), version.into_owned());
        let plain = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_';
        let begins = name.as_bytes().first().is_some_and(u8::is_ascii_lowercase);
        if !begins || name.len() > NAME || !name.bytes().all(plain) {
            return Err(LibraryError::Name { path, name });
        }
        let host = callbacks::table();
        let library = Box::leak(Box::new(Self { path, name, version, table, host }));
        let own: *const Self = library;
        library.host.host = own.cast_mut().cast();
        Ok(library)
    }

    /// Opens its middleware with its options, an object in JSON.
    ///
    /// # Errors
    /// What the library says.
    pub fn middleware(&'static self, options: &str) -> Result<Arc<dyn Middleware>, LibraryError> {
        let open = Open::new(self, options)?;
        let Plugin { major, minor, .. } = self.table;
        let (name, version, path) = (&self.name, &self.version, self.path.display());
        tracing::info!("opened {name} ({version}) of {path}, table {major}.{minor}");
        Ok(Arc::new(open))
    }

    /// The capabilities that its table has functions for. A flag that its version did not know says
    /// nothing.
    pub(crate) fn able(&self) -> u64 {
        let Plugin { minor, log, diagnose, .. } = self.table;
        let knows = minor >= SINCE;
        let relays = knows && unrelayed(&self.table).is_none();
        let reports = knows && (log.is_some() || diagnose.is_some());
        let unless = |has: bool, flag: u64| if has { 0 } else { flag };
        !(unless(relays, can::RELAY) | unless(reports, can::REPORTS))
    }
}

/// A function for requests between daemons that is not there.
fn unrelayed(table: &Plugin) -> Option<&'static str> {
    [
        (table.announce.is_none(), "announce"),
        (table.close_announced.is_none(), "close_announced"),
        (table.reply_relayed.is_none(), "reply_relayed"),
        (table.close_relayed.is_none(), "close_relayed"),
        (table.daemons.is_none(), "daemons"),
        (table.own.is_none(), "own"),
        (table.ask_all.is_none(), "ask_all"),
        (table.ask.is_none(), "ask"),
    ]
    .into_iter()
    .find_map(|(missing, function)| missing.then_some(function))
}

/// A function that is not there and has to be, and why.
fn lacking(table: &Plugin) -> Option<(&'static str, &'static str)> {
    let always = "every middleware has";
    let services = "GENOM_MW_SERVICES needs";
    let serves = table.capabilities & can::SERVICES != 0;
    let discovers = table.capabilities & can::DISCOVERY != 0;
    let relays = table.minor >= SINCE && table.capabilities & can::RELAY != 0;
    if let Some(function) = unrelayed(table).filter(|_| relays) {
        return Some((function, "GENOM_MW_RELAY needs"));
    }
    [
        (true, table.open.is_none(), "open", always),
        (true, table.close.is_none(), "close", always),
        (true, table.publisher.is_none(), "publisher", always),
        (true, table.publish.is_none(), "publish", always),
        (true, table.close_publisher.is_none(), "close_publisher", always),
        (true, table.subscription.is_none(), "subscription", always),
        (true, table.close_subscription.is_none(), "close_subscription", always),
        (serves, table.serve.is_none(), "serve", services),
        (serves, table.close_served.is_none(), "close_served", services),
        (serves, table.reply.is_none(), "reply", services),
        (serves, table.close_call.is_none(), "close_call", services),
        (serves, table.client.is_none(), "client", services),
        (serves, table.request.is_none(), "request", services),
        (serves, table.cancel.is_none(), "cancel", services),
        (serves, table.close_run.is_none(), "close_run", services),
        (serves, table.close_client.is_none(), "close_client", services),
        (discovers, table.discover.is_none(), "discover", "GENOM_MW_DISCOVERY needs"),
    ]
    .into_iter()
    .find(|(needed, missing, ..)| *needed && *missing)
    .map(|(_, _, function, why)| (function, why))
}
