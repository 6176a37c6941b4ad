//! Threads that are still in the code of a library: a codel may have started one and left it, and
//! to unmap the code under it ends the daemon.
//!
//! Found as a debugger would, by what lies on their stacks; a stale word can only make a library
//! stay that could have gone.

use std::fs::{self, File};
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::thread;
use std::time::Duration;

/// How often a thread is looked at that does not stand still.
const LOOKS: usize = 20;
/// Most of a stack that is read.
const DEEPEST: usize = 8 << 20;

/// How many threads, the calling one apart, have an address within `code` on their stacks.
pub(super) fn inside(code: &[Range<usize>]) -> usize {
    let own = fs::read_link("/proc/thread-self").ok();
    let own = own.as_deref().and_then(|path| path.file_name());
    let (Ok(tasks), Ok(memory)) = (fs::read_dir("/proc/self/task"), File::open("/proc/self/mem"))
    else {
        return 0;
    };
    let others = tasks.flatten().filter(|task| Some(task.file_name().as_os_str()) != own);
    let stacks = others.filter_map(|task| stack(&task.path().join("syscall")));
    stacks.filter(|stack| holds(&memory, stack, code)).count()
}

/// The used part of a thread's stack, once it waits for something.
fn stack(syscall: &std::path::Path) -> Option<Range<usize>> {
    for _ in 0..LOOKS {
        if let Some(top) = stack_pointer(&fs::read_to_string(syscall).ok()?) {
            let maps = fs::read_to_string("/proc/self/maps").ok()?;
            let end = maps.lines().filter_map(range).find(|range| range.contains(&top))?.end;
            return Some(top..end.min(top + DEEPEST));
        }
        thread::park_timeout(Duration::from_millis(1));
    }
    None
}

/// `NUMBER ARGUMENTS... SP PC` of a thread that waits; `running` has none.
fn stack_pointer(line: &str) -> Option<usize> {
    let (_, sp) = line.rsplit_once(' ').and_then(|(rest, _)| rest.rsplit_once(' '))?;
    usize::from_str_radix(sp.strip_prefix("0x")?, 16).ok()
}

/// Addresses of a line of `/proc/self/maps`.
fn range(line: &str) -> Option<Range<usize>> {
    let (from, to) = line.split_once(' ')?.0.split_once('-')?;
    let address = |text| usize::from_str_radix(text, 16).ok();
    Some(address(from)?..address(to)?)
}

/// Whether a word of that memory is an address within `code`. Read through the kernel: the thread
/// may end meanwhile, and its stack with it.
fn holds(memory: &File, stack: &Range<usize>, code: &[Range<usize>]) -> bool {
    let mut bytes = vec![0; stack.len() / 8 * 8];
    if memory.read_exact_at(&mut bytes, stack.start as u64).is_err() {
        return false;
    }
    let words = bytes.chunks_exact(8).filter_map(|word| <[u8; 8]>::try_from(word).ok());
    words.map(usize::from_ne_bytes).any(|at| code.iter().any(|own| own.contains(&at)))
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
