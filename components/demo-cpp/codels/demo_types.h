/* Types and codels of demo in C++: made by genomd, do not edit. */
#ifndef H_DEMO_CXX_TYPES
#define H_DEMO_CXX_TYPES

#include <cstdint>
#include <string>
#include <vector>

#include "genom3/c++/event.h"
#include "genom3/c++/exception.h"
#include "genom3/c++/idloptional.h"
#include "genom3/c++/idlsequence.h"

#ifndef _genom_incompatible_digest_cxx_type
# define _genom_incompatible_digest_cxx_type
namespace genom {
GENOM_CXX_EVENT(incompatible_digest_id, "::genom::incompatible_digest");
struct __attribute__((visibility("default"))) incompatible_digest : public genom::exception {
  struct client_s {
    char version[32];
    char date[32];
  };
  struct server_s {
    char version[32];
    char date[32];
  };
  struct detail {
    genom::incompatible_digest::client_s client;
    genom::incompatible_digest::server_s server;
  } detail;

  incompatible_digest(): detail() {}
  explicit incompatible_digest(const struct detail &d): detail(d) {}
  const char *what() const { return incompatible_digest_id; }
};
}
#endif /* _genom_incompatible_digest_cxx_type */

#ifndef _genom_bad_transition_cxx_type
# define _genom_bad_transition_cxx_type
namespace genom {
GENOM_CXX_EVENT(bad_transition_id, "::genom::bad_transition");
struct __attribute__((visibility("default"))) bad_transition : public genom::exception {
  struct detail {
    char from[128];
    char to[128];
  } detail;

  bad_transition(): detail() {}
  explicit bad_transition(const struct detail &d): detail(d) {}
  const char *what() const { return bad_transition_id; }
};
}
#endif /* _genom_bad_transition_cxx_type */

#ifndef _genom_interrupted_cxx_type
# define _genom_interrupted_cxx_type
namespace genom {
GENOM_CXX_EVENT(interrupted_id, "::genom::interrupted");
struct __attribute__((visibility("default"))) interrupted : public genom::exception {
  struct detail {
    char by[128];
  } detail;

  interrupted(): detail() {}
  explicit interrupted(const struct detail &d): detail(d) {}
  const char *what() const { return interrupted_id; }
};
}
#endif /* _genom_interrupted_cxx_type */

#ifndef _genom_serialization_cxx_type
# define _genom_serialization_cxx_type
namespace genom {
GENOM_CXX_EVENT(serialization_id, "::genom::serialization");
struct __attribute__((visibility("default"))) serialization : public genom::exception {
  typedef void detail;
  const char *what() const { return serialization_id; }
};
}
#endif /* _genom_serialization_cxx_type */

#ifndef _genom_too_many_activities_cxx_type
# define _genom_too_many_activities_cxx_type
namespace genom {
GENOM_CXX_EVENT(too_many_activities_id, "::genom::too_many_activities");
struct __attribute__((visibility("default"))) too_many_activities : public genom::exception {
  typedef void detail;
  const char *what() const { return too_many_activities_id; }
};
}
#endif /* _genom_too_many_activities_cxx_type */

#ifndef _genom_disallowed_cxx_type
# define _genom_disallowed_cxx_type
namespace genom {
GENOM_CXX_EVENT(disallowed_id, "::genom::disallowed");
struct __attribute__((visibility("default"))) disallowed : public genom::exception {
  typedef void detail;
  const char *what() const { return disallowed_id; }
};
}
#endif /* _genom_disallowed_cxx_type */

#ifndef _genom_mwerr_cxx_type
# define _genom_mwerr_cxx_type
namespace genom {
GENOM_CXX_EVENT(mwerr_id, "::genom::mwerr");
struct __attribute__((visibility("default"))) mwerr : public genom::exception {
  struct detail {
    char what[256];
  } detail;

  mwerr(): detail() {}
  explicit mwerr(const struct detail &d): detail(d) {}
  const char *what() const { return mwerr_id; }
};
}
#endif /* _genom_mwerr_cxx_type */

#ifndef _genom_no_such_inport_cxx_type
# define _genom_no_such_inport_cxx_type
namespace genom {
GENOM_CXX_EVENT(no_such_inport_id, "::genom::no_such_inport");
struct __attribute__((visibility("default"))) no_such_inport : public genom::exception {
  typedef void detail;
  const char *what() const { return no_such_inport_id; }
};
}
#endif /* _genom_no_such_inport_cxx_type */

#ifndef _genom_no_such_outport_cxx_type
# define _genom_no_such_outport_cxx_type
namespace genom {
GENOM_CXX_EVENT(no_such_outport_id, "::genom::no_such_outport");
struct __attribute__((visibility("default"))) no_such_outport : public genom::exception {
  typedef void detail;
  const char *what() const { return no_such_outport_id; }
};
}
#endif /* _genom_no_such_outport_cxx_type */

#ifndef _genom_port_io_cxx_type
# define _genom_port_io_cxx_type
namespace genom {
GENOM_CXX_EVENT(port_io_id, "::genom::port_io");
struct __attribute__((visibility("default"))) port_io : public genom::exception {
  typedef void detail;
  const char *what() const { return port_io_id; }
};
}
#endif /* _genom_port_io_cxx_type */

#ifndef _genom_no_such_remote_cxx_type
# define _genom_no_such_remote_cxx_type
namespace genom {
GENOM_CXX_EVENT(no_such_remote_id, "::genom::no_such_remote");
struct __attribute__((visibility("default"))) no_such_remote : public genom::exception {
  typedef void detail;
  const char *what() const { return no_such_remote_id; }
};
}
#endif /* _genom_no_such_remote_cxx_type */

#ifndef _genom_no_such_service_cxx_type
# define _genom_no_such_service_cxx_type
namespace genom {
GENOM_CXX_EVENT(no_such_service_id, "::genom::no_such_service");
struct __attribute__((visibility("default"))) no_such_service : public genom::exception {
  typedef void detail;
  const char *what() const { return no_such_service_id; }
};
}
#endif /* _genom_no_such_service_cxx_type */

#ifndef _genom_remote_io_cxx_type
# define _genom_remote_io_cxx_type
namespace genom {
GENOM_CXX_EVENT(remote_io_id, "::genom::remote_io");
struct __attribute__((visibility("default"))) remote_io : public genom::exception {
  typedef void detail;
  const char *what() const { return remote_io_id; }
};
}
#endif /* _genom_remote_io_cxx_type */

#ifndef _genom_no_such_activity_cxx_type
# define _genom_no_such_activity_cxx_type
namespace genom {
GENOM_CXX_EVENT(no_such_activity_id, "::genom::no_such_activity");
struct __attribute__((visibility("default"))) no_such_activity : public genom::exception {
  typedef void detail;
  const char *what() const { return no_such_activity_id; }
};
}
#endif /* _genom_no_such_activity_cxx_type */

#ifndef _genom_state_stats_cxx_type
# define _genom_state_stats_cxx_type
namespace genom { namespace state {
struct stats {
  float last;
  float max;
  float avg;
};
}}
#endif /* _genom_state_stats_cxx_type */

#ifndef _genom_state_rusage_cxx_type
# define _genom_state_rusage_cxx_type
namespace genom { namespace state {
struct rusage {
  uint32_t cycles;
  genom::state::stats timings;
  genom::state::stats load;
};
}}
#endif /* _genom_state_rusage_cxx_type */

#ifndef _genom_state_activity_cxx_type
# define _genom_state_activity_cxx_type
namespace genom { namespace state {
struct activity {
  uint32_t id;
  char name[64];
};
}}
#endif /* _genom_state_activity_cxx_type */

#ifndef _genom_state_activity_forward_cxx_type
# define _genom_state_activity_forward_cxx_type
namespace genom { namespace state {
struct activity;
}}
#endif /* _genom_state_activity_forward_cxx_type */

#ifndef _genom_state_task_cxx_type
# define _genom_state_task_cxx_type
namespace genom { namespace state {
struct task {
  char name[64];
  genom::state::rusage rusage;
  std::vector< genom::state::activity > activity;
};
}}
#endif /* _genom_state_task_cxx_type */

#ifndef _genom_state_task_forward_cxx_type
# define _genom_state_task_forward_cxx_type
namespace genom { namespace state {
struct task;
}}
#endif /* _genom_state_task_forward_cxx_type */

#ifndef _genom_state_component_cxx_type
# define _genom_state_component_cxx_type
namespace genom { namespace state {
struct component {
  std::vector< genom::state::task > task;
  char digest[33];
  char date[31];
  char version[32];
};
}}
#endif /* _genom_state_component_cxx_type */

#ifndef _demo_OUT_OF_RANGE_cxx_type
# define _demo_OUT_OF_RANGE_cxx_type
namespace demo {
GENOM_CXX_EVENT(OUT_OF_RANGE_id, "::demo::OUT_OF_RANGE");
struct __attribute__((visibility("default"))) OUT_OF_RANGE : public genom::exception {
  struct detail {
    double value;
    double lower;
    double upper;
    char what[64];
  } detail;

  OUT_OF_RANGE(): detail() {}
  explicit OUT_OF_RANGE(const struct detail &d): detail(d) {}
  const char *what() const { return OUT_OF_RANGE_id; }
};
}
#endif /* _demo_OUT_OF_RANGE_cxx_type */

#ifndef _demo_MOVING_cxx_type
# define _demo_MOVING_cxx_type
namespace demo {
GENOM_CXX_EVENT(MOVING_id, "::demo::MOVING");
struct __attribute__((visibility("default"))) MOVING : public genom::exception {
  typedef void detail;
  const char *what() const { return MOVING_id; }
};
}
#endif /* _demo_MOVING_cxx_type */

#ifndef _demo_HALTED_cxx_type
# define _demo_HALTED_cxx_type
namespace demo {
GENOM_CXX_EVENT(HALTED_id, "::demo::HALTED");
struct __attribute__((visibility("default"))) HALTED : public genom::exception {
  typedef void detail;
  const char *what() const { return HALTED_id; }
};
}
#endif /* _demo_HALTED_cxx_type */

#ifndef _demo_BAD_ROUTE_cxx_type
# define _demo_BAD_ROUTE_cxx_type
namespace demo {
GENOM_CXX_EVENT(BAD_ROUTE_id, "::demo::BAD_ROUTE");
struct __attribute__((visibility("default"))) BAD_ROUTE : public genom::exception {
  struct detail {
    std::string what;
    std::vector< double > route;
  } detail;

  BAD_ROUTE(): detail() {}
  explicit BAD_ROUTE(const struct detail &d): detail(d) {}
  const char *what() const { return BAD_ROUTE_id; }
};
}
#endif /* _demo_BAD_ROUTE_cxx_type */

#ifndef _demo_state_cxx_type
# define _demo_state_cxx_type
namespace demo {
struct state {
  double position;
  double velocity;
};
}
#endif /* _demo_state_cxx_type */

#ifndef _demo_gain_cxx_type
# define _demo_gain_cxx_type
namespace demo {
typedef double gain;
}
#endif /* _demo_gain_cxx_type */

#ifndef _demo_state_forward_cxx_type
# define _demo_state_forward_cxx_type
namespace demo {
struct state;
}
#endif /* _demo_state_forward_cxx_type */

#ifndef _demo_trace_cxx_type
# define _demo_trace_cxx_type
namespace demo {
struct trace {
  std::string axis;
  std::vector< demo::state > states;
  genom::optional< double > next;
};
}
#endif /* _demo_trace_cxx_type */

#ifndef _demo_ids_cxx_type
# define _demo_ids_cxx_type
namespace demo {
struct ids {
  double velocity;
  demo::state current;
  std::string name;
  bool halted;
};
}
#endif /* _demo_ids_cxx_type */

#ifndef _demo_ether_cxx_type
# define _demo_ether_cxx_type
namespace demo {
GENOM_CXX_EVENT(ether, "::demo::ether");
}
#endif /* _demo_ether_cxx_type */

#ifndef _demo_start_cxx_type
# define _demo_start_cxx_type
namespace demo {
GENOM_CXX_EVENT(start, "::demo::start");
}
#endif /* _demo_start_cxx_type */

#ifndef _demo_stop_cxx_type
# define _demo_stop_cxx_type
namespace demo {
GENOM_CXX_EVENT(stop, "::demo::stop");
}
#endif /* _demo_stop_cxx_type */

#ifndef _demo_emergency_cxx_type
# define _demo_emergency_cxx_type
namespace demo {
GENOM_CXX_EVENT(emergency, "::demo::emergency");
}
#endif /* _demo_emergency_cxx_type */

#ifndef _demo_main_cxx_type
# define _demo_main_cxx_type
namespace demo {
GENOM_CXX_EVENT(main, "::demo::main");
}
#endif /* _demo_main_cxx_type */

#ifndef _demo_arrived_cxx_type
# define _demo_arrived_cxx_type
namespace demo {
GENOM_CXX_EVENT(arrived, "::demo::arrived");
}
#endif /* _demo_arrived_cxx_type */

#ifndef _demo_pause_stop_cxx_type
# define _demo_pause_stop_cxx_type
namespace demo { namespace pause {
GENOM_CXX_EVENT(stop, "::demo::pause::stop");
}}
#endif /* _demo_pause_stop_cxx_type */

#ifndef _demo_pause_main_cxx_type
# define _demo_pause_main_cxx_type
namespace demo { namespace pause {
GENOM_CXX_EVENT(main, "::demo::pause::main");
}}
#endif /* _demo_pause_main_cxx_type */

#ifndef _demo_genom_state_cxx_type
# define _demo_genom_state_cxx_type
namespace demo {
struct genom_state {
  virtual genom::state::component &data() const = 0;
  virtual void write() = 0;
};
}
#endif /* _demo_genom_state_cxx_type */

#ifndef _demo_parameter_cxx_type
# define _demo_parameter_cxx_type
namespace demo {
struct parameter {
  virtual const demo::gain &data() const = 0;
  virtual void read() = 0;
};
}
#endif /* _demo_parameter_cxx_type */

#ifndef _demo_position_cxx_type
# define _demo_position_cxx_type
namespace demo {
struct position {
  virtual demo::state &data() const = 0;
  virtual void write() = 0;
};
}
#endif /* _demo_position_cxx_type */

#ifndef _demo_passed_cxx_type
# define _demo_passed_cxx_type
namespace demo {
struct passed {
  virtual demo::trace &data() const = 0;
  virtual void write() = 0;
};
}
#endif /* _demo_passed_cxx_type */

#pragma GCC visibility push(default)
/* Codels of demo. */
genom::event demo_init(demo::ids &ids, demo::position &position);
genom::event demo_check_velocity(double velocity);
genom::event demo_reset(demo::state &current);
genom::event demo_check_goal(double goal);
genom::event demo_begin(bool &halted);
genom::event demo_servo(double goal, double velocity, bool halted, demo::state &current, demo::parameter &parameter, demo::position &position);
genom::event demo_brake(demo::state &current, demo::position &position);
genom::event demo_halt(demo::state &current, bool &halted, demo::position &position);
genom::event demo_check_route(const std::vector< double > &route);
genom::event demo_depart(const std::string &name, uint32_t &next, demo::trace &trace, bool &halted);
genom::event demo_travel(const std::vector< double > &route, double velocity, bool halted, uint32_t &next, demo::state &current, demo::trace &trace, demo::parameter &parameter, demo::position &position, demo::passed &passed);
genom::event demo_report(const demo::trace &trace, std::vector< demo::state > &stops, std::string &report);
#pragma GCC visibility pop

#endif /* H_DEMO_CXX_TYPES */
