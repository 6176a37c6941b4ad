//! A process that reads symbols for the report of a crash. That takes a moment of a processor, and
//! as much memory as the files have symbols: neither is to be the daemon's, whose tasks go on. The
//! files are those of a process in an unknown state; what they do to who reads them ends with it.
//!
//! It is the daemon's own program, with [`WORD`]. It gets the files and what to look up through a
//! socket that is its standard input, and answers there.

use std::fs::File;
use std::io::{self, IoSlice, IoSliceMut, Read as _, Write as _};
use std::mem::MaybeUninit;
use std::net::Shutdown;
use std::os::fd::{AsFd as _, BorrowedFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::Duration;

use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer,
    SendAncillaryMessage, SendFlags, recvmsg, sendmsg,
};
use rustix::process::{Resource, Rlimit, setpriority_process, setrlimit};
use thread_priority::{NormalThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy};

use super::symbols::{self, Contents};

/// The argument that makes the program do this.
const WORD: &str = "--read-symbols";

/// Most files of one question.
const FILES: usize = 128;
/// Most bytes of a question or an answer.
const BYTES: u64 = 1 << 20;
/// Most memory that it may take, in bytes.
const MEMORY: u64 = 1 << 30;
/// Most time of a processor that it may take, in seconds.
const PROCESSOR: u64 = 20;
/// Second argument: it runs as other processes do.
const NOW: &str = "now";
/// How long answers are waited for: first of a process that runs when nobody else wants the
/// processor; where somebody always does, of one that shares it with them.
const PATIENCE: [Duration; 2] = [Duration::from_secs(3), Duration::from_secs(60)];

/// What is asked of a file: the functions at these offsets in it.
pub(super) type Offsets = Vec<u64>;

/// Has files read; the answer has one element for each.
pub(super) fn look_up(program: &Path, asked: &[(&File, Offsets)]) -> io::Result<Vec<Contents>> {
    let asked = asked.get(..FILES).unwrap_or(asked);
    if asked.is_empty() {
        return Ok(Vec::new());
    }
    let answer = patiently(|words, patience| have_read(program, words, asked, patience));
    answer.map_err(|error| io::Error::other(format!("who reads them gives no answer: {error}")))
}

/// Has a process started with these words, which is given so much time; and another one if that was
/// not enough.
fn patiently<A>(mut read: impl FnMut(&[&str], Duration) -> io::Result<A>) -> io::Result<A> {
    let [first, last] = PATIENCE;
    match read(&[WORD], first) {
        Err(error) if error.kind() == io::ErrorKind::WouldBlock => read(&[WORD, NOW], last),
        answer => answer,
    }
}

fn have_read(
    program: &Path,
    words: &[&str],
    asked: &[(&File, Offsets)],
    patience: Duration,
) -> io::Result<Vec<Contents>> {
    let (mut ours, theirs) = UnixStream::pair()?;
    ours.set_read_timeout(Some(patience))?;
    let mut command = Command::new(program);
    command.args(words).stdin(OwnedFd::from(theirs)).stdout(Stdio::null());
    // Not in the group of the daemon, which may be stopped from a terminal meanwhile.
    let mut child = command.process_group(0).spawn()?;
    // Its end of the socket is the child's alone: when that ends, so does what is read.
    drop(command);
    let answer = ask(&mut ours, asked);
    if answer.is_err() {
        let _ = child.kill();
    }
    child.wait()?;
    answer
}

fn ask(socket: &mut UnixStream, asked: &[(&File, Offsets)]) -> io::Result<Vec<Contents>> {
    let files: Vec<BorrowedFd<'_>> = asked.iter().map(|(file, _)| file.as_fd()).collect();
    let offsets: Vec<&Offsets> = asked.iter().map(|(_, offsets)| offsets).collect();
    let mut room = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(FILES))];
    let mut ancillary = SendAncillaryBuffer::new(&mut room);
    ancillary.push(SendAncillaryMessage::ScmRights(&files));
    sendmsg(&*socket, &[IoSlice::new(&[0])], &mut ancillary, SendFlags::NOSIGNAL)?;
    socket.write_all(&serde_json::to_vec(&offsets)?)?;
    socket.shutdown(Shutdown::Write)?;
    let mut answer = Vec::new();
    socket.take(BYTES).read_to_end(&mut answer)?;
    let answer: Vec<Contents> = serde_json::from_slice(&answer)?;
    let fits = |(contents, offsets): (&Contents, &&Offsets)| {
        contents.functions.is_empty() || contents.functions.len() == offsets.len()
    };
    match answer.len() == files.len() && answer.iter().zip(&offsets).all(fits) {
        true => Ok(answer),
        false => Err(io::Error::other("its answer is to another question")),
    }
}

/// Does what this process was started for, if it was started to read symbols: called first.
#[must_use]
pub fn read_symbols() -> Option<ExitCode> {
    std::env::args_os().nth(1).filter(|word| word == WORD)?;
    let read = answer();
    Some(if read.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn answer() -> io::Result<()> {
    limit();
    if std::env::args_os().nth(2).is_none_or(|word| word != NOW) {
        step_back();
    }
    let mut socket = UnixStream::from(rustix::io::fcntl_dupfd_cloexec(rustix::stdio::stdin(), 3)?);
    let mut room = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(FILES))];
    let mut ancillary = RecvAncillaryBuffer::new(&mut room);
    let mut byte = [0];
    let flags = RecvFlags::CMSG_CLOEXEC;
    recvmsg(&socket, &mut [IoSliceMut::new(&mut byte)], &mut ancillary, flags)?;
    let rights = ancillary.drain().filter_map(|message| match message {
        RecvAncillaryMessage::ScmRights(files) => Some(files),
        _ => None,
    });
    let files: Vec<File> = rights.flatten().map(File::from).collect();
    let mut asked = Vec::new();
    (&socket).take(BYTES).read_to_end(&mut asked)?;
    let asked: Vec<Offsets> = serde_json::from_slice(&asked)?;
    let read: Vec<Contents> =
        files.iter().zip(&asked).map(|(f, at)| symbols::read(f, at)).collect();
    socket.write_all(&serde_json::to_vec(&read)?)
}

/// Runs when nobody else does. Where that is refused, it goes on as it is: what it does is short.
fn step_back() {
    let idle = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Idle);
    let thread = thread_priority::thread_native_id();
    let _ = setpriority_process(None, 19);
    let _ = thread_priority::set_thread_priority_and_policy(thread, ThreadPriority::Min, idle);
}

/// Takes no more than its part.
fn limit() {
    for (resource, most) in
        [(Resource::Data, MEMORY), (Resource::Cpu, PROCESSOR), (Resource::Core, 0)]
    {
        let _ = setrlimit(resource, Rlimit { current: Some(most), maximum: Some(most) });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_that_does_not_answer_is_told() {
        let own = File::open(std::env::current_exe().unwrap()).unwrap();
        let asked = [(&own, vec![0])];
        for (program, wanted) in [
            ("/no/program", "No such file"),
            ("/bin/false", "gives no answer"),
            ("/bin/true", "gives no answer"),
        ] {
            let refused = look_up(Path::new(program), &asked).unwrap_err().to_string();
            assert!(refused.contains(wanted), "{refused}");
        }
        assert_eq!(look_up(Path::new("/no/program"), &[]).unwrap(), []);
    }

    #[test]
    fn where_the_processor_is_always_wanted_another_process_reads_that_shares_it() {
        let (mut ours, _theirs) = UnixStream::pair().unwrap();
        ours.set_read_timeout(Some(Duration::from_millis(1))).unwrap();
        let own = File::open(std::env::current_exe().unwrap()).unwrap();
        let mut started = Vec::new();
        let answer = patiently(|words, _| {
            started.push(words.join(" "));
            match words.contains(&NOW) {
                true => Ok(vec![]),
                // Nobody answers.
                false => ask(&mut ours, &[(&own, vec![0])]),
            }
        });
        assert_eq!(answer.unwrap(), []);
        assert_eq!(started, ["--read-symbols", "--read-symbols now"]);
        let refused = patiently(|_, _| Err::<(), _>(io::ErrorKind::NotFound.into()));
        assert_eq!(refused.unwrap_err().kind(), io::ErrorKind::NotFound);
    }

    #[test]
    fn an_answer_to_another_question_is_refused() {
        let own = File::open(std::env::current_exe().unwrap()).unwrap();
        for (answer, fine) in [
            ("[]", false),
            (r#"[{"build_id": null, "functions": []}]"#, true),
            (r#"[{"build_id": null, "functions": [[1, null]]}]"#, true),
            (r#"[{"build_id": null, "functions": [[1, null], [2, null]]}]"#, false),
            ("garbage", false),
        ] {
            let (mut ours, theirs) = UnixStream::pair().unwrap();
            (&theirs).write_all(answer.as_bytes()).unwrap();
            theirs.shutdown(Shutdown::Write).unwrap();
            assert_eq!(ask(&mut ours, &[(&own, vec![0])]).is_ok(), fine, "{answer}");
        }
    }
}
