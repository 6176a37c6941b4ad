//! What cells refuse, and what cannot be done to them.

use std::fs;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::Path;
use std::process::Command;

use genom_tests::{Daemon, Home, component, path, until};
use serde_json::json;

use super::{files, load, signal};

#[test]
fn names_that_are_none_or_are_taken_are_refused() {
    let demo = component("demo");
    let daemon = Daemon::demo("local");
    let into = |cell: &str, name: &str| {
        daemon.ctl(&["load", path(&demo.library), "--name", name, "--cell", cell])
    };
    into("../up", "far").expect_code(1).expect_err("is no name of a cell");
    into("arm", "demo").expect_code(1).expect_err("a component named demo runs");
    into("arm", "far").expect_code(0);
    daemon
        .ctl(&["load", path(&demo.library), "--name", "far"])
        .expect_code(1)
        .expect_err("a component named far runs");
    daemon.ctl(&["cells", "--end", "amr"]).expect_code(1).expect_err("did you mean `arm`?");
}

#[test]
fn a_component_that_is_refused_leaves_no_cell() {
    let daemon = Daemon::start(&[]);
    daemon.ctl(&["load", "nothing", "--cell", "arm"]).expect_code(1).expect_err("no library");
    assert_eq!(daemon.json(&["cells"])["cells"], json!([]));
    assert!(!files(&daemon).exists());
}

#[test]
fn nobody_else_gets_at_the_sockets_of_cells() {
    let daemon = Daemon::start(&[]);
    load(&daemon, "demo", &["--isolated"]);
    let all = files(&daemon);
    for directory in [all.clone(), all.join("demo")] {
        assert_eq!(fs::metadata(directory).unwrap().permissions().mode() & 0o777, 0o700);
    }
    let socket = fs::metadata(all.join("demo/socket")).unwrap();
    assert_eq!(socket.permissions().mode() & 0o777, 0o600);
}

#[test]
fn a_cell_that_puts_links_and_pipes_in_place_of_its_files_has_nothing_else_read_or_written() {
    const FILES: [&str; 5] = ["journal.toml", "config.toml", "note", "pid", "broken-rule"];
    // What the daemon would do with it if it read it.
    let secret_text = format!("[[component]]\nlibrary = {:?}\n", component("mission").library);
    for put in ["link", "pipe", "directory"] {
        let daemon = Home::new().configured("[cells]\nrestart_delay = 0.0\n").start(&[]);
        load(&daemon, "demo", &["--name", "bystander", "--cell", "beside"]);
        load(&daemon, "demo", &["--cell", "arm"]);
        let mut events = daemon.events();
        let (place, secret) = (files(&daemon).join("arm"), daemon.home().path().join("secret"));
        fs::write(&secret, &secret_text).unwrap();
        // A process that is stopped writes nothing over it.
        signal(&daemon, "arm", "STOP");
        let prepared = FILES.map(|name| format!("{name}.new"));
        for name in FILES.into_iter().chain(prepared.iter().map(String::as_str)) {
            let path = place.join(name);
            let _ = fs::remove_file(&path);
            match put {
                "link" => symlink(&secret, &path).unwrap(),
                "pipe" => pipe(&path),
                _ => fs::create_dir(&path).unwrap(),
            }
        }
        signal(&daemon, "arm", "KILL");
        events.wait_for(|e| e["event"] == "cell_ended" && e["cell"] == "arm");
        // It answers, and whoever is beside it goes on.
        daemon.ctl(&["call", "bystander", "get_speed"]).expect_code(0);
        // The cell fails, since nothing says what it held; one that is begun anew has new files.
        until("it is seen to hold nothing", || {
            daemon.json(&["cells"])["cells"].as_array().unwrap().iter().all(|cell| {
                cell["name"] != "arm"
                    || cell["state"] == "failed" && cell["components"] == json!([])
            })
        });
        assert!(daemon.json(&["list"])["components"].as_array().unwrap().len() == 1, "{put}");
        assert_eq!(fs::read_to_string(&secret).unwrap(), secret_text, "{put}");
        let home = daemon.abandon();
        let daemon = home.start(&[]);
        until("the next daemon goes on with what is beside it", || {
            daemon.ctl(&["call", "bystander", "get_speed"]).code == Some(0)
        });
        assert_eq!(fs::read_to_string(&secret).unwrap(), secret_text, "{put}");
    }
}

fn pipe(path: &Path) {
    let made = Command::new("mkfifo").arg(path).status();
    assert!(made.unwrap().success());
}
