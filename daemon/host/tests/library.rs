//! Libraries: which ones open, and how others are refused.

mod support;

use std::path::Path;

use expect_test::expect;
use genom_host::library::{Contents, Library, OpenError};
use support::Scratch;

/// The message of a refusal, without the directory.
#[track_caller]
fn refusal(scratch: &Scratch, path: &Path) -> String {
    let refused = Library::open(path).err().map(|error| error.to_string());
    refused.unwrap_or_default().replace(&format!("{}/", scratch.path().display()), "")
}

#[test]
fn a_missing_file_is_named() {
    let scratch = Scratch::new();
    expect!["demo.so: no such file: build the component, or give the path of its library"]
        .assert_eq(&refusal(&scratch, &scratch.path().join("demo.so")));
}

#[test]
fn a_text_renamed_so_is_no_library() {
    let scratch = Scratch::new();
    let path = scratch.file("demo.so", b"component demo { };");
    expect!["demo.so: no library: it looks like text, a shared object (ELF) is needed"]
        .assert_eq(&refusal(&scratch, &path));
    let path = scratch.file("empty.so", b"");
    expect!["empty.so: no library: it is empty, a shared object (ELF) is needed"]
        .assert_eq(&refusal(&scratch, &path));
}

#[test]
fn a_library_of_another_machine_names_both() {
    let scratch = Scratch::new();
    let mut header = [0_u8; 64];
    header[..6].copy_from_slice(b"\x7fELF\x02\x01");
    header[16] = 3; // ET_DYN
    // EM_AARCH64, or EM_X86_64 on an aarch64 machine.
    let (number, name) =
        if cfg!(target_arch = "aarch64") { (62, "x86_64") } else { (183, "aarch64") };
    header[18] = number;
    let path = scratch.file("demo.so", &header);
    let said = refusal(&scratch, &path);
    let ours = std::env::consts::ARCH;
    assert_eq!(
        said,
        format!(
            "demo.so: built for {name}, this machine is {ours}: rebuild it here or \
             cross-compile it for {ours}"
        )
    );
}

#[test]
fn an_object_file_and_a_truncated_library_are_refused_before_the_linker_sees_them() {
    let scratch = Scratch::new();
    let object = scratch.cc("demo.o", "int x;", &["-c"]);
    expect!["demo.o: an object file (.o), not a shared object: link it with -shared"]
        .assert_eq(&refusal(&scratch, &object));

    let whole = scratch.library("whole.so", "int data[4096] = { 1 };");
    let bytes = std::fs::read(whole).unwrap();
    let path = scratch.file("cut.so", &bytes[..bytes.len() / 3]);
    assert!(matches!(Library::open(&path), Err(OpenError::Truncated { .. })));
    for length in [4, 19, 20, 63, 64, 200] {
        let path = scratch.file("cut.so", &bytes[..length]);
        assert!(Library::open(&path).is_err(), "{length} bytes");
    }
}

#[cfg(target_pointer_width = "64")]
#[test]
fn a_library_with_damaged_headers_is_refused_before_the_linker_sees_it() {
    let scratch = Scratch::new();
    let bytes = std::fs::read(scratch.library("whole.so", "int x(void) { return 1; }")).unwrap();
    let damaged = |at: usize, with: &[u8]| {
        let mut bytes = bytes.clone();
        bytes[at..at + with.len()].copy_from_slice(with);
        refusal(&scratch, &scratch.file("damaged.so", &bytes))
    };
    // The first program header, which loads the tables of the dynamic linker.
    let said = damaged(64, &[0; 4]);
    assert!(said.starts_with("damaged.so: damaged: entry 0x"), "{said}");
    assert!(said.ends_with(", where nothing is"), "{said}");
    // Its address, and its size in memory.
    for (at, with) in [(64 + 16, [0xff; 8]), (64 + 40, [0; 8])] {
        let said = damaged(at, &with);
        assert!(said.starts_with("damaged.so: damaged: its segment at 0x"), "{said}");
    }
    // The offset of the program headers.
    assert!(damaged(32, &[0xff; 8]).starts_with("damaged.so: damaged: "));
}

#[test]
fn an_undefined_symbol_and_a_missing_dependency_are_named() {
    let scratch = Scratch::new();
    let path = scratch.library("demo.so", "int missing(void); int f(void) { return missing(); }");
    expect![
        "demo.so: undefined symbol `missing`: link the library that defines it (codels-require)"
    ]
    .assert_eq(&refusal(&scratch, &path));

    let dependency = scratch.library("libgone.so", "int g(void) { return 1; }");
    let linked = scratch.cc(
        "needs.so",
        "int g(void); int f(void) { return g(); }",
        &["-shared", "-fPIC", &format!("-L{}", scratch.path().display()), "-lgone"],
    );
    std::fs::remove_file(dependency).unwrap();
    expect!["needs.so: needs `libgone.so`, which is not found: install it, or link with an rpath"]
        .assert_eq(&refusal(&scratch, &linked));
}

#[test]
fn a_library_finds_another_by_origin() {
    let scratch = Scratch::new();
    std::fs::create_dir(scratch.path().join("deps")).unwrap();
    scratch.library("deps/libother.so", "int g(void) { return 1; }");
    let path = scratch.cc(
        "demo.so",
        "int g(void); int f(void) { return g(); }",
        &[
            "-shared",
            "-fPIC",
            &format!("-L{}", scratch.path().join("deps").display()),
            "-lother",
            "-Wl,-rpath,$ORIGIN/deps",
        ],
    );
    let library = Library::open(&path).unwrap();
    assert_eq!(library.path(), path);
    let left = std::fs::read_dir(scratch.path()).unwrap().flatten();
    let hidden = left.filter(|entry| entry.file_name().to_string_lossy().starts_with('.'));
    assert_eq!(hidden.count(), 0, "the copy beside the original loses its name at once");
}

/// Environment variable with the library that a child of this test opens.
const NAMED: &str = "GENOM_TEST_LIBRARY";

#[test]
fn a_library_that_another_test_names_opens() {
    let scratch = Scratch::new();
    let named = std::env::var_os(NAMED).map(std::path::PathBuf::from);
    let path = named.unwrap_or_else(|| scratch.library("demo.so", "int f(void) { return 1; }"));
    Library::open(&path).unwrap();
}

#[test]
fn a_library_opens_where_the_temporary_directory_is_mounted_noexec() {
    // In a mount namespace, where the system allows one; the fallback is also tested without
    // (`library::tests`).
    let scratch = Scratch::new();
    let path = scratch.library("demo.so", "int f(void) { return 1; }");
    let temporary = scratch.path().join("temporary");
    std::fs::create_dir(&temporary).unwrap();
    let mount = "mount -t tmpfs -o noexec none \"$TMPDIR\" || exit 77; exec \"$@\"";
    let mut inside = std::process::Command::new("unshare");
    inside.args(["--user", "--map-root-user", "--mount", "sh", "-c", mount, "sh"]);
    inside.arg(std::env::current_exe().unwrap());
    inside.args(["--exact", "a_library_that_another_test_names_opens", "--nocapture"]);
    inside.env("TMPDIR", &temporary).env(NAMED, &path);
    let output = inside.output().unwrap();
    let said = format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    if said.contains("running 1 test") {
        assert!(output.status.success(), "{said}");
    } else {
        println!("no namespace with a file system of its own here: {said}");
    }
}

#[test]
fn an_embedded_description_is_read_without_running_constructors() {
    let scratch = Scratch::new();
    let marker = scratch.path().join("ran");
    let path = scratch.library(
        "demo.so",
        &format!(
            r#"
            #include <stdio.h>
            const char genom_description[] = "component demo {{\n}};\n";
            const char genom_description_name[] = "demo.gen";
            __attribute__((constructor)) static void run(void) {{
                fclose(fopen("{}", "w"));
            }}"#,
            marker.display()
        ),
    );
    let found = Contents::read(&path).unwrap().description().unwrap().unwrap();
    assert_eq!(found.text, "component demo {\n};\n");
    assert_eq!(found.name.as_deref(), Some("demo.gen"));
    assert!(!marker.exists());

    let library = Library::open(&path).unwrap();
    assert!(marker.exists(), "constructors run when it is loaded");
    assert_eq!(library.description().unwrap(), Some(found));
}

#[test]
fn a_library_without_description_has_none() {
    let scratch = Scratch::new();
    let path = scratch.library("demo.so", "int f(void) { return 1; }");
    assert_eq!(Contents::read(&path).unwrap().description().unwrap(), None);
}

#[test]
fn a_description_that_is_no_text_is_refused() {
    let scratch = Scratch::new();
    let path = scratch.library("demo.so", r#"const char genom_description[] = "\xff\xfe";"#);
    let read = Contents::read(&path).unwrap().description();
    assert!(matches!(read, Err(OpenError::Description { .. })));
}

#[test]
fn a_library_with_a_thread_of_its_own_ends_it_when_it_is_closed() {
    let scratch = Scratch::new();
    let (made, ended) = (scratch.path().join("made"), scratch.path().join("ended"));
    let path = scratch.cc(
        "demo.so",
        &format!(
            r#"
            #include <pthread.h>
            #include <semaphore.h>
            #include <stdio.h>
            static pthread_t thread; static sem_t stop;
            static void *run(void *_) {{ sem_wait(&stop); return 0; }}
            __attribute__((constructor)) static void make(void) {{
                sem_init(&stop, 0, 0);
                if (!pthread_create(&thread, 0, run, 0)) fclose(fopen("{}", "w"));
            }}
            __attribute__((destructor)) static void end(void) {{
                sem_post(&stop);
                if (!pthread_join(thread, 0)) fclose(fopen("{}", "w"));
            }}"#,
            made.display(),
            ended.display()
        ),
        &["-shared", "-fPIC", "-pthread"],
    );
    let library = Library::open(&path).unwrap();
    assert!(made.exists() && !ended.exists());
    drop(library);
    assert!(ended.exists());
}

#[test]
fn two_loads_of_one_file_share_nothing_and_a_rebuilt_one_loads_anew() {
    let scratch = Scratch::new();
    let first = scratch.library("demo.so", r#"const char genom_description[] = "one";"#);
    let one = Library::open(&first).unwrap();
    let again = Library::open(&first).unwrap();
    scratch.library("demo.so", r#"const char genom_description[] = "two";"#);
    let two = Library::open(&first).unwrap();
    let text = |library: &Library| library.description().unwrap().unwrap().text;
    assert_eq!([&one, &again, &two].map(text), ["one", "one", "two"]);
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap();
    let copies: std::collections::HashSet<_> = maps
        .lines()
        .filter_map(|line| line.split_once("/genomd-library-"))
        .filter(|(_, rest)| rest.ends_with("-demo.so"))
        .map(|(_, rest)| rest.to_owned())
        .collect();
    assert!(copies.len() >= 3, "{copies:?}");
}
