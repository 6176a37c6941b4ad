//! Codels of `lang "c++"` components, against the header that `genomctl header --lang c++` writes.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)] // helpers are no test functions

mod support;

use std::sync::{Arc, Mutex, Weak};

use expect_test::expect;
use genom_host::Library;
use genom_host::contract::{self, Checked};
use genom_middleware::{PublishError, Publisher, ReadError, Reading, Subscription};
use genom_runtime::body::{Body, Opener};
use genom_types::Record;
use serde_json::{Value, json};
use support::Scratch;
use support::cxx::{Compiled, compile, load, plan, refusal};

/// Every kind of type, through a function whose codel shows `in` and `out`.
const TYPES: &str = r#"
component demo {
  lang "c++";
  enum color { RED, GREEN, BLUE };
  typedef string<8> word;
  struct point { double x; float y; };
  struct named { string name; sequence<point> path; word words[2]; optional<string> note; };
  struct tree;
  struct tree { long value; sequence<tree> branches; };
  union number switch (color) { case RED: long i; case GREEN: double d; };
  const long ANSWER = 42;
  const string GREETING = "hello";
  const color BEST = GREEN;

  task main;
  function scalars(in boolean a, in char b, in octet c, in short d, in unsigned short e,
                   in long f, in unsigned long g, in long long h, in unsigned long long i,
                   in float j, in double k, in color l, out double sum, out boolean no,
                   inout color m) {
    codel f_scalars(in a, in b, in c, in d, in e, in f, in g, in h, in i, in j, in k, in l,
                    out sum, out no, inout m);
  };
  function texts(in string a, in string<8> b, out string c, out string<8> d, inout string e) {
    codel f_texts(in a, in b, out c, out d, inout e);
  };
  function sequences(in sequence<long> a, in sequence<double, 3> b, in sequence<string> c,
                     in sequence<boolean> d, in sequence<sequence<short> > e,
                     out sequence<long> oa, out sequence<double, 3> ob, out sequence<string> oc,
                     out sequence<boolean> od, out sequence<sequence<short> > oe) {
    codel f_sequences(in a, in b, in c, in d, in e, out oa, out ob, out oc, out od, out oe);
  };
  function structs(in named a, out named b, in number c, out number d, in optional<long> e,
                   out optional<long> f, in tree g, out tree h) {
    codel f_structs(in a, out b, in c, out d, in e, out f, in g, out h);
  };
  function arrays(in point a, in long b, in named c, out long total) {
    local long grid[2][3];
    local string labels[2];
    codel f_fill(out grid, out labels, in b);
    codel f_sum(in grid, in labels, out total);
  };
};
"#;

const CODELS: &str = r##"
#include <cstring>
genom::event f_scalars(bool a, int8_t b, uint8_t c, int16_t d, uint16_t e, int32_t f, uint32_t g,
    int64_t h, uint64_t i, float j, double k, demo::color l, double &sum, bool &no, demo::color &m) {
  sum = b + c + d + e + f + g + (double)h + (double)i + (double)j + k + l;
  no = !a;
  m = m == demo::BEST ? demo::BLUE : demo::RED;
  return genom::ok;
}
genom::event f_texts(const std::string &a, const char b[8], std::string &c, char d[8],
    std::string &e) {
  if (!c.empty()) return genom::fatal;
  c = a + ", " + demo::GREETING + std::string(40, '!');
  std::strncpy(d, b + 1, 8);
  e += e;
  return genom::ok;
}
genom::event f_sequences(const std::vector<int32_t> &a, const genom::bounded_sequence<double, 3> &b,
    const std::vector<std::string> &c, const std::vector<bool> &d,
    const std::vector<std::vector<int16_t> > &e, std::vector<int32_t> &oa,
    genom::bounded_sequence<double, 3> &ob, std::vector<std::string> &oc, std::vector<bool> &od,
    std::vector<std::vector<int16_t> > &oe) {
  for (std::size_t i = 0; i < a.size(); i++) oa.push_back(a[i] * demo::ANSWER);
  ob = b;
  ob.push_back(0.5);
  oc = c;
  oc.push_back(std::string(100, 'x'));
  oc.insert(oc.begin(), "first");
  for (bool one : d) od.push_back(!one);
  oe = e;
  oe.push_back(std::vector<int16_t>(3, 7));
  return genom::ok;
}
genom::event f_structs(const demo::named &a, demo::named &b, const demo::number &c,
    demo::number &d, const genom::optional<int32_t> &e, genom::optional<int32_t> &f,
    const demo::tree &g, demo::tree &h) {
  b = a;
  b.name += "'";
  b.path.resize(a.path.size() + 1);
  b.path.back().y = 2;
  std::strncpy(b.words[1], b.words[0], 8);
  b.note = a.note ? "was " + *a.note : std::string("was absent");
  d._d = demo::GREEN;
  d._u.d = c._u.i / 2.;
  f._present = !e._present;
  f._value = 5;
  h.branches.push_back(g);
  h.branches.push_back(g.branches.at(0));
  return genom::ok;
}
genom::event f_fill(int32_t grid[2][3], std::string labels[2], int32_t b) {
  for (int i = 0; i < 2; i++) for (int j = 0; j < 3; j++) grid[i][j] = b + 10 * i + j;
  labels[1] = std::string(b, 'l');
  return genom::ok;
}
genom::event f_sum(const int32_t grid[2][3], const std::string labels[2], int32_t &total) {
  total = (int32_t)labels[1].size();
  for (int i = 0; i < 2; i++) for (int j = 0; j < 3; j++) total += grid[i][j];
  return genom::ok;
}
"##;

#[test]
fn values_of_every_type_are_passed_and_given_back() {
    let demo = load(&compile(TYPES, CODELS, &[]), TYPES);
    let (event, output) = demo.run(
        "scalars",
        json!({ "a": true, "b": "\u{1}", "c": 2, "d": -3, "e": 4, "f": -5, "g": 6, "h": -7, "i": 8,
                "j": 0.5, "k": 0.25, "l": "BLUE", "m": "GREEN" }),
    );
    assert_eq!((event.as_str(), &output), ("", &json!({ "sum": 8.75, "no": false, "m": "BLUE" })));

    let (event, output) = demo.run("texts", json!({ "a": "robot", "b": "abcdefg", "e": "ab" }));
    let greeting = format!("robot, hello{}", "!".repeat(40));
    assert_eq!(event, "");
    assert_eq!(output, json!({ "c": greeting, "d": "bcdefg", "e": "abab" }));

    let (event, output) = demo.run(
        "sequences",
        json!({ "a": [1, 2, 3], "b": [1.5, 2.5], "c": ["a", "bc"], "d": [true, false, true],
                "e": [[1], [], [2, 3]] }),
    );
    assert_eq!(event, "");
    let long = "x".repeat(100);
    assert_eq!(
        output,
        json!({ "oa": [42, 84, 126], "ob": [1.5, 2.5, 0.5], "oc": ["first", "a", "bc", long],
                "od": [false, true, false], "oe": [[1], [], [2, 3], [7, 7, 7]] })
    );

    let tree = json!({ "value": 1, "branches": [{ "value": 2, "branches": [] }] });
    let point = |x: f64, y: f64| json!({ "x": x, "y": y });
    let (event, output) = demo.run(
        "structs",
        json!({
            "a": { "name": "n", "path": [point(1.0, 0.5)], "words": ["one", "two"], "note": "note" },
            "c": { "d": "RED", "u": { "i": 3 } }, "e": null, "g": tree,
        }),
    );
    assert_eq!(event, "");
    assert_eq!(
        output,
        json!({
            "b": { "name": "n'", "path": [point(1.0, 0.5), point(0.0, 2.0)],
                   "words": ["one", "one"], "note": "was note" },
            "d": { "d": "GREEN", "u": { "d": 1.5 } }, "f": 5,
            "h": { "value": 0, "branches": [tree, { "value": 2, "branches": [] }] },
        })
    );

    let (event, output) = demo.run("arrays", json!({ "b": 100 }));
    assert_eq!((event.as_str(), output), ("", json!({ "total": 736 })));
}

/// Ports, exceptions, IDS and natives.
const AXIS: &str = r#"
component demo {
  lang "c++";
  native driver;
  exception EMPTY;
  exception TOO_FAR { double limit; string what; sequence<long> tried; };
  struct sample { string frame; sequence<double> values; };
  struct limits { sequence<long> steps; string names[2]; };
  ids { sample last; limits all; driver handle; long count; };
  port in sample input;
  port out sample output;
  port multiple in sample ins;
  port multiple out sample outs;

  task main {
    codel<start> t_start(out ::ids) yield ether;
  };
  attribute set_frame(in last.frame) { validate v_frame(local in frame); throw EMPTY; };
  attribute get_frame(out last.frame, out all.steps);
  attribute swap_count(inout count);
  activity move(in double to, out string seen) {
    task main;
    async codel<start> m_start(in to, out seen, inout handle) yield main;
    codel<main> m_main(in to, in input, out output, inout last, out seen, in all.steps[1]::step)
      yield pause::main, ether;
    codel<stop> m_stop(out seen) yield ether;
    throw EMPTY, TOO_FAR;
  };
  activity many(in string id, out string seen) {
    task main;
    codel<start> n_start(in id, in ins, out outs, out seen) yield ether;
  };
};
"#;

const AXIS_CODELS: &str = r##"
#include <new>
#include <stdexcept>
struct demo::driver { std::string port; };
struct further : public demo::TOO_FAR { int more; };

genom::event t_start(demo::ids &ids) {
  ids.handle = new demo::driver;
  ids.last.frame = "a frame of reference that fits no small string";
  ids.all.steps.assign(2, 7);
  ids.all.names[1] = "second";
  return demo::ether;
}
genom::event v_frame(const std::string &frame) {
  if (frame.empty()) throw demo::EMPTY();
  return genom::ok;
}
genom::event m_start(double to, std::string &seen, demo::driver *&handle) {
  if (!handle) throw std::runtime_error("no driver");
  handle->port = "tty";
  seen = handle->port;
  if (to > 100) throw to;
  if (to > 30) {
    further e;
    e.detail.limit = 30;
    throw e;
  }
  if (to > 20) {
    demo::TOO_FAR e;
    e.detail.limit = 20;
    e.detail.what = "too far, as the axis ends before";
    e.detail.tried = { 1, 2 };
    throw e;
  }
  if (to > 10) throw demo::EMPTY();
  if (to < -20) throw genom::syserr({ 2 });
  if (to < -10) return "::demo::elsewhere";
  return demo::main;
}
genom::event m_main(double to, demo::input &in, demo::output &out, demo::sample &last,
    std::string &seen, int32_t step) {
  in.read();
  try {
    last = in.data();
  } catch (const genom::exception &e) {
    seen = e.what();
    out.data().frame = "none";
    out.write();
    return demo::pause::main;
  }
  demo::sample &o = out.data();
  seen = o.frame;
  o = last;
  o.values.push_back(to + step);
  out.write();
  return demo::ether;
}
genom::event m_stop(std::string &) { return demo::ether; }
genom::event n_start(const std::string &id, demo::ins &ins, demo::outs &outs, std::string &seen) {
  try {
    outs.data(id.c_str());
  } catch (const genom::no_such_outport &e) {
    seen = std::string(e.what()) + "; ";
  }
  outs.open(id.c_str());
  ins.read(id.c_str());
  outs.data(id.c_str()) = ins.data(id.c_str());
  outs.write(id.c_str());
  outs.close(id.c_str());
  try {
    outs.close(id.c_str());
  } catch (const genom::syserr &e) {
    seen += std::to_string(e.detail.code) + "; ";
  }
  try {
    outs.open("a b");
  } catch (const genom::mwerr &e) {
    seen += e.detail.what;
  }
  outs.write(id.c_str());
  return demo::ether;
}
"##;

/// The library of those codels, compiled once for the tests that run together.
fn axis() -> Arc<Compiled> {
    static SHARED: Mutex<Weak<Compiled>> = Mutex::new(Weak::new());
    // Without the flag gcc says no more of an abstract struct than its name.
    let make = || compile(AXIS, AXIS_CODELS, &["-O2", "-femit-class-debug-always"]);
    let mut shared = SHARED.lock().unwrap();
    let compiled = shared.upgrade().unwrap_or_else(make);
    *shared = Arc::downgrade(&compiled);
    compiled
}

/// What was published, as JSON.
type Sent = Arc<Mutex<Vec<Value>>>;

struct FakePublisher(Sent);

impl Publisher for FakePublisher {
    fn publish(&mut self, value: &Record) -> Result<(), PublishError> {
        self.0.lock().unwrap().push(value.to_json());
        Ok(())
    }
    fn dropped(&self) -> u64 {
        0
    }
}

/// Gives these values, then the last again.
struct FakeSubscription(Vec<Value>);

impl Subscription for FakeSubscription {
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        match self.0.pop() {
            Some(value) => {
                into.merge_json(&value).unwrap();
                Ok(Reading::New)
            }
            None => Ok(Reading::Never),
        }
    }
    fn dropped(&self) -> u64 {
        0
    }
}

struct FakeOpener(Sent);

impl Opener for FakeOpener {
    fn open(&self, _: usize, _: &str) -> Result<Box<dyn Publisher>, String> {
        Ok(Box::new(FakePublisher(Arc::clone(&self.0))))
    }

    fn close(&self, _: usize, _: &str) {}
}

#[test]
fn ports_are_read_and_written_and_what_fails_is_thrown() {
    let demo = load(&axis(), AXIS);
    assert_eq!(demo.task("t_start"), "::demo::ether");
    let (input, output) = (demo.port("input"), demo.port("output"));
    let sent = Sent::default();
    let mut frame = demo.begin("move", json!({ "to": 1.0 }));
    // Unbound: `read` throws what the codel does not catch.
    assert_eq!(demo.call(&mut *frame, "m_main"), "::genom::no_such_inport");

    demo.component.bind_out(output, None, Some(Box::new(FakePublisher(Arc::clone(&sent)))));
    demo.component.bind_in(input, None, Some(Box::new(FakeSubscription(vec![]))));
    assert_eq!(demo.call(&mut *frame, "m_main"), "::demo::pause::main");
    assert_eq!(frame.output().to_json(), json!({ "seen": "::genom::no_such_inport" }));
    assert_eq!(*sent.lock().unwrap(), [json!({ "frame": "none", "values": [] })]);

    let value = json!({ "frame": "base", "values": [1.5, 2.5] });
    let subscription = FakeSubscription(vec![value]);
    demo.component.bind_in(input, None, Some(Box::new(subscription)));
    assert_eq!(demo.call(&mut *frame, "m_main"), "::demo::ether");
    assert_eq!(frame.output().to_json(), json!({ "seen": "none" }), "a buffer keeps its value");
    let published = json!({ "frame": "base", "values": [1.5, 2.5, 8.0] });
    assert_eq!(sent.lock().unwrap().last(), Some(&published));
    assert_eq!(demo.component.port_value(output, None), Some(published));
}

#[test]
fn elements_of_multiple_ports_are_opened_and_closed_by_name() {
    let demo = load(&axis(), AXIS);
    let sent = Sent::default();
    demo.component.set_opener(Box::new(FakeOpener(Arc::clone(&sent))));
    let value = json!({ "frame": "left", "values": [3.0] });
    let subscription = FakeSubscription(vec![value.clone()]);
    demo.component.bind_in(demo.port("ins"), Some("left"), Some(Box::new(subscription)));
    let mut frame = demo.begin("many", json!({ "id": "left" }));
    assert_eq!(demo.call(&mut *frame, "n_start"), "::genom::no_such_outport");
    assert_eq!(*sent.lock().unwrap(), [value]);
    let seen = frame.output().to_json();
    let seen = seen["seen"].as_str().unwrap();
    let expected = "::genom::no_such_outport; 2; name of a port's element: \"a b\" has";
    assert!(seen.starts_with(expected), "{seen}");
}

#[test]
fn exceptions_thrown_are_events_with_their_detail() {
    let demo = load(&axis(), AXIS);
    let thrown = |to: f64| {
        let mut frame = demo.begin("move", json!({ "to": to }));
        let event = demo.call(&mut *frame, "m_start");
        (event, frame.detail().unwrap_or_default())
    };
    let (event, detail) = thrown(1.0);
    assert_eq!((event.as_str(), &detail["what"]), ("::genom::unkex", &json!("no driver")));
    assert_eq!(demo.task("t_start"), "::demo::ether");
    assert_eq!(thrown(1.0), ("::demo::main".to_owned(), Value::Null));
    assert_eq!(thrown(11.0), ("::demo::EMPTY".to_owned(), Value::Null));
    let what = "too far, as the axis ends before";
    let detail = json!({ "limit": 20.0, "what": what, "tried": [1, 2] });
    assert_eq!(thrown(21.0), ("::demo::TOO_FAR".to_owned(), detail));
    // Of a type derived from the description's.
    let detail = json!({ "limit": 30.0, "what": "", "tried": [] });
    assert_eq!(thrown(31.0), ("::demo::TOO_FAR".to_owned(), detail));
    assert_eq!(thrown(-21.0), ("::genom::syserr".to_owned(), json!({ "code": 2 })));
    assert_eq!(thrown(-11.0).0, "::demo::elsewhere");
    let (event, detail) = thrown(101.0);
    assert_eq!(event, "::genom::unkex");
    assert_eq!(detail["what"], "C++ exception of type double");
}

#[test]
fn attributes_move_values_between_requests_and_the_ids_of_cxx() {
    // genom3.md 7.3.6, over std::string and std::vector.
    let demo = load(&axis(), AXIS);
    demo.task("t_start");
    let mut frame = demo.begin("set_frame", json!({ "frame": "" }));
    assert_eq!(demo.call(&mut *frame, "v_frame"), "::demo::EMPTY");
    let name = "a name that is too long for a small string";
    let mut frame = demo.begin("set_frame", json!({ "frame": name }));
    assert_eq!(demo.call(&mut *frame, "v_frame"), "");
    frame.store();
    let mut frame = demo.begin("get_frame", json!({}));
    frame.fetch();
    assert_eq!(frame.output().to_json(), json!({ "frame": name, "steps": [7, 7] }));
    let mut frame = demo.begin("swap_count", json!({ "count": 3 }));
    frame.store();
    frame.fetch();
    assert_eq!(frame.output().to_json(), json!({ "count": 3 }));
}

#[test]
fn a_member_of_a_sequence_that_is_too_short_is_told() {
    let demo = load(&axis(), AXIS);
    let mut frame = demo.begin("move", json!({ "to": 1.0 }));
    assert_eq!(demo.call(&mut *frame, "m_main"), "::genom::unkex");
    let detail = frame.detail().unwrap();
    assert_eq!(detail["what"], "argument `step` of codel m_main: the sequence has no such element");
}

#[test]
fn codels_that_differ_are_refused_with_the_line_and_both_declarations() {
    let small = |parameter: &str| {
        format!(
            "component demo {{\n  lang \"c++\";\n  task main;\n  function f(in {parameter} x, out \
             long y) {{\n    codel f_run(in x, out y);\n  }};\n}};\n"
        )
    };
    let codel = "genom::event f_run(int32_t x, int32_t &y) { y = x; return genom::ok; }";
    let right = compile(&small("long"), codel, &[]);
    let refused = |run: &str| refusal(&right, &small(run));
    expect!["loads"].assert_eq(&refused("long"));
    expect![[r#"
        demo.so: codel `f_run` (demo.gen:5): the C++ function takes other parameters
          .gen:    genom::event f_run(double x, int32_t &y)
          library: f_run(int, int&)"#]]
    .assert_eq(&refused("double"));
    expect![[r#"
        demo.so: codel `f_run` (demo.gen:5): the C++ function takes other parameters
          .gen:    genom::event f_run(const std::vector< std::string > &x, int32_t &y)
          library: f_run(int, int&)"#]]
    .assert_eq(&refused("sequence<string>"));
    let text = small("long").replace("f_run", "g_run");
    expect![[r#"demo.so: codel `g_run` (demo.gen:5) is not defined; a lang "c++" codel is a C++ function that the library exports"#]]
        .assert_eq(&refusal(&right, &text));
    let linkage = "extern \"C\" genom::event f_run(int32_t x, int32_t &y) { y = x; return 0; }";
    let linkage = compile(&text, linkage, &["-g0"]);
    expect![[r#"demo.so: codel `f_run` (demo.gen:5) is not defined; it has a function of that name with C linkage: in a lang "c++" component codels have none (no extern "C"), or say lang "c""#]]
        .assert_eq(&refusal(&linkage, &small("long")));
}

#[test]
fn types_that_cxx_has_not_are_refused_at_load() {
    let text = |member: &str| {
        format!(
            "component demo {{\n lang \"c++\";\n union u switch (long) {{ case 1: long i; case 2: \
             {member} m; }};\n task main;\n ids {{ u x; }};\n}};\n"
        )
    };
    let plain = compile(&text("double"), "", &[]);
    expect![[r#"demo.so: the ids (demo.gen:1): member 'm' of type string not allowed in C++ union ::demo::u: put it beside the union"#]]
        .assert_eq(&refusal(&plain, &text("string")));
    expect!["demo.so: the ids (demo.gen:1): sequence<string<4>> has no C++ type, because string<4> is an array there: put it in a struct"]
        .assert_eq(&refusal(&plain, &text("sequence<string<4> >")));
}

#[test]
fn another_cpp_library_is_refused() {
    let text = "component demo { lang \"c++\"; task main; };";
    let scratch = Scratch::new();
    let soname = ["-shared", "-fPIC", "-Wl,-soname,libc++.so.1"];
    let other = scratch.cxx("libc++.so.1", "int other() { return 1; }", &soname);
    let rpath = format!("-Wl,-rpath,{}", scratch.path().display());
    let other = other.to_str().unwrap();
    let compiled = compile(text, "", &["-Wl,--no-as-needed", other, &rpath]);
    expect!["demo.so: component `demo` is linked with libc++, this daemon with libstdc++: texts and sequences would not fit (leave -stdlib=libc++ away, or give the codels the C interface)"]
        .assert_eq(&refusal(&compiled, text));
}

#[test]
fn a_library_with_constructors_threads_and_other_libraries_behind_it_runs() {
    let text = r#"
component demo {
  lang "c++";
  native worker;
  ids { worker team; long sum; };
  task main { codel<start> t_start(out team, out sum) yield ether; };
  activity add(in string text, out string made) {
    task main;
    async codel<start> a_start(in text, inout team, out sum, out made) yield stop;
    codel<stop> a_stop(inout team) yield ether;
  };
};
"#;
    // A library behind it, with a C++ object of its own that is constructed when it is loaded.
    let scratch = Scratch::new();
    let behind = "#include <map>
        #include <string>
        static const std::map<std::string, int> words = { { \"one\", 1 }, { \"two\", 2 } };
        int value_of(const std::string &word) {
          if (!words.count(word)) throw std::string(\"no such word: \") + word;
          return words.at(word);
        }";
    let behind = scratch.cxx("libbehind.so", behind, &["-shared", "-fPIC"]);
    let codels = r#"
#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <thread>
int value_of(const std::string &word);
static std::string &greeting() { static std::string text("made before any codel"); return text; }
static struct constructed { constructed() { greeting() += ", at load"; } } constructed;

/* A thread that outlives the codel that started it. */
struct demo::worker {
  std::mutex m;
  std::condition_variable c;
  bool over = false;
  int32_t sum = 0, todo = 0;
  std::thread thread;
  worker(): thread([this] { run(); }) {}
  ~worker() {
    { std::lock_guard<std::mutex> l(m); over = true; }
    c.notify_all();
    thread.join();
  }
  void run() {
    std::unique_lock<std::mutex> l(m);
    while (!over) {
      c.wait(l, [this] { return over || todo; });
      sum += todo;
      todo = 0;
      c.notify_all();
    }
  }
  int32_t add(int32_t n) {
    std::unique_lock<std::mutex> l(m);
    todo = n;
    c.notify_all();
    c.wait(l, [this] { return !todo; });
    return sum;
  }
};

genom::event t_start(demo::worker *&team, int32_t &sum) {
  team = new demo::worker;
  sum = 0;
  return demo::ether;
}
genom::event a_start(const std::string &text, demo::worker *&team, int32_t &sum,
    std::string &made) {
  try {
    sum = team->add(value_of(text));
  } catch (const std::string &why) {
    throw std::runtime_error(why);
  }
  made = greeting() + ": " + std::to_string(sum);
  return demo::stop;
}
genom::event a_stop(demo::worker *&team) {
  delete team;
  team = nullptr;
  return demo::ether;
}
"#;
    let rpath = format!("-Wl,-rpath,{}", scratch.path().display());
    let demo = load(&compile(text, codels, &[behind.to_str().unwrap(), "-pthread", &rpath]), text);
    assert_eq!(demo.task("t_start"), "::demo::ether");
    for (text, sum) in [("one", 1), ("two", 3)] {
        let mut frame = demo.begin("add", json!({ "text": text }));
        assert_eq!(demo.call(&mut *frame, "a_start"), "::demo::stop");
        let made = format!("made before any codel, at load: {sum}");
        assert_eq!(frame.output().to_json(), json!({ "made": made }));
    }
    let mut frame = demo.begin("add", json!({ "text": "three" }));
    assert_eq!(demo.call(&mut *frame, "a_start"), "::genom::unkex");
    assert_eq!(frame.detail().unwrap()["what"], "no such word: three");
    assert_eq!(demo.call(&mut *frame, "a_stop"), "::demo::ether");
}

#[test]
fn types_that_differ_are_refused_by_the_debug_information_of_cxx() {
    let library = Library::open(&axis().library).unwrap();
    let report = contract::check(&library, &plan(AXIS).0, &|_| String::new());
    assert_eq!((report.checked, report.codels), (Checked::DebugInformation, 6));
    assert_eq!(report.differences, []);

    let differs = |from: &str, to: &str| {
        assert!(AXIS.contains(from), "{from}");
        refusal(&axis(), &AXIS.replacen(from, to, 1))
    };
    let told = differs("sequence<double> values; };", "sequence<float> values; };");
    let first = told.lines().take(3).collect::<Vec<_>>().join("\n");
    expect![[r#"
        demo.so: codel `t_start` (demo.gen:16): argument 1 `ids`: `demo::ids.last`: `demo::sample.values`: `std::vector< float >`: its element: `float` is wanted, not `double`
          .gen:    genom::event t_start(demo::ids &ids)
          library: event t_start(struct ids &ids)"#]]
    .assert_eq(&first);
    let told = differs("long count; };", "long count; string more; };");
    expect![[r#"
        demo.so: codel `t_start` (demo.gen:16): argument 1 `ids`: `demo::ids` has members last, all, handle, count, more; `struct ids` has last, all, handle, count
          .gen:    genom::event t_start(demo::ids &ids)
          library: event t_start(struct ids &ids)"#]]
    .assert_eq(&told);
    let told = differs("double limit; string what;", "double limit; string<8> what;");
    expect![[r#"
        demo.so: exception `::demo::TOO_FAR` (demo.gen:2): `demo::TOO_FAR::detail.what`: `char [8]` is wanted, not `string`
          .gen:    { double limit; char what[8]; std::vector< int32_t > tried; }
          library: { double limit; string what; struct vector<int, std::allocator<int> > tried; }"#]]
    .assert_eq(&told);
    let told = differs("port in sample input", "port out sample input");
    assert!(
        told.contains("an object with data, write is wanted, not one with data, read"),
        "{told}"
    );
    let told = differs("port multiple in sample ins", "port in sample ins");
    assert!(told.contains("the port is simple: its methods take nothing"), "{told}");
}
