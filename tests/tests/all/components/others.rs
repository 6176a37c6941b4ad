//! Components written as others do for GenoM3, with habits that `components/` does not show.

use std::fs;
use std::process::Command;

use genom_tests::{Daemon, Finished, Home, fixture, path, repository};
use serde_json::{Value, json};

/// Output of an activity, after waiting until it is done.
fn outputs(daemon: &Daemon, arguments: &[&str]) -> Finished {
    let finished = daemon.ctl(&[&["start", "--wait"], arguments].concat());
    finished.expect_code(0);
    finished
}

/// Camera components distinguish streams of one port by names such as `left/jpeg`.
#[test]
fn elements_of_a_port_have_slashes_in_their_names_on_every_middleware_of_one_machine() {
    let made = tempfile::tempdir().unwrap();
    let (camera, viewer) =
        (fixture("others", "camera", made.path()), fixture("others", "viewer", made.path()));
    for backend in ["local", "shm", "zenoh"] {
        let daemon = Daemon::start(&["--backend", backend, &camera, &viewer]);
        for name in ["left", "left/jpeg"] {
            outputs(&daemon, &["camera", "add", &format!("name={name}")]);
        }
        let ports = daemon.json(&["ports", "camera"]);
        let addresses: Vec<&Value> =
            ports["ports"].as_array().unwrap().iter().map(|port| &port["address"]).collect();
        for address in ["camera/image/left", "camera/image/left/jpeg"] {
            assert!(addresses.contains(&&json!(address)), "{backend}: {ports}");
        }
        let ends = ["connect", "viewer/image/right/jpeg", "camera/image/left/jpeg"];
        daemon.ctl(&ends).expect_code(0);
        let seen = outputs(&daemon, &["viewer", "see", "name=right/jpeg"]);
        let image = "\"pixels\":[7,7,7],\"gains\":[0.0,0.5]";
        assert!(seen.out.contains(image), "{backend}: {}", seen.out);
        daemon.ctl(&["echo", "-n", "1", "camera/image/left/jpeg"]).expect_code(0);
        // The kept value shares memory with its port; it must be freed once.
        daemon.ctl(&["unload", "viewer"]).expect_code(0);
        daemon.ctl(&["kill"]).expect_code(0);
        daemon.finish().0.expect_code(0);
    }
}

#[test]
fn a_closed_element_leaves_the_list_and_is_waited_for_with_a_word() {
    let made = tempfile::tempdir().unwrap();
    let camera = fixture("others", "camera", made.path());
    for backend in ["local", "shm"] {
        let daemon = Daemon::start(&["--backend", backend, &camera]);
        let listed = || daemon.ctl(&["ports", "camera"]).out.clone();
        for name in ["left", "right"] {
            outputs(&daemon, &["camera", "add", &format!("name={name}")]);
        }
        assert!(
            listed().contains("camera/image/left ") && listed().contains("camera/image/right ")
        );
        outputs(&daemon, &["camera", "drop", "name=left"]);
        assert!(!listed().contains("camera/image/left"), "{}", listed());
        assert!(listed().contains("camera/image/right "), "{}", listed());
        // `echo` says that the element does not exist, and prints it when it comes back.
        let echo = daemon.spawn(&["echo", "-n", "1", "camera/image/left"]);
        let waits = "camera/image has no element `left` yet: waiting for it; there is right";
        assert!(echo.error_line_where(|line| line.contains(waits)).is_some());
        outputs(&daemon, &["camera", "add", "name=left"]);
        echo.finish().expect_code(0);
        assert!(listed().contains("camera/image/left "));
        daemon.stop("TERM").0.expect_code(0);
    }
}

/// `genomd .libs/libx_codels.so` in folder `codels` of a project, as after `make`.
#[test]
fn a_library_is_loaded_by_its_relative_path_from_within_its_folder() {
    let home = Home::new();
    let _ = fixture("others", "camera", home.path());
    let libs = home.path().join("codels/.libs");
    fs::create_dir_all(&libs).unwrap();
    fs::rename(home.path().join("camera.so"), libs.join("libcamera_codels.so")).unwrap();
    for (folder, library) in
        [("codels", ".libs/libcamera_codels.so"), ("codels/.libs", "libcamera_codels.so")]
    {
        let within = format!("--chdir={}", path(&home.path().join(folder)));
        let checked = home.spawn_by(&["env", &within], &["--check", library]).finish();
        checked.expect_code(0);
        assert!(checked.out.starts_with(&format!("{library} fits ")), "{}", checked.out);
    }
}

#[test]
fn a_symbol_of_the_components_own_sources_is_not_looked_for_in_other_libraries() {
    let home = Home::new();
    let file = |name: &str| home.path().join(name);
    fs::create_dir_all(file("codels/.libs")).unwrap();
    fs::write(file("alone.gen"), "component alone { function f() { codel alone_f(); }; };")
        .unwrap();
    let main = "#include \"genom3/c/exception.h\"\nint alone_help(int x);\nint elsewhere(void);\n\
                genom_event alone_f(const genom_context self)\n\
                { (void)self; CALL; return genom_ok; }\n";
    fs::write(file("codels/helpers.c"), "int alone_help(int x)\n{ return x; }\n").unwrap();
    let said = |call: &str| {
        fs::write(file("codels/main.c"), main.replace("CALL", call)).unwrap();
        let mut compiler = Command::new("cc");
        compiler
            .args(["-g", "-fPIC", "-shared", "-I"])
            .arg(repository().join("plugin-api/include"));
        compiler.arg(file("codels/main.c")).arg("-o").arg(file("codels/.libs/libalone_codels.so"));
        assert!(compiler.status().unwrap().success());
        let refused = home.refused(&["--check", path(&file("alone.gen"))]);
        refused.expect_code(1);
        refused.err
    };
    let own = said("alone_help(1)");
    let told = "undefined symbol `alone_help`: ";
    assert!(own.contains(told) && own.contains("codels/helpers.c defines it"), "{own}");
    let others = said("elsewhere()");
    let told = "undefined symbol `elsewhere`: link the library that defines it (codels-require)";
    assert!(others.contains(told), "{others}");
}

#[test]
fn a_name_that_would_break_an_address_is_told_to_the_codel() {
    let made = tempfile::tempdir().unwrap();
    let daemon = Daemon::start(&[&fixture("others", "camera", made.path())]);
    for name in ["/left", "left/", "left//jpeg"] {
        let refused = daemon.ctl(&["start", "--wait", "camera", "add", &format!("name={name}")]);
        refused.expect_code(1).expect_err(&format!("{{\"code\":22,\"what\":\"{name}\"}}"));
    }
}

/// genom3.md 5.4: helpers throw with errno, and without a detail.
#[test]
fn exceptions_are_thrown_with_errno_or_without_a_detail() {
    let made = tempfile::tempdir().unwrap();
    let daemon = Daemon::start(&[&fixture("others", "camera", made.path())]);
    let failed = daemon.ctl(&["call", "camera", "fail", "detailed=true"]);
    failed.expect_code(1).expect_err("::camera::e_sys {\"code\":2,\"what\":\"lens\"}");
    let bare = daemon.ctl(&["call", "camera", "fail", "detailed=false"]);
    bare.expect_code(1).expect_err("::camera::e_sys {\"code\":0,\"what\":\"\"}");
    daemon.ctl(&["call", "camera", "idle"]).expect_code(0);
}

/// Codels of mobile bases leave a thread behind that has the address of the IDS.
#[test]
fn a_thread_that_a_codel_left_behind_does_not_take_the_daemon_along() {
    let made = tempfile::tempdir().unwrap();
    let reader = fixture("others", "reader", made.path());
    let daemon = Daemon::start(&[&reader]);
    for _ in 0..3 {
        daemon.ctl(&["call", "reader", "count"]).expect_code(0);
        daemon.ctl(&["unload", "reader"]).expect_code(0);
        let told = daemon
            .process()
            .error_line_where(|line| line.contains("threads that it started run on"));
        assert!(told.is_some(), "the daemon ended");
        daemon.ctl(&["load", &reader]).expect_code(0);
    }
    daemon.ctl(&["kill"]).expect_code(0);
    daemon.finish().0.expect_code(0);
}

/// genom3.md 5.9: in the source tree, where libtool puts the library, and installed under a prefix.
#[test]
fn a_project_of_genom3_is_found_from_its_library_and_from_its_description() {
    let made = tempfile::tempdir().unwrap();
    let built = fixture("others", "reader", made.path());
    let home = Home::new();
    for (library, description) in [
        ("tree/codels/.libs/libreader_codels.so", "tree/reader.gen"),
        ("prefix/lib/libreader_codels.so", "prefix/share/idl/reader/reader.gen"),
        (
            "machine/lib/x86_64-linux-gnu/libreader_codels-1.2.so",
            "machine/share/idl/reader/reader.gen",
        ),
    ] {
        let (library, description) = (made.path().join(library), made.path().join(description));
        for (from, to) in [(built.replace(".gen", ".so"), &library), (built.clone(), &description)]
        {
            fs::create_dir_all(to.parent().unwrap()).unwrap();
            fs::copy(from, to).unwrap();
        }
        home.refused(&["--check", path(&library)]).expect_code(0);
        if !library.starts_with(made.path().join("machine")) {
            home.refused(&["--check", path(&description)]).expect_code(0);
        }
    }
}
