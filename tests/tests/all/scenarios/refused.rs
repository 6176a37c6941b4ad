//! Files with mistakes, and files that are not there: nothing is played.

use expect_test::expect;

use super::{Place, steps};

#[test]
fn the_mistakes_of_all_files_are_told_and_nothing_is_played() {
    let place = Place::new();
    std::fs::create_dir(place.path("tests")).unwrap();
    place.write("tests/a.toml", &steps("[\"demo\"]", &["{ cal = \"demo/goto\" }"]));
    place.write("tests/b.toml", "[[scenario]]\nname = \"b\"\nsteps = [{ step = \"1h\" }]\n");
    place.write("tests/c.toml", "[[scenario]]\nname = \"c\"\nsteps = [{ step = \"1s\" }]\n");
    let told = place.test(&[]);
    told.expect_code(2).expect_out("");
    expect![[r#"
        error: a step says what it does by a key
         --> tests/a.toml:6:1
          |
        6 | { cal = "demo/goto" },
          | ^^^^^^^^^^^^^^^^^^^^^
          |
          = help: did you mean `call`?
        error: `step`: unknown unit `h`: s, ms, us or ns
         --> tests/b.toml:3:19
          |
        3 | steps = [{ step = "1h" }]
          |                   ^^^^
        error: 2 mistakes in scenarios
    "#]]
    .assert_eq(&told.err);
    let told = place.test(&["--json"]);
    told.expect_code(2).expect_out("");
    expect![[r#"
        {"error":{"code":"usage","message":"tests/a.toml:6:1: a step says what it does by a key; did you mean `call`?\ntests/b.toml:3:19: `step`: unknown unit `h`: s, ms, us or ns","where":null,"help":"`genomctl test FILE` names a file of scenarios; docs/testing.md shows one"}}
    "#]].assert_eq(&told.err);
}

#[test]
fn files_that_are_not_there_are_named() {
    let place = Place::new();
    place.test(&[]).expect_code(2).expect_err("error: tests: No such file or directory");
    place
        .test(&["lib"])
        .expect_code(2)
        .expect_err("error: lib: no file *.toml with a [[scenario]]");
    place.write("a.toml", "backend = \"shm\"\n");
    place.test(&["a.toml"]).expect_code(2).expect_err("`scenario` is missing");
    place.write("a.toml", &steps("[\"demo\"]", &["{ step = \"1s\" }"]));
    place.test(&["a.toml", "--only", "other"]).expect_code(2).expect_err("no name of a scenario");
    place.test(&["a.toml", "--list"]).expect_code(0).expect_out("a.toml:3: a\n");
}
