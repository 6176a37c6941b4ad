//! What a service manager (systemd) hears of a daemon that it started.

use std::os::linux::net::SocketAddrExt as _;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::time::Duration;

use genom_tests::{Home, Running, WATCHDOG, component, path, repository, until};

/// A service manager's socket, and how it is named in the environment.
struct Manager {
    socket: UnixDatagram,
    name: String,
}

impl Manager {
    fn new(home: &Home) -> Self {
        let name = home.path().join("notify");
        Self { socket: UnixDatagram::bind(&name).unwrap(), name: path(&name).to_owned() }
    }

    /// A socket without a file.
    fn abstract_one(home: &Home) -> Self {
        let name = path(home.path()).replace('/', "-");
        let address = SocketAddr::from_abstract_name(&name).unwrap();
        Self { socket: UnixDatagram::bind_addr(&address).unwrap(), name: format!("@{name}") }
    }

    /// Starts a daemon as such a manager does.
    fn starts(&self, home: &Home, watchdog_usec: u64, arguments: &[&str]) -> Running {
        let socket = format!("NOTIFY_SOCKET={}", self.name);
        let watchdog = format!("WATCHDOG_USEC={watchdog_usec}");
        let own: &[&str] = if watchdog_usec > 0 { &[&socket, &watchdog] } else { &[&socket] };
        home.spawn_by(&[&["env"], own].concat(), arguments)
    }

    /// The next message, if one comes within this time.
    fn hears_within(&self, longest: Duration) -> Option<String> {
        self.socket.set_read_timeout(Some(longest)).unwrap();
        let mut bytes = [0; 4096];
        let length = self.socket.recv(&mut bytes).ok()?;
        Some(String::from_utf8(bytes[..length].to_vec()).unwrap())
    }

    /// The next message that begins with this line.
    #[track_caller]
    fn hears(&self, wanted: &str) -> String {
        let mut heard = Vec::new();
        loop {
            match self.hears_within(WATCHDOG) {
                Some(text) if text.lines().next() == Some(wanted) => return text,
                Some(text) => heard.push(text),
                None => panic!("no {wanted} in {heard:#?}"),
            }
        }
    }

    /// Forgets what was told before.
    fn forgets(&self) {
        while self.hears_within(Duration::from_millis(1)).is_some() {}
    }
}

#[test]
fn a_service_manager_hears_what_is_loaded_that_the_daemon_is_ready_and_that_it_stops() {
    let home = Home::new();
    let manager = Manager::new(&home);
    let demo = component("demo").library;
    let daemon = manager.starts(&home, 0, &["--isolated", path(&demo)]);
    assert!(manager.hears("STATUS=loads demo").contains("EXTEND_TIMEOUT_USEC="));
    let ready = manager.hears("READY=1");
    assert_eq!(ready, format!("READY=1\nSTATUS=ready on {}", home.socket().display()));
    assert!(daemon.error_line_where(|line| line.contains("ready on ")).is_some());
    // A cell cannot speak for the daemon.
    let mut cell = home.socket().into_os_string();
    cell.push(".cells/demo/pid");
    let pid = std::fs::read_to_string(cell).unwrap();
    let environment = std::fs::read(format!("/proc/{pid}/environ")).unwrap();
    let environment = String::from_utf8_lossy(&environment).into_owned();
    assert!(environment.contains("PATH=") && !environment.contains("NOTIFY_SOCKET"));
    daemon.signal("TERM");
    assert!(manager.hears("STOPPING=1").contains("EXTEND_TIMEOUT_USEC="));
    daemon.finish().expect_code(0);
}

#[test]
fn a_daemon_whose_process_is_stopped_falls_silent_and_is_heard_again_when_it_goes_on() {
    let home = Home::new();
    let manager = Manager::abstract_one(&home);
    let demo = component("demo").library;
    // Every 100 ms.
    let daemon = manager.starts(&home, 200_000, &[path(&demo)]);
    manager.hears("READY=1");
    manager.hears("WATCHDOG=1");
    manager.hears("WATCHDOG=1");
    daemon.signal("STOP");
    let tasks = format!("/proc/{}/task", daemon.id());
    until("all its threads are stopped", || {
        let mut threads = std::fs::read_dir(&tasks).unwrap().flatten();
        threads.all(|thread| {
            let status = std::fs::read_to_string(thread.path().join("status"));
            status.is_ok_and(|status| status.contains("State:\tT"))
        })
    });
    manager.forgets();
    assert_eq!(manager.hears_within(Duration::from_secs(1)), None);
    daemon.signal("CONT");
    manager.hears("WATCHDOG=1");
    daemon.signal("TERM");
    manager.hears("STOPPING=1");
    daemon.finish().expect_code(0);
}

#[test]
fn a_codel_that_does_not_return_does_not_silence_the_daemon() {
    let home = Home::new();
    let manager = Manager::new(&home);
    let blocks = component("blocks").library;
    let running = manager.starts(&home, 200_000, &["--set", "stuck_after=1", path(&blocks)]);
    manager.hears("READY=1");
    let ask = r#"{}"#;
    let start = "/components/blocks/services/hang";
    let started = genom_tests::request(&home.socket(), "POST", start, ask);
    assert!(started.status < 300, "{started:?}");
    let stuck = running.error_line_where(|line| line.contains("is stuck"));
    assert!(stuck.is_some());
    manager.forgets();
    manager.hears("WATCHDOG=1");
}

#[test]
fn a_service_manager_hears_that_tokens_are_read_again() {
    use std::os::unix::fs::PermissionsExt as _;
    let home = Home::new();
    let manager = Manager::new(&home);
    let tokens = home.path().join("tokens.toml");
    std::fs::write(&tokens, "").unwrap();
    std::fs::set_permissions(&tokens, std::fs::Permissions::from_mode(0o600)).unwrap();
    let daemon = manager.starts(&home, 0, &["--token-file", path(&tokens)]);
    manager.hears("READY=1");
    daemon.signal("HUP");
    let reloading = manager.hears("RELOADING=1");
    let date = reloading.lines().find_map(|line| line.strip_prefix("MONOTONIC_USEC="));
    assert!(date.unwrap().parse::<u64>().unwrap() > 0);
    assert_eq!(manager.hears_within(WATCHDOG).as_deref(), Some("READY=1"));
    daemon.signal("TERM");
    daemon.finish().expect_code(0);
}

#[test]
fn the_unit_file_starts_the_daemon_with_options_that_it_has() {
    let text = std::fs::read_to_string(repository().join("configs/genomd.service")).unwrap();
    let help = Home::new().refused(&["--help"]);
    let commands = text.lines().filter_map(|line| line.split_once("ExecStart="));
    let commands: Vec<&str> = commands.map(|(_, command)| command).collect();
    assert_eq!(commands.len(), 2, "one for the machine, one for a user");
    for word in commands.iter().flat_map(|command| command.split(' ')) {
        assert!(!word.starts_with("--") || help.out.contains(word), "{word}");
    }
    for line in ["Type=notify", "KillMode=process", "Restart=on-failure", "OOMPolicy=continue"] {
        assert!(text.lines().any(|one| one == line), "{line}");
    }
}

#[test]
fn a_codel_that_holds_up_the_thread_of_all_components_silences_the_daemon_until_it_returns() {
    let home = Home::new();
    let manager = Manager::new(&home);
    let blocks = component("blocks").library;
    let file = home.path().join("go");
    // Every 100 ms.
    let arguments = ["--execution", "single", path(&blocks)];
    let running = manager.starts(&home, 200_000, &arguments);
    manager.hears("READY=1");
    manager.hears("WATCHDOG=1");
    let inputs = serde_json::json!({"file": path(&file)}).to_string();
    let ask = "/components/blocks/services/hang_until";
    let started = genom_tests::request(&home.socket(), "POST", ask, &inputs);
    assert!(started.status < 300, "{started:?}");
    running.error_line_where(|line| line.contains("the control thread of all components")).unwrap();
    manager.forgets();
    assert_eq!(manager.hears_within(Duration::from_secs(1)), None);
    std::fs::write(&file, "").unwrap();
    manager.hears("WATCHDOG=1");
    running.signal("TERM");
    manager.hears("STOPPING=1");
    running.finish().expect_code(0);
}
