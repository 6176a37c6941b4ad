//! Finds threads that are still in the code of a library: a codel may have started one and left it
//! running, and unmapping the code would crash the daemon.
//!
//! A thread counts as being in a library when its stack contains an address of the library's code.
//! A stale address can only keep a library mapped unnecessarily. Waiting threads are inspected as
//! they are; running ones are stopped by a signal ([`ask`](super::ask)).

use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::ErrorKind;
use std::mem;
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use super::ask::{self, Place};

/// Attempts for a thread that does not wait.
const LOOKS: usize = 20;
/// Most bytes of a stack that are read.
const DEEPEST: usize = 8 << 20;

/// Threads that prevent a library from being unmapped, without those that ask.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Threads {
    /// Threads with an address of its code on their stacks.
    pub(super) inside: usize,
    /// Threads that could not be inspected.
    pub(super) unseen: usize,
}

/// Result for one thread.
#[derive(Debug, PartialEq, Eq)]
enum Found {
    /// It is in the code of these libraries, by index among those asked for; mostly of none.
    In(Vec<usize>),
    Unseen,
}

/// Finds threads with addresses within `code` on their stacks; threads that ask are ignored.
///
/// One search reads all stacks, so it takes longer the more components there are. Callers that
/// arrive during a search share the next one: closing 500 libraries in parallel takes a few
/// searches.
pub(super) fn inside(code: &[Range<usize>]) -> Threads {
    let (answer, found) = channel();
    let thread = own_number();
    lock(&ASKED).push(Asked { code: code.to_vec(), thread, answer });
    let turn = lock(&TURN);
    if let Ok(found) = found.try_recv() {
        return found;
    }
    // Later callers wait for the next search, since a thread may have been started meanwhile.
    let asked = mem::take(&mut *lock(&ASKED));
    for (one, threads) in asked.iter().zip(look_for(&asked)) {
        // The receiver waits for its turn, or is this thread.
        let _ = one.answer.send(threads);
    }
    drop(turn);
    found.recv().unwrap_or(Threads { inside: 0, unseen: 1 })
}

/// A caller that waits for a search.
struct Asked {
    code: Vec<Range<usize>>,
    /// Its own thread, which is not in the library's code but may have addresses of it on its
    /// stack.
    thread: Option<OsString>,
    answer: Sender<Threads>,
}

static ASKED: Mutex<Vec<Asked>> = Mutex::new(Vec::new());
/// Held during a search for all callers that have arrived before.
static TURN: Mutex<()> = Mutex::new(());

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn own_number() -> Option<OsString> {
    Some(fs::read_link("/proc/thread-self").ok()?.file_name()?.to_owned())
}

/// Searches all threads for all callers.
fn look_for(asked: &[Asked]) -> Vec<Threads> {
    let (Ok(tasks), Ok(memory)) = (fs::read_dir("/proc/self/task"), File::open("/proc/self/mem"))
    else {
        return vec![Threads { inside: 0, unseen: 1 }; asked.len()];
    };
    let mut threads = vec![Threads::default(); asked.len()];
    let code: Vec<&[Range<usize>]> = asked.iter().map(|one| one.code.as_slice()).collect();
    // Read once: with hundreds of components loaded the list is long.
    let mut parts = parts().unwrap_or_default();
    let asks = |name: &OsStr| asked.iter().any(|one| one.thread.as_deref() == Some(name));
    for task in tasks.flatten().filter(|task| !asks(&task.file_name())) {
        match look(&task.path(), &memory, &code, &mut parts) {
            Found::In(these) => these.into_iter().for_each(|at| threads[at].inside += 1),
            Found::Unseen => threads.iter_mut().for_each(|one| one.unseen += 1),
        }
    }
    threads
}

fn look(
    task: &Path,
    memory: &File,
    code: &[&[Range<usize>]],
    parts: &mut Vec<Range<usize>>,
) -> Found {
    for _ in 0..LOOKS {
        match fs::read_to_string(task.join("syscall")) {
            Ok(line) => match stack_pointer(&line) {
                Some(top) => return holds(memory, (top, None), code, parts),
                None => thread::park_timeout(Duration::from_millis(1)),
            },
            // The thread has ended.
            Err(error) if is_gone(&error) => return Found::In(Vec::new()),
            // The kernel does not say.
            Err(_) => break,
        }
    }
    let number = task.file_name().and_then(|name| name.to_str()?.parse().ok());
    let asked = number.and_then(|number| {
        ask::where_is(number, |Place { counter, stack }| {
            holds(memory, (stack, Some(counter)), code, parts)
        })
    });
    match asked {
        Some(found) => found,
        None if !task.exists() => Found::In(Vec::new()),
        None => Found::Unseen,
    }
}

fn is_gone(error: &std::io::Error) -> bool {
    error.kind() == ErrorKind::NotFound || error.raw_os_error() == Some(libc::ESRCH)
}

/// Parses `NUMBER ARGUMENTS... SP PC` of a waiting thread; a running one has no such line.
fn stack_pointer(line: &str) -> Option<usize> {
    let (_, sp) = line.rsplit_once(' ').and_then(|(rest, _)| rest.rsplit_once(' '))?;
    usize::from_str_radix(sp.strip_prefix("0x")?, 16).ok()
}

/// The mappings of this process.
fn parts() -> Option<Vec<Range<usize>>> {
    let maps = fs::read_to_string("/proc/self/maps").ok()?;
    Some(maps.lines().filter_map(range).collect())
}

/// The mappings that contain code.
pub(super) fn executable() -> Vec<Range<usize>> {
    let maps = fs::read_to_string("/proc/self/maps").unwrap_or_default();
    let code = |line: &&str| line.split(' ').nth(1).is_some_and(|rights| rights.contains('x'));
    maps.lines().filter(code).filter_map(range).collect()
}

/// End of the mapping that contains an address.
fn part_at(parts: &[Range<usize>], at: usize) -> Option<usize> {
    parts.iter().find(|part| part.contains(&at)).map(|part| part.end)
}

/// Address range of a line of `/proc/self/maps`.
fn range(line: &str) -> Option<Range<usize>> {
    let (from, to) = line.split_once(' ')?.0.split_once('-')?;
    let address = |text| usize::from_str_radix(text, 16).ok();
    Some(address(from)?..address(to)?)
}

/// The libraries for which the program counter, if known, or a word of the stack from `top` on is
/// an address in their code. The stack is read through the kernel, since the thread and its stack
/// may disappear meanwhile.
fn holds(
    memory: &File,
    (top, counter): (usize, Option<usize>),
    code: &[&[Range<usize>]],
    known: &mut Vec<Range<usize>>,
) -> Found {
    let mut bytes = Vec::new();
    // The known mappings may be out of date: on failure they are read again.
    for again in [false, true] {
        if again || part_at(known, top).is_none() {
            let Some(now) = parts() else { return Found::Unseen };
            *known = now;
        }
        // The stack is not mapped any more: the thread has ended.
        let Some(end) = part_at(known, top) else { return Found::In(Vec::new()) };
        bytes.resize((end.min(top + DEEPEST) - top) / 8 * 8, 0);
        match memory.read_exact_at(&mut bytes, top as u64) {
            Ok(()) => break,
            Err(_) if !again => {}
            Err(_) if parts().is_some_and(|now| part_at(&now, top).is_none()) => {
                return Found::In(Vec::new());
            }
            Err(_) => return Found::Unseen,
        }
    }
    let words = bytes.chunks_exact(8).filter_map(|word| <[u8; 8]>::try_from(word).ok());
    let words: Vec<usize> = words.map(usize::from_ne_bytes).chain(counter).collect();
    let holds =
        |own: &[Range<usize>]| own.iter().any(|part| words.iter().any(|at| part.contains(at)));
    let parts = code.iter().enumerate();
    Found::In(parts.filter(|(_, own)| holds(own)).map(|(place, _)| place).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_kernel_says_of_a_thread_is_read() {
        assert_eq!(stack_pointer("202 0x1 0x2 0x0 0x0 0x0 0x0 0x7ffc10 0x7f01"), Some(0x7f_fc10));
        assert_eq!(stack_pointer("-1 0x7ffc10 0x7f01\n"), Some(0x7f_fc10));
        assert_eq!(stack_pointer("running\n"), None);
        assert_eq!(stack_pointer(""), None);
        assert_eq!(range("7f00-7f10 rw-p 00000000 00:00 0"), Some(0x7f00..0x7f10));
    }
}
