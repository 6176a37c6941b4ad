//! Values of every type, passed to codels and back.

use serde_json::json;

use crate::support::cxx::{compile, load};

/// Every kind of type, in a function whose codel copies `in` to `out`.
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
