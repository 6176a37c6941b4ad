//! A component with ports, exceptions and an activity, whose codels several tests use.

use std::sync::{Arc, Mutex, Weak};

use crate::support::cxx::{Compiled, compile};

/// Ports, exceptions, IDS and natives.
pub(crate) const AXIS: &str = r#"
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

/// The library of these codels, compiled once for the tests that run at the same time.
pub(crate) fn axis() -> Arc<Compiled> {
    static SHARED: Mutex<Weak<Compiled>> = Mutex::new(Weak::new());
    // Without the flag gcc only emits the name of an abstract struct.
    let make = || compile(AXIS, AXIS_CODELS, &["-O2", "-femit-class-debug-always"]);
    let mut shared = SHARED.lock().unwrap();
    let compiled = shared.upgrade().unwrap_or_else(make);
    *shared = Arc::downgrade(&compiled);
    compiled
}
