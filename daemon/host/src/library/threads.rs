//! Threads that are still in the code of a library: a codel may have started one and left it, and
//! to unmap the code under it ends the daemon.
//!
//! A thread counts as being in a library when its stack holds an address of the library's code. A
//! stale address can only keep a library that could have been unmapped. Threads that wait are read
//! as they are; running ones are asked by a signal where they are ([`ask`](super::ask)).

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

/// How often a thread is looked at that does not stand still.
const LOOKS: usize = 20;
/// Most of a stack that is read.
const DEEPEST: usize = 8 << 20;

/// Threads that keep a library from being unmapped, the asking ones excluded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Threads {
    /// With an address of its code on their stacks.
    pub(super) inside: usize,
    /// That could not be looked at.
    pub(super) unseen: usize,
}

/// What is known of a thread.
#[derive(Debug, PartialEq, Eq)]
enum Found {
    /// In the code of these, by their places among those that ask; of none, most often.
    In(Vec<usize>),
    Unseen,
}

/// Looks for threads with addresses within `code`; threads that ask are left out.
///
/// A look reads all stacks, so it takes longer the more components there are. Callers that come
/// while one is under way share the next one: to close 500 libraries side by side takes a few looks.
pub(super) fn inside(code: &[Range<usize>]) -> Threads {
    let (answer, found) = channel();
    let thread = own_number();
    lock(&ASKED).push(Asked { code: code.to_vec(), thread, answer });
    let turn = lock(&TURN);
    if let Ok(found) = found.try_recv() {
        return found;
    }
    // What is asked from here on is for the next look: a thread may have been started before.
    let asked = mem::take(&mut *lock(&ASKED));
    for (one, threads) in asked.iter().zip(look_for(&asked)) {
        // It waits for the turn, or is this thread.
        let _ = one.answer.send(threads);
    }
    drop(turn);
    found.recv().unwrap_or(Threads { inside: 0, unseen: 1 })
}

/// A caller that waits for a look.
struct Asked {
    code: Vec<Range<usize>>,
    /// It has no business in the code itself, but may have addresses of it on its stack.
    thread: Option<OsString>,
    answer: Sender<Threads>,
}

static ASKED: Mutex<Vec<Asked>> = Mutex::new(Vec::new());
/// Held while looking, for all callers that have asked by then.
static TURN: Mutex<()> = Mutex::new(());

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn own_number() -> Option<OsString> {
    Some(fs::read_link("/proc/thread-self").ok()?.file_name()?.to_owned())
}

/// Looks at all threads for each of them.
fn look_for(asked: &[Asked]) -> Vec<Threads> {
    let (Ok(tasks), Ok(memory)) = (fs::read_dir("/proc/self/task"), File::open("/proc/self/mem"))
    else {
        return vec![Threads { inside: 0, unseen: 1 }; asked.len()];
    };
    let mut threads = vec![Threads::default(); asked.len()];
    let code: Vec<&[Range<usize>]> = asked.iter().map(|one| one.code.as_slice()).collect();
    // Read once: with hundreds of components loaded it is long.
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
            // It ended.
            Err(error) if is_gone(&error) => return Found::In(Vec::new()),
            // The kernel does not tell.
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

/// `NUMBER ARGUMENTS... SP PC` of a thread that waits; `running` has none.
fn stack_pointer(line: &str) -> Option<usize> {
    let (_, sp) = line.rsplit_once(' ').and_then(|(rest, _)| rest.rsplit_once(' '))?;
    usize::from_str_radix(sp.strip_prefix("0x")?, 16).ok()
}

/// The parts of the memory of this process.
fn parts() -> Option<Vec<Range<usize>>> {
    let maps = fs::read_to_string("/proc/self/maps").ok()?;
    Some(maps.lines().filter_map(range).collect())
}

/// Those that hold code.
pub(super) fn executable() -> Vec<Range<usize>> {
    let maps = fs::read_to_string("/proc/self/maps").unwrap_or_default();
    let code = |line: &&str| line.split(' ').nth(1).is_some_and(|rights| rights.contains('x'));
    maps.lines().filter(code).filter_map(range).collect()
}

/// Where the part ends that holds an address.
fn part_at(parts: &[Range<usize>], at: usize) -> Option<usize> {
    parts.iter().find(|part| part.contains(&at)).map(|part| part.end)
}

/// Addresses of a line of `/proc/self/maps`.
fn range(line: &str) -> Option<Range<usize>> {
    let (from, to) = line.split_once(' ')?.0.split_once('-')?;
    let address = |text| usize::from_str_radix(text, 16).ok();
    Some(address(from)?..address(to)?)
}

/// Those of which the program counter, where it is known, or a word of the stack from `top` on is
/// an address. Read through the kernel: the thread may end meanwhile, and its stack with it.
fn holds(
    memory: &File,
    (top, counter): (usize, Option<usize>),
    code: &[&[Range<usize>]],
    known: &mut Vec<Range<usize>>,
) -> Found {
    let mut bytes = Vec::new();
    // What is known was read a while ago: in doubt it is read again.
    for again in [false, true] {
        if again || part_at(known, top).is_none() {
            let Some(now) = parts() else { return Found::Unseen };
            *known = now;
        }
        // No memory there any more: the thread has ended.
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
