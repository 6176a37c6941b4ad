//! Libraries with constructors, threads, and dependencies on other libraries.

use serde_json::json;

use crate::support::Scratch;
use crate::support::cxx::{compile, load};

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
    // A dependency with a C++ object that is constructed when it is loaded.
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
