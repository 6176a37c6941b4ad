//! Messages of the checks as they are drawn for people.

use expect_test::{Expect, expect};
use genom_description::diagnostic::render;

#[track_caller]
fn check(text: &str, shown: Expect) {
    let analysis = crate::analyse(text);
    shown.assert_eq(&render::human(&analysis.diagnostics, &analysis.sources, false));
}

#[test]
fn an_ambiguous_parameter_shows_where_it_may_come_from() {
    check(
        "component c {\n  ids { long value; };\n  function f(in long value) {\n    codel g(in value);\n  };\n};\n",
        expect![[r#"
            error[E0713]: parameter `value` may come from several places
             --> test.gen:4:13
              |
            2 |   ids { long value; };
              |              ----- ids value
            3 |   function f(in long value) {
              |                      ----- local value
            4 |     codel g(in value);
              |             ^^^^^^^^
              |
              = help: write `ids` or `local` before it
        "#]],
    );
}

#[test]
fn an_unknown_type_suggests_the_nearest() {
    check(
        "typedef long length;\nstruct s { lenght x; };\n",
        expect![[r#"
        error[E0206]: unknown type `lenght`
         --> test.gen:2:12
          |
        2 | struct s { lenght x; };
          |            ^^^^^^
          |
          = help: did you mean `length`?
    "#]],
    );
}

#[test]
fn a_state_without_codel_suggests_the_nearest() {
    check(
        "component c {\n  task t {\n    codel<start> x() yield mian;\n    codel<main> y() yield ether;\n  };\n};\n",
        expect![[r#"
            error[E0709]: state `mian` has no codel
             --> test.gen:3:28
              |
            3 |     codel<start> x() yield mian;
              |                            ^^^^
              |
              = help: did you mean `main`?
        "#]],
    );
}

#[test]
fn a_conflict_brought_by_an_interface_shows_who_brought_it() {
    check(
        "interface i {\n  version \"1\";\n};\ncomponent c {\n  version \"2\";\n  provides i;\n};\n",
        expect![[r#"
            error[E0405]: `version` is already given
             --> test.gen:2:3
              |
            2 |   version "1";
              |   ^^^^^^^
            ...
            5 |   version "2";
              |   ------- given here
            6 |   provides i;
              |            - brought into `c` here
        "#]],
    );
}
