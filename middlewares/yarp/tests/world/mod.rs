//! A genuine name server for each test, and genuine programs that know it.

#![allow(
    dead_code,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "shared by test programs, which use parts of it"
)]

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use genom_components::peer::Lines;
use genom_conformance::{World, eventually};
use genom_middleware::Middleware;
use genom_yarp::{Options, Yarp};
use tempfile::TempDir;

/// A name server, until this is dropped.
pub(crate) struct Place {
    folder: TempDir,
    programs: PathBuf,
    port: u16,
    server: Mutex<Option<Child>>,
}

/// Reads until these bytes have come, or the end. Returns all that came.
pub(crate) fn until(stream: &mut TcpStream, mark: &[u8]) -> std::io::Result<Vec<u8>> {
    let (mut got, mut piece) = (Vec::new(), [0; 4096]);
    loop {
        let size = stream.read(&mut piece)?;
        got.extend_from_slice(&piece[..size]);
        if size == 0 || has(&got, mark) {
            return Ok(got);
        }
    }
}

pub(crate) fn has(bytes: &[u8], mark: &[u8]) -> bool {
    bytes.windows(mark.len()).any(|window| window == mark)
}

/// A number that nothing listens at, below those that the system gives to connections.
fn free_port() -> u16 {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    loop {
        // Ports of genuine programs get the numbers after it.
        let next = NEXT.fetch_add(64, Ordering::Relaxed);
        let port = 11_000 + (std::process::id().wrapping_mul(6151) + next) % 20_000;
        let port = u16::try_from(port).unwrap();
        if TcpListener::bind(("0.0.0.0", port)).is_ok() {
            return port;
        }
    }
}

impl Place {
    pub(crate) fn new() -> Self {
        let place = Self::without_server();
        place.start();
        place
    }

    /// A place whose name server is not running yet.
    pub(crate) fn without_server() -> Self {
        let programs = genom_components::yarp::programs()
            .unwrap_or_else(|error| panic!("genuine YARP cannot be had: {error}"));
        let (folder, port) = (tempfile::tempdir().unwrap(), free_port());
        std::fs::write(folder.path().join("yarp.conf"), format!("127.0.0.1 {port} yarp\n"))
            .unwrap();
        Self { folder, programs, port, server: Mutex::new(None) }
    }

    /// Starts the name server, with an empty memory, and waits until it answers.
    pub(crate) fn start(&self) {
        let mut command = self.program("yarpserver");
        command.args(["--portdb", ":memory:", "--subdb", ":memory:", "--silent"]);
        command.args(["--ip", "127.0.0.1", "--socket", &self.port.to_string()]);
        // It ends where a file of YARP says otherwise than it would.
        command.env("YARP_CONFIG_HOME", self.folder.path().join("server"));
        let child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let child = child.spawn().unwrap();
        *self.server.lock().unwrap() = Some(child);
        eventually("the name server answers", || {
            let ended = self.server.lock().unwrap().as_mut().unwrap().try_wait().unwrap();
            assert_eq!(ended, None, "yarpserver ended");
            self.ask("query /root").is_ok_and(|answer| answer.contains("/root"))
        });
    }

    /// Ends the name server.
    pub(crate) fn stop(&self) {
        if let Some(mut server) = self.server.lock().unwrap().take() {
            server.kill().unwrap();
            server.wait().unwrap();
        }
    }

    pub(crate) fn pid(&self) -> u32 {
        self.server.lock().unwrap().as_ref().unwrap().id()
    }

    fn program(&self, name: &str) -> Command {
        let genuine = self.programs.join(name);
        let mut command = Command::new(if genuine.exists() { genuine } else { name.into() });
        command.env("YARP_CONFIG_HOME", self.folder.path());
        command.env("YARP_DATA_HOME", self.folder.path()).env("YARP_COLORED_OUTPUT", "0");
        command.current_dir(self.folder.path());
        command
    }

    /// The command `yarp` with these arguments.
    pub(crate) fn yarp(&self, arguments: &[&str]) -> Command {
        let mut command = self.program("yarp");
        command.args(arguments);
        command
    }

    /// A program that goes on, and that is talked with by lines, each of which it writes at once.
    pub(crate) fn peer(&self, arguments: &[&str]) -> Lines {
        let mut command = self.program("stdbuf");
        command.arg("-oL").arg(self.programs.join("yarp")).args(arguments).env("YARP_QUIET", "1");
        Lines::start(&mut command)
    }

    /// What a program that ends by itself prints.
    pub(crate) fn prints(&self, arguments: &[&str]) -> String {
        let output = self.yarp(arguments).stdin(Stdio::null()).output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        String::from_utf8_lossy(&said).into_owned()
    }

    /// Asks the name server, as people may with telnet.
    pub(crate) fn ask(&self, command: &str) -> std::io::Result<String> {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port))?;
        stream.set_read_timeout(Some(Duration::from_secs(10)))?;
        stream.write_all(format!("NAME_SERVER {command}\n").as_bytes())?;
        Ok(String::from_utf8_lossy(&until(&mut stream, b"*** end")?).into_owned())
    }

    /// Where a port listens.
    pub(crate) fn address_of(&self, name: &str) -> (String, u16) {
        let answer = self.ask(&format!("query {name}")).unwrap();
        let words: Vec<&str> = answer.split_ascii_whitespace().collect();
        let after = |word: &str| words[words.iter().position(|one| *one == word).unwrap() + 1];
        (after("ip").to_owned(), after("port").parse().unwrap())
    }

    pub(crate) fn options(&self) -> Options {
        Options { server: format!("127.0.0.1:{}", self.port), ..Options::default() }
    }

    pub(crate) fn open(&self) -> Arc<Yarp> {
        Yarp::open(&self.options()).unwrap()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.stop();
    }
}

impl World for Place {
    fn join(&self) -> Arc<dyn Middleware> {
        self.open()
    }

    fn leftovers(&self) -> Vec<String> {
        let list = self.ask("list").unwrap();
        let names = list.lines().filter_map(|line| line.split_ascii_whitespace().nth(2));
        let ours = names.filter(|name| name.starts_with('/') && *name != "/root");
        ours.map(str::to_owned).collect()
    }
}
