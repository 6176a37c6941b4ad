//! Reports in all their forms.

use std::path::{Path, PathBuf};

use expect_test::expect;

use super::*;
use crate::model::Suite;

fn report() -> Report {
    let text = "[[scenario]]\nname = \"stops <at> the \\\"wall\\\"\"\nsteps = [{ step = \"0s\" }]\n\
                [[scenario]]\nname = \"b\"\nsteps = [{ step = \"0s\" }]\n[[scenario]]\nname = \"c\"\nsteps = [{ step = \"0s\" }]\n";
    let suite = Suite::read(Path::new("tests/wall.toml"), text).unwrap();
    let mut report = Report::default();
    report.begin(PathBuf::from("tests/wall.toml"));
    let [a, b, c] = &suite.scenarios[..] else { panic!("three scenarios") };
    let unmet = Unmet {
        line: 7,
        step: "call demo/goto".to_owned(),
        nanoseconds: 250_000_000,
        expected: "::demo::OUT_OF_RANGE".to_owned(),
        came: "done, {\"text\":\"\u{1b}[31m & more\"}".to_owned(),
        help: Some("try again".to_owned()),
    };
    report.add(a, Outcome::Failed(unmet), Played { steps: 3, nanoseconds: 250_000_000 });
    report.add(b, Outcome::Passed, Played { steps: 1, nanoseconds: 1_000_000_000 });
    report.add(c, Outcome::not_begun(c, "no library"), Played::default());
    report
}

#[test]
fn people_see_what_was_expected_what_came_where_and_when() {
    let report = report();
    let suite = &report.files[0];
    let mut text: String = suite.scenarios.iter().map(|one| one.text(&suite.file)).collect();
    text.push_str(&report.summary());
    expect![[r#"
          FAIL  stops <at> the "wall" (3 steps, 0.250000000 s)
                tests/wall.toml:7: call demo/goto
                  at        0.250000000 s
                  expected  ::demo::OUT_OF_RANGE
                  came      done, {"text":"ESC[31m & more"}
                  help      try again
          ok    b (1 step, 1.000000000 s)
          ERROR c (0 steps, 0.000000000 s)
                tests/wall.toml:7: begin
                  at        0.000000000 s
                  expected  a daemon with what the scenario names
                  came      no library
        3 scenarios: 1 passed, 2 failed
    "#]]
    .assert_eq(&text.replace('\u{1b}', "ESC"));
}

#[test]
fn programs_read_the_same_as_junit() {
    expect![[r#"
        <?xml version="1.0" encoding="UTF-8"?>
        <testsuites name="genomctl test" tests="3" failures="1" errors="1" time="1.250000000">
          <testsuite name="tests/wall.toml" tests="3" failures="1" errors="1" time="1.250000000">
            <testcase classname="tests.wall" name="stops &lt;at&gt; the &quot;wall&quot;" file="tests/wall.toml" line="1" time="0.250000000">
              <failure message="expected ::demo::OUT_OF_RANGE, came done, {&quot;text&quot;:&quot;�[31m &amp; more&quot;}" type="call">tests/wall.toml:7: call demo/goto, at 0.250000000 s
        expected  ::demo::OUT_OF_RANGE
        came      done, {&quot;text&quot;:&quot;�[31m &amp; more&quot;}
        </failure>
            </testcase>
            <testcase classname="tests.wall" name="b" file="tests/wall.toml" line="4" time="1.000000000"/>
            <testcase classname="tests.wall" name="c" file="tests/wall.toml" line="7" time="0.000000000">
              <error message="expected a daemon with what the scenario names, came no library" type="begin">tests/wall.toml:7: begin, at 0.000000000 s
        expected  a daemon with what the scenario names
        came      no library
        </error>
            </testcase>
          </testsuite>
        </testsuites>
    "#]].assert_eq(&report().junit().unwrap());
}

#[test]
fn programs_read_the_same_as_json() {
    expect![[r#"
        {
          "failed": 2,
          "files": [
            {
              "file": "tests/wall.toml",
              "scenarios": [
                {
                  "name": "stops <at> the \"wall\"",
                  "line": 1,
                  "steps": 3,
                  "nanoseconds": 250000000,
                  "outcome": "failed",
                  "why": {
                    "line": 7,
                    "step": "call demo/goto",
                    "nanoseconds": 250000000,
                    "expected": "::demo::OUT_OF_RANGE",
                    "came": "done, {\"text\":\"\u001b[31m & more\"}",
                    "help": "try again"
                  }
                },
                {
                  "name": "b",
                  "line": 4,
                  "steps": 1,
                  "nanoseconds": 1000000000,
                  "outcome": "passed"
                },
                {
                  "name": "c",
                  "line": 7,
                  "steps": 0,
                  "nanoseconds": 0,
                  "outcome": "error",
                  "why": {
                    "line": 7,
                    "step": "begin",
                    "nanoseconds": 0,
                    "expected": "a daemon with what the scenario names",
                    "came": "no library"
                  }
                }
              ]
            }
          ]
        }"#]]
    .assert_eq(&serde_json::to_string_pretty(&report()).unwrap());
}
