//! Reading ends for every text, without a panic.

#![allow(clippy::unwrap_used, clippy::panic)]

mod grammar;

use std::sync::mpsc;
use std::time::Duration;

use genom_description::{Options, read_text};
use proptest::prelude::*;

/// Runs `f` on a thread with the stack of a test, and fails if it does not return.
fn bounded(f: impl FnOnce() + Send + 'static) {
    let (done, wait) = mpsc::channel();
    let worker = std::thread::spawn(move || {
        f();
        let _ = done.send(());
    });
    match wait.recv_timeout(Duration::from_secs(120)) {
        Ok(()) | Err(mpsc::RecvTimeoutError::Disconnected) => worker.join().unwrap(),
        Err(mpsc::RecvTimeoutError::Timeout) => panic!("reading does not end"),
    }
}

fn read_whatever(text: &str) {
    let analysis = read_text("fuzz.gen", text, &Options::default());
    for diagnostic in &analysis.diagnostics {
        assert!(!diagnostic.message.is_empty());
    }
    // The model is consistent, also when the text is refused: every index is valid.
    for c in &analysis.specification.components {
        assert_eq!(c.exclusion.len(), c.codels.len() + c.services.len());
        for service in &c.services {
            assert!(service.task.is_none_or(|task| c.tasks.get(task).is_some()));
            assert!(
                service
                    .codels
                    .iter()
                    .chain(&service.validates)
                    .all(|ix| c.codels.get(*ix).is_some())
            );
            assert!(service.interrupts.iter().all(|ix| c.services.get(*ix).is_some()));
        }
    }
}

/// Real descriptions, to be damaged.
fn seeds() -> Vec<String> {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut texts = vec![std::fs::read_to_string(root.join("tests/model/everything.gen")).unwrap()];
    for name in ["figure-2010.gen", "figure-2011.gen"] {
        texts.push(std::fs::read_to_string(root.join("tests/papers").join(name)).unwrap());
    }
    texts
}

#[test]
fn random_bytes_end() {
    bounded(|| {
        let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig {
            cases: 300,
            failure_persistence: None,
            ..ProptestConfig::default()
        });
        runner
            .run(&proptest::collection::vec(any::<u8>(), 0..400), |bytes| {
                read_whatever(&String::from_utf8_lossy(&bytes));
                Ok(())
            })
            .unwrap();
    });
}

#[test]
fn damaged_descriptions_end() {
    bounded(|| {
        let seeds = seeds();
        let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig {
            cases: 300,
            failure_persistence: None,
            ..ProptestConfig::default()
        });
        let cut = (0..seeds.len(), any::<prop::sample::Index>(), 0usize..40, "[ -~]{0,8}");
        runner
            .run(&cut, |(seed, at, length, text)| {
                let mut bytes = seeds[seed].clone().into_bytes();
                let at = at.index(bytes.len());
                let end = (at + length).min(bytes.len());
                bytes.splice(at..end, text.bytes());
                read_whatever(&String::from_utf8_lossy(&bytes));
                Ok(())
            })
            .unwrap();
    });
}

#[test]
fn descriptions_made_of_the_grammars_words_end() {
    bounded(|| {
        let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig {
            cases: 400,
            failure_persistence: None,
            ..ProptestConfig::default()
        });
        runner
            .run(&grammar::specification(), |text| {
                read_whatever(&text);
                Ok(())
            })
            .unwrap();
    });
}

#[test]
fn every_beginning_of_a_description_ends() {
    bounded(|| {
        for text in seeds() {
            let ends: Vec<usize> = text.char_indices().map(|(at, _)| at).step_by(7).collect();
            for end in ends {
                read_whatever(&text[..end]);
            }
        }
    });
}

#[test]
fn what_repeats_without_end_is_refused_without_overflow() {
    bounded(|| {
        for piece in [
            "(",
            "[",
            "{",
            "<",
            "sequence<",
            "optional<",
            "module m { ",
            "struct s { ",
            "- ",
            "1 + ",
            "component c { ",
            "union u switch(long) { case 1: ",
            "const long a = (",
            "::",
            ".",
            ", ",
            "#include \"fuzz.gen\"\n",
            "typedef long a",
            "component c { function f(in long a = { ",
            "component c { task t { codel<start> x(",
            ">>",
            "a::",
            "\"x\" ",
            "component c { ids { ",
        ] {
            read_whatever(&piece.repeat(20_000 / piece.len().max(1)));
            read_whatever(&format!("const long a = {};", piece.repeat(5_000)));
        }
    });
}

#[test]
fn long_chains_of_names_are_refused_without_overflow() {
    bounded(|| {
        let link = |n: usize| format!("struct s{n} {{ s{} x; }};\n", n.saturating_sub(1));
        read_whatever(&format!("typedef long s0;\n{}", (1..5_000).map(link).collect::<String>()));
        let link = |n: usize| format!("struct t{n}; struct u{n} {{ sequence<t{n}> x; }};\n");
        let ends = |n: usize| format!("struct t{n} {{ u{} x; }};\n", n + 1);
        let count = 3_000;
        let text: String = (0..=count).map(link).chain((0..count).rev().map(ends)).collect();
        read_whatever(&format!("{text} component c {{ port out t0 p; function f(in t0 a); }};"));
        let doubled = |n: usize| format!("struct d{n} {{ d{} a, b; }};\n", n.saturating_sub(1));
        let text: String = (1..90).map(doubled).collect();
        read_whatever(&format!(
            "typedef long d0;\n{text} component c {{ function f(in d89 a); port out d89 p; }};"
        ));
    });
}

#[test]
fn interfaces_that_come_in_twice_do_not_double() {
    bounded(|| {
        let level = |n: usize| {
            format!(
                "interface i{n} {{ extends i{0}; extends i{0}; doc \"{n}\"; }};\n",
                n.saturating_sub(1)
            )
        };
        let text: String = (1..60).map(level).collect();
        let first = "interface i0 { doc \"0\"; function f() { doc \"f\"; }; };";
        let text = format!("{first}\n{text}component c {{ provides i59; }};");
        let analysis = read_text("fuzz.gen", &text, &Options::default());
        let component = &analysis.specification.components[0];
        assert_eq!(component.doc.as_ref().unwrap().lines().count(), 60);
    });
}
