//! Formulas that Spin checks for `genomctl verify`, since they are of no form that is built in.

use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

use crate::support::Room;

const DUO: &str = "component duo {
  ids { long shared; };
  task fast { period 10 ms; codel<start> fa(inout shared) yield pause::start wcet 3 ms; };
  task slow { period 40 ms; codel<start> sb(inout shared) yield work wcet 8 ms;
    codel<work> sw() yield pause::start wcet 20 ms; };
};
";

/// The exit status, and what is said of a formula about the component.
fn verify(room: &Room, formula: &str, path: &OsString) -> (i32, Value) {
    let of = ["--json", "verify", "duo.gen", "--no-standard-interface", "--property", "order"];
    // However slow the machine is.
    let arguments = [&of[..], &["--time", "300", "--ltl", formula]].concat();
    let output = Command::new(env!("CARGO_BIN_EXE_genomctl"))
        .args(arguments)
        .current_dir(room.path(""))
        .env("PATH", path)
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    let said: Value = serde_json::from_str(&text).unwrap_or_else(|why| panic!("{why}: {error}"));
    let all = &said["components"][0]["formulas"];
    assert_eq!(all.as_array().map(Vec::len), Some(1), "{said}");
    (output.status.code().unwrap(), all[0].clone())
}

/// The `PATH` of this process, with Spin.
fn with_spin() -> OsString {
    let spin = genom_components::debian::spin().unwrap_or_else(|error| panic!("{error}"));
    let usual = std::env::var_os("PATH").unwrap_or_default();
    let own = spin.parent().map(Path::to_owned).into_iter();
    std::env::join_paths(own.chain(std::env::split_paths(&usual))).unwrap()
}

/// Each call of `sb` goes on until `sw` is called, which comes next; and until `fa` is, which need
/// not come in that time.
const HOLDS: &str = "[] (codel(sb) -> (codel(sb) U !codel(sb)))";
const FAILS: &str = "[] (codel(sb) -> (codel(sb) U codel(fa)))";

#[test]
fn a_formula_of_another_form_holds_or_not_as_spin_says() {
    let room = Room::new(&[("duo.gen", DUO)]);
    let path = with_spin();
    let (status, said) = verify(&room, HOLDS, &path);
    assert_eq!((status, &said["verdict"]), (0, &json!("holds")), "{said}");
    let (status, said) = verify(&room, FAILS, &path);
    assert_eq!((status, &said["verdict"]), (1, &json!("violated")), "{said}");
    let what = said["findings"][0]["what"].as_str().unwrap();
    assert!(what.starts_with("Spin has a run in which `"), "{what}");
    assert!(what.contains("genomctl model --format promela"), "{what}");
}

#[test]
fn without_spin_a_formula_of_another_form_is_not_decided_and_the_way_out_is_told() {
    let room = Room::new(&[("duo.gen", DUO)]);
    let empty = tempfile::tempdir().unwrap();
    for formula in [HOLDS, FAILS] {
        let (status, said) = verify(&room, formula, &empty.path().into());
        assert_eq!((status, &said["verdict"]), (4, &json!("undecided")), "{said}");
        let why = said["why"].as_str().unwrap();
        assert!(why.contains("`spin` and `cc` on the PATH (Debian: spin, gcc)"), "{why}");
    }
    // Of a form that is built in, nothing is needed.
    let (status, said) = verify(&room, "[] !(codel(fa) && codel(sb))", &empty.path().into());
    assert_eq!((status, &said["verdict"]), (0, &json!("holds")), "{said}");
}
