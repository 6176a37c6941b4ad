//! A directory of descriptions, and transcripts of genomctl run in it.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use expect_test::Expect;
use tempfile::TempDir;

/// A temporary directory with files.
pub(crate) struct Room(TempDir);

impl Room {
    pub(crate) fn new(files: &[(&str, &str)]) -> Self {
        let room = Self(tempfile::tempdir().unwrap());
        for (name, text) in files {
            room.write(name, text.as_bytes());
        }
        room
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: &[u8]) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    /// Runs `genomctl` in the directory; arguments are split at blanks.
    pub(crate) fn run(&self, words: &str, input: &str) -> (i32, String, String) {
        run(self.0.path(), words, input)
    }

    /// Compares the transcript of a command: output, errors after `!`, exit status if it is not 0.
    #[track_caller]
    pub(crate) fn check(&self, words: &str, shown: &Expect) {
        shown.assert_eq(&self.transcript(words, ""));
    }

    pub(crate) fn transcript(&self, words: &str, input: &str) -> String {
        let (code, out, err) = self.run(words, input);
        let mut text = out;
        for line in err.lines() {
            writeln!(text, "{}", format!("! {line}").trim_end()).unwrap();
        }
        if code != 0 {
            writeln!(text, "exit {code}").unwrap();
        }
        text
    }
}

fn run(directory: &Path, words: &str, input: &str) -> (i32, String, String) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_genomctl"))
        .args(words.split_whitespace())
        .current_dir(directory)
        .env_remove("GENOMD_SOCKET")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}
