//! `genomctl check --manifest`: the table of agreement with GenoM3's own tool.

use std::path::Path;

use expect_test::expect;

use crate::support::Room;

const REFUSED: &str = "component c {\n  port in missing p;\n};\n";

#[test]
fn every_case_agrees_with_genom3_but_the_intended_differences() {
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("../description/tests/cases");
    let room = Room::new(&[]);
    // A link, because arguments are split at blanks.
    std::os::unix::fs::symlink(cases, room.path("cases")).unwrap();
    let (code, out, err) = room.run("check --manifest cases/manifest.tsv", "");
    assert_eq!((code, err.as_str()), (0, ""), "{out}");
    assert_eq!(out.lines().last(), Some("88 of 94 agree; 6 intended differences"), "{out}");
    // Where GenoM3 crashes, genomctl reports a plain error.
    let crashes: Vec<_> = out.lines().filter(|line| line.contains("CRASH")).collect();
    assert_eq!(crashes.len(), 3, "{out}");
    assert!(crashes.iter().all(|line| line.contains("reject")), "{out}");
}

#[test]
fn verdicts_lines_and_reasons_are_compared() {
    let room = Room::new(&[
        ("good.gen", "component c {};\n"),
        ("bad.gen", REFUSED),
        ("elsewhere.gen", REFUSED),
        ("elsewhere.expected", "elsewhere.gen:1: unknown type 'missing'\ngenom3: 1 errors\n"),
        ("same.tsv", "good.gen\t0\taccept\nbad.gen\t134\tCRASH\n"),
        ("reasons.tsv", "good.gen\t1\treject\tlegal now\nbad.gen\t1\treject\tno longer\n"),
        ("other.tsv", "good.gen\t1\treject\nbad.gen\t0\taccept\nelsewhere.gen\t1\treject\n"),
    ]);
    room.check(
        "check --manifest same.tsv",
        &expect![[r#"
        FILE      EXPECTED  LINE  OURS    LINE
        good.gen  accept    -     accept  -
        bad.gen   CRASH     -     reject  2
        2 of 2 agree; 0 intended differences
    "#]],
    );
    room.check(
        "check --manifest reasons.tsv",
        &expect![[r#"
        FILE      EXPECTED  LINE  OURS    LINE
        good.gen  reject    -     accept  -     legal now
        bad.gen   reject    -     reject  2     agrees, though a difference is announced
        1 of 2 agree; 1 intended differences
    "#]],
    );
    room.check(
        "check --manifest other.tsv",
        &expect![[r#"
        FILE           EXPECTED  LINE  OURS    LINE
        good.gen       reject    -     accept  -     DIFFERS
        bad.gen        accept    -     reject  2     DIFFERS
        elsewhere.gen  reject    1     reject  2     DIFFERS
        0 of 3 agree; 0 intended differences
        ! error: 3 files differ from the manifest
        exit 1
    "#]],
    );
    room.check("--json check --manifest same.tsv", &expect![[r#"
        [{"file":"good.gen","expected":"accept","expected_line":null,"ours":"accept","line":null,"agrees":true,"reason":null},{"file":"bad.gen","expected":"CRASH","expected_line":null,"ours":"reject","line":2,"agrees":true,"reason":null}]
    "#]]);
}

#[test]
fn a_manifest_that_makes_no_sense_is_refused() {
    let room = Room::new(&[
        ("good.gen", "component c {};\n"),
        ("verdict.tsv", "good.gen\t0\taccept\ngood.gen\t0\tmaybe\n"),
        ("missing.tsv", "nowhere.gen\t0\taccept\n"),
        ("columns.tsv", "good.gen accept\n"),
    ]);
    room.check("check --manifest verdict.tsv", &expect![[r#"
        ! error: verdict.tsv:2: the verdict is none of accept, reject, CRASH
        ! help: write FILE, number of errors, accept|reject|CRASH and perhaps a reason, with tabs between
        exit 2
    "#]]);
    room.check("check --manifest missing.tsv", &expect![[r#"
        ! error: missing.tsv:1: nowhere.gen: no such file
        ! help: write FILE, number of errors, accept|reject|CRASH and perhaps a reason, with tabs between
        exit 2
    "#]]);
    room.check("check --manifest columns.tsv", &expect![[r#"
        ! error: columns.tsv:1: three or four columns are wanted
        ! help: write FILE, number of errors, accept|reject|CRASH and perhaps a reason, with tabs between
        exit 2
    "#]]);
}
