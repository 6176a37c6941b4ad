//! Data of a `native` type, which only codels know: a new library takes it over by a function of its
//! own, or starts anew with it.

use genom_tests::{Daemon, until};

use super::{Author, C, GEN, count, text};

/// `edit`, with a tool and a pair of them in the IDS; `turns` adds what all have counted.
fn gen_text() -> String {
    let ids =
        "native tool; struct pair { long number; tool each[2]; };\n  ids { tool first; pair both;";
    let get = "attribute get(out count, out note);";
    let turns = "function turns(out long n) { codel edit_turns(in ::ids, out n); };";
    GEN.replace("ids {", ids).replace(get, &format!("{get}\n  {turns}"))
}

/// Codels that make and free tools; `conversion` is what stands before them.
fn codels(conversion: &str) -> String {
    let tools = r#"
#include <stdlib.h>
#include <errno.h>
#include <string.h>
#include "genom/reload.h"
struct edit_tool { int version; int turns; };
static edit_tool *made(void)
{
  edit_tool *tool = malloc(sizeof *tool);
  tool->version = 1;
  tool->turns = 0;
  return tool;
}
genom_event
edit_turns(const edit_ids *ids, int32_t *n, const genom_context self)
{
  (void)self;
  *n = ids->first->turns + 10 * ids->both.each[0]->turns + 100 * ids->both.each[1]->turns;
  ids->first->turns += 1; ids->both.each[0]->turns += 2; ids->both.each[1]->turns += 3;
  return genom_ok;
}
genom_event
edit_freed(edit_ids *ids, const genom_context self)
{
  (void)self;
  ids->first->version = ids->both.each[0]->version = ids->both.each[1]->version = 0;
  free(ids->first); free(ids->both.each[0]); free(ids->both.each[1]);
  return edit_ether;
}
"#;
    let made = "ids->count = 0; ids->first = made(); ids->both.each[0] = made();
  ids->both.each[1] = made();";
    let head = "#include \"edit_c_types.h\"\n";
    C.replace(head, &format!("{head}{tools}{conversion}")).replace("ids->count = 0;", made)
}

/// Takes the turns over, and knows what it is told.
const CONVERSION: &str = r#"
GENOM_CONVERT(edit_tool)
{
  const edit_tool *before = old;
  edit_tool *now = *data;
  if (about->size != sizeof *about || before->version != 1) return EINVAL;
  if (strcmp(about->instance, "edit") || strcmp(about->old_type, "::edit::tool")) return ESRCH;
  if (strcmp(about->old_version, "0") || !about->old_digest[0]) return ERANGE;
  if (strcmp(about->member, "first") && strncmp(about->member, "both.each[", 10)) return EDOM;
  now->turns = before->turns;
  return 0;
}
"#;

/// The second tool of the pair is refused, when the first has been given other memory.
const REFUSAL: &str = r#"
GENOM_CONVERT(edit_tool)
{
  if (about->member[0] == 'b' && about->member[10] == '1') return 7;
  free(*data);
  *data = made();
  ((edit_tool *)*data)->turns = ((const edit_tool *)old)->turns;
  return 0;
}
"#;

fn author() -> Author {
    let author = Author::new();
    let stop = "codel<main> edit_step(inout count";
    let with_stop = format!("codel<stop> edit_freed(inout ::ids) yield ether;\n    {stop}");
    author.describe(&gen_text().replace(stop, &with_stop));
    author
}

fn turns(daemon: &Daemon) -> i64 {
    daemon.json(&["call", "edit", "turns"])["result"]["n"].as_i64().unwrap()
}

fn notes(told: &serde_json::Value) -> Vec<String> {
    serde_json::from_value(told["notes"].clone()).unwrap()
}

#[test]
fn native_data_is_taken_over_by_a_function_of_the_new_library() {
    for cell in [&[][..], &["--cell", "arm"]] {
        let author = author();
        let library = author.make("edit.so", &codels(""), 1);
        let daemon = Daemon::start(&[]);
        daemon.ctl(&[&["load", text(&library)][..], cell].concat()).expect_code(0);
        until("it counts", || count(&daemon) > 5);
        assert_eq!((turns(&daemon), turns(&daemon)), (0, 321));
        // With the same description, then with another one.
        author.make("edit.so", &codels(CONVERSION), 1_000_000);
        let told = daemon.json(&["reload", "edit"]);
        let expected = |path: &str| format!("ids: {path} is converted by genom_convert_edit_tool");
        assert_eq!(notes(&told), [expected("both.each"), expected("first")], "{told}");
        assert_eq!(turns(&daemon), 642);
        until("it counts by the new step", || count(&daemon) > 1_000_000);
        let wider = std::fs::read_to_string(author.at("edit.gen")).unwrap();
        author.describe(&wider.replace("ids { tool first;", "ids { double wide; tool first;"));
        author.make("edit.so", &codels(CONVERSION), 1);
        let told = daemon.json(&["reload", "edit"]);
        let all = notes(&told);
        assert!(all.contains(&expected("both.each")) && all.contains(&expected("first")), "{told}");
        assert!(all.contains(&"ids: wide is new".to_owned()), "{told}");
        assert_eq!(turns(&daemon), 963);
    }
}

#[test]
fn without_such_a_function_native_data_starts_anew_and_the_reply_says_so() {
    let author = author();
    let library = author.make("edit.so", &codels(CONVERSION), 1);
    let daemon = Daemon::start(&[text(&library)]);
    assert_eq!((turns(&daemon), turns(&daemon)), (0, 321));
    let anew =
        |path: &str| format!("ids: {path} starts anew: the library has no genom_convert_edit_tool");
    author.make("edit.so", &codels(""), 1_000_000);
    let told = daemon.json(&["reload", "edit"]);
    assert_eq!(notes(&told), [anew("both.each"), anew("first")], "{told}");
    assert_eq!((turns(&daemon), turns(&daemon)), (0, 321));
    // With another description.
    let wider = std::fs::read_to_string(author.at("edit.gen")).unwrap();
    author.describe(&wider.replace("ids { tool first;", "ids { tool spare; tool first;"));
    author.make("edit.so", &codels(""), 1);
    let told = daemon.json(&["reload", "edit"]);
    assert_eq!(notes(&told), [anew("both.each"), anew("first"), "ids: spare is new".to_owned()]);
    assert_eq!(turns(&daemon), 0);
}

#[test]
fn a_function_that_refuses_leaves_the_component_as_it_is() {
    let author = author();
    let library = author.make("edit.so", &codels(""), 1);
    let daemon = Daemon::start(&[text(&library)]);
    until("it counts", || count(&daemon) > 5);
    let activity = daemon.json(&["start", "edit", "run"])["activity"].clone();
    assert_eq!((turns(&daemon), turns(&daemon)), (0, 321));
    author.make("edit.so", &codels(REFUSAL), 1_000_000);
    let refused = daemon.ctl(&["reload", "edit"]);
    let why = "edit goes on as it is: genom_convert_edit_tool of the new library returned 7 for \
               both.each[1] of the ids";
    refused.expect_err(why).expect_code(1);
    assert_eq!(turns(&daemon), 642);
    let before = count(&daemon);
    until("it counts on", || count(&daemon) > before);
    assert!(count(&daemon) < 1_000_000, "by the code before");
    assert_eq!(daemon.json(&["activities", "edit"])["activities"][0]["activity"], activity);
    // Another library is still welcome.
    author.make("edit.so", &codels(CONVERSION), 1_000_000);
    daemon.ctl(&["reload", "edit"]).expect_code(0);
    assert_eq!(turns(&daemon), 963);
}
