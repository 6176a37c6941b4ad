/* Types and codels of hover in C: made by genomd, do not edit. */
#ifndef H_HOVER_C_TYPES
#define H_HOVER_C_TYPES

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "genom3/c/event.h"
#include "genom3/c/context.h"
#include "genom3/c/exception.h"
#include "genom3/c/idlsequence.h"

#ifdef __cplusplus
extern "C" {
#endif

#ifndef _genom_incompatible_digest_client_s_c_type
# define _genom_incompatible_digest_client_s_c_type
struct genom_incompatible_digest_client_s {
  char version[32];
  char date[32];
};
#ifndef _genom_incompatible_digest_client_s_forward_c_type
# define _genom_incompatible_digest_client_s_forward_c_type
typedef struct genom_incompatible_digest_client_s genom_incompatible_digest_client_s;
#endif
#endif /* _genom_incompatible_digest_client_s_c_type */

#ifndef _genom_incompatible_digest_server_s_c_type
# define _genom_incompatible_digest_server_s_c_type
struct genom_incompatible_digest_server_s {
  char version[32];
  char date[32];
};
#ifndef _genom_incompatible_digest_server_s_forward_c_type
# define _genom_incompatible_digest_server_s_forward_c_type
typedef struct genom_incompatible_digest_server_s genom_incompatible_digest_server_s;
#endif
#endif /* _genom_incompatible_digest_server_s_c_type */

#ifndef _genom_incompatible_digest_c_type
# define _genom_incompatible_digest_c_type
GENOM_EVENT(genom_incompatible_digest_id, "::genom::incompatible_digest");
typedef struct genom_incompatible_digest_detail {
  genom_incompatible_digest_client_s client;
  genom_incompatible_digest_server_s server;
} genom_incompatible_digest_detail;

static inline genom_event
genom_incompatible_digest(const genom_incompatible_digest_detail *detail, genom_context self)
{
  return self->raise(genom_incompatible_digest_id, detail, sizeof(*detail), self);
}
#endif /* _genom_incompatible_digest_c_type */

#ifndef _genom_bad_transition_c_type
# define _genom_bad_transition_c_type
GENOM_EVENT(genom_bad_transition_id, "::genom::bad_transition");
typedef struct genom_bad_transition_detail {
  char from[128];
  char to[128];
} genom_bad_transition_detail;

static inline genom_event
genom_bad_transition(const genom_bad_transition_detail *detail, genom_context self)
{
  return self->raise(genom_bad_transition_id, detail, sizeof(*detail), self);
}
#endif /* _genom_bad_transition_c_type */

#ifndef _genom_interrupted_c_type
# define _genom_interrupted_c_type
GENOM_EVENT(genom_interrupted_id, "::genom::interrupted");
typedef struct genom_interrupted_detail {
  char by[128];
} genom_interrupted_detail;

static inline genom_event
genom_interrupted(const genom_interrupted_detail *detail, genom_context self)
{
  return self->raise(genom_interrupted_id, detail, sizeof(*detail), self);
}
#endif /* _genom_interrupted_c_type */

#ifndef _genom_serialization_c_type
# define _genom_serialization_c_type
GENOM_EVENT(genom_serialization_id, "::genom::serialization");
typedef void genom_serialization_detail;

static inline genom_event
genom_serialization(genom_context self)
{
  return self->raise(genom_serialization_id, NULL, 0, self);
}
#endif /* _genom_serialization_c_type */

#ifndef _genom_too_many_activities_c_type
# define _genom_too_many_activities_c_type
GENOM_EVENT(genom_too_many_activities_id, "::genom::too_many_activities");
typedef void genom_too_many_activities_detail;

static inline genom_event
genom_too_many_activities(genom_context self)
{
  return self->raise(genom_too_many_activities_id, NULL, 0, self);
}
#endif /* _genom_too_many_activities_c_type */

#ifndef _genom_disallowed_c_type
# define _genom_disallowed_c_type
GENOM_EVENT(genom_disallowed_id, "::genom::disallowed");
typedef void genom_disallowed_detail;

static inline genom_event
genom_disallowed(genom_context self)
{
  return self->raise(genom_disallowed_id, NULL, 0, self);
}
#endif /* _genom_disallowed_c_type */

#ifndef _genom_mwerr_c_type
# define _genom_mwerr_c_type
GENOM_EVENT(genom_mwerr_id, "::genom::mwerr");
typedef struct genom_mwerr_detail {
  char what[256];
} genom_mwerr_detail;

static inline genom_event
genom_mwerr(const genom_mwerr_detail *detail, genom_context self)
{
  return self->raise(genom_mwerr_id, detail, sizeof(*detail), self);
}
#endif /* _genom_mwerr_c_type */

#ifndef _genom_no_such_inport_c_type
# define _genom_no_such_inport_c_type
GENOM_EVENT(genom_no_such_inport_id, "::genom::no_such_inport");
typedef void genom_no_such_inport_detail;

static inline genom_event
genom_no_such_inport(genom_context self)
{
  return self->raise(genom_no_such_inport_id, NULL, 0, self);
}
#endif /* _genom_no_such_inport_c_type */

#ifndef _genom_no_such_outport_c_type
# define _genom_no_such_outport_c_type
GENOM_EVENT(genom_no_such_outport_id, "::genom::no_such_outport");
typedef void genom_no_such_outport_detail;

static inline genom_event
genom_no_such_outport(genom_context self)
{
  return self->raise(genom_no_such_outport_id, NULL, 0, self);
}
#endif /* _genom_no_such_outport_c_type */

#ifndef _genom_port_io_c_type
# define _genom_port_io_c_type
GENOM_EVENT(genom_port_io_id, "::genom::port_io");
typedef void genom_port_io_detail;

static inline genom_event
genom_port_io(genom_context self)
{
  return self->raise(genom_port_io_id, NULL, 0, self);
}
#endif /* _genom_port_io_c_type */

#ifndef _genom_no_such_remote_c_type
# define _genom_no_such_remote_c_type
GENOM_EVENT(genom_no_such_remote_id, "::genom::no_such_remote");
typedef void genom_no_such_remote_detail;

static inline genom_event
genom_no_such_remote(genom_context self)
{
  return self->raise(genom_no_such_remote_id, NULL, 0, self);
}
#endif /* _genom_no_such_remote_c_type */

#ifndef _genom_no_such_service_c_type
# define _genom_no_such_service_c_type
GENOM_EVENT(genom_no_such_service_id, "::genom::no_such_service");
typedef void genom_no_such_service_detail;

static inline genom_event
genom_no_such_service(genom_context self)
{
  return self->raise(genom_no_such_service_id, NULL, 0, self);
}
#endif /* _genom_no_such_service_c_type */

#ifndef _genom_remote_io_c_type
# define _genom_remote_io_c_type
GENOM_EVENT(genom_remote_io_id, "::genom::remote_io");
typedef void genom_remote_io_detail;

static inline genom_event
genom_remote_io(genom_context self)
{
  return self->raise(genom_remote_io_id, NULL, 0, self);
}
#endif /* _genom_remote_io_c_type */

#ifndef _genom_no_such_activity_c_type
# define _genom_no_such_activity_c_type
GENOM_EVENT(genom_no_such_activity_id, "::genom::no_such_activity");
typedef void genom_no_such_activity_detail;

static inline genom_event
genom_no_such_activity(genom_context self)
{
  return self->raise(genom_no_such_activity_id, NULL, 0, self);
}
#endif /* _genom_no_such_activity_c_type */

#ifndef _genom_state_stats_c_type
# define _genom_state_stats_c_type
struct genom_state_stats {
  float last;
  float max;
  float avg;
};
#ifndef _genom_state_stats_forward_c_type
# define _genom_state_stats_forward_c_type
typedef struct genom_state_stats genom_state_stats;
#endif
#endif /* _genom_state_stats_c_type */

#ifndef _genom_state_rusage_c_type
# define _genom_state_rusage_c_type
struct genom_state_rusage {
  uint32_t cycles;
  genom_state_stats timings;
  genom_state_stats load;
};
#ifndef _genom_state_rusage_forward_c_type
# define _genom_state_rusage_forward_c_type
typedef struct genom_state_rusage genom_state_rusage;
#endif
#endif /* _genom_state_rusage_c_type */

#ifndef _genom_state_activity_c_type
# define _genom_state_activity_c_type
struct genom_state_activity {
  uint32_t id;
  char name[64];
};
#ifndef _genom_state_activity_forward_c_type
# define _genom_state_activity_forward_c_type
typedef struct genom_state_activity genom_state_activity;
#endif
#endif /* _genom_state_activity_c_type */

#ifndef _genom_state_activity_forward_c_type
# define _genom_state_activity_forward_c_type
typedef struct genom_state_activity genom_state_activity;
#endif /* _genom_state_activity_forward_c_type */

#ifndef _sequence_genom_state_activity_c_type
# define _sequence_genom_state_activity_c_type
struct sequence_genom_state_activity {
  uint32_t _maximum, _length;
  genom_state_activity *_buffer;
  void (*_release)(void *_buffer);
};
#ifndef _sequence_genom_state_activity_forward_c_type
# define _sequence_genom_state_activity_forward_c_type
typedef struct sequence_genom_state_activity sequence_genom_state_activity;
#endif
#endif /* _sequence_genom_state_activity_c_type */

#ifndef _genom_state_task_c_type
# define _genom_state_task_c_type
struct genom_state_task {
  char name[64];
  genom_state_rusage rusage;
  sequence_genom_state_activity activity;
};
#ifndef _genom_state_task_forward_c_type
# define _genom_state_task_forward_c_type
typedef struct genom_state_task genom_state_task;
#endif
#endif /* _genom_state_task_c_type */

#ifndef _genom_state_task_forward_c_type
# define _genom_state_task_forward_c_type
typedef struct genom_state_task genom_state_task;
#endif /* _genom_state_task_forward_c_type */

#ifndef _sequence_genom_state_task_c_type
# define _sequence_genom_state_task_c_type
struct sequence_genom_state_task {
  uint32_t _maximum, _length;
  genom_state_task *_buffer;
  void (*_release)(void *_buffer);
};
#ifndef _sequence_genom_state_task_forward_c_type
# define _sequence_genom_state_task_forward_c_type
typedef struct sequence_genom_state_task sequence_genom_state_task;
#endif
#endif /* _sequence_genom_state_task_c_type */

#ifndef _genom_state_component_c_type
# define _genom_state_component_c_type
struct genom_state_component {
  sequence_genom_state_task task;
  char digest[33];
  char date[31];
  char version[32];
};
#ifndef _genom_state_component_forward_c_type
# define _genom_state_component_forward_c_type
typedef struct genom_state_component genom_state_component;
#endif
#endif /* _genom_state_component_c_type */

#ifndef _sequence16_double_c_type
# define _sequence16_double_c_type
struct sequence16_double {
#if defined(__cplusplus) && __cplusplus >= 201402L
  uint32_t _maximum = 16, _length = 0;
#else
  uint32_t _maximum, _length;
#endif
  double _buffer[16];
#if defined(__cplusplus) && __cplusplus < 201402L
  sequence16_double() : _maximum(16), _length(0) {}
#endif
};
#ifndef _sequence16_double_forward_c_type
# define _sequence16_double_forward_c_type
typedef struct sequence16_double sequence16_double;
#endif
#endif /* _sequence16_double_c_type */

#ifndef _robot_numbers_c_type
# define _robot_numbers_c_type
typedef sequence16_double robot_numbers;
#endif /* _robot_numbers_c_type */

#ifndef _robot_joints_c_type
# define _robot_joints_c_type
struct robot_joints {
  uint64_t date;
  robot_numbers position;
  robot_numbers velocity;
  robot_numbers effort;
};
#ifndef _robot_joints_forward_c_type
# define _robot_joints_forward_c_type
typedef struct robot_joints robot_joints;
#endif
#endif /* _robot_joints_c_type */

#ifndef _robot_base_c_type
# define _robot_base_c_type
struct robot_base {
  uint64_t date;
  double position[3];
  double attitude[4];
  double velocity[3];
  double rate[3];
};
#ifndef _robot_base_forward_c_type
# define _robot_base_forward_c_type
typedef struct robot_base robot_base;
#endif
#endif /* _robot_base_c_type */

#ifndef _robot_efforts_c_type
# define _robot_efforts_c_type
struct robot_efforts {
  robot_numbers effort;
};
#ifndef _robot_efforts_forward_c_type
# define _robot_efforts_forward_c_type
typedef struct robot_efforts robot_efforts;
#endif
#endif /* _robot_efforts_c_type */

#ifndef _robot_target_c_type
# define _robot_target_c_type
struct robot_target {
  robot_numbers position;
  robot_numbers velocity;
};
#ifndef _robot_target_forward_c_type
# define _robot_target_forward_c_type
typedef struct robot_target robot_target;
#endif
#endif /* _robot_target_c_type */

#ifndef _hover_NO_POSITION_c_type
# define _hover_NO_POSITION_c_type
GENOM_EVENT(hover_NO_POSITION_id, "::hover::NO_POSITION");
typedef void hover_NO_POSITION_detail;

static inline genom_event
hover_NO_POSITION(genom_context self)
{
  return self->raise(hover_NO_POSITION_id, NULL, 0, self);
}
#endif /* _hover_NO_POSITION_c_type */

#ifndef _hover_NO_PLACE_c_type
# define _hover_NO_PLACE_c_type
GENOM_EVENT(hover_NO_PLACE_id, "::hover::NO_PLACE");
typedef void hover_NO_PLACE_detail;

static inline genom_event
hover_NO_PLACE(genom_context self)
{
  return self->raise(hover_NO_PLACE_id, NULL, 0, self);
}
#endif /* _hover_NO_PLACE_c_type */

#ifndef _hover_craft_c_type
# define _hover_craft_c_type
struct hover_craft {
  double mass;
  double arm;
  double drag;
  double thrust;
};
#ifndef _hover_craft_forward_c_type
# define _hover_craft_forward_c_type
typedef struct hover_craft hover_craft;
#endif
#endif /* _hover_craft_c_type */

#ifndef _hover_gains_c_type
# define _hover_gains_c_type
struct hover_gains {
  double position;
  double velocity;
  double tilt;
  double tilt_rate;
  double yaw;
  double yaw_rate;
};
#ifndef _hover_gains_forward_c_type
# define _hover_gains_forward_c_type
typedef struct hover_gains hover_gains;
#endif
#endif /* _hover_gains_c_type */

#ifndef _hover_place_c_type
# define _hover_place_c_type
struct hover_place {
  double x;
  double y;
  double z;
};
#ifndef _hover_place_forward_c_type
# define _hover_place_forward_c_type
typedef struct hover_place hover_place;
#endif
#endif /* _hover_place_c_type */

#ifndef _hover_ids_c_type
# define _hover_ids_c_type
struct hover_ids {
  hover_craft craft;
  hover_gains gains;
  double speed;
  hover_place wanted;
  bool sent;
};
#ifndef _hover_ids_forward_c_type
# define _hover_ids_forward_c_type
typedef struct hover_ids hover_ids;
#endif
#endif /* _hover_ids_c_type */

#ifndef _robot_MOST_c_type
# define _robot_MOST_c_type
static const uint32_t robot_MOST = 16U;
#endif /* _robot_MOST_c_type */

#ifndef _hover_ether_c_type
# define _hover_ether_c_type
GENOM_EVENT(hover_ether, "::hover::ether");
#endif /* _hover_ether_c_type */

#ifndef _hover_start_c_type
# define _hover_start_c_type
GENOM_EVENT(hover_start, "::hover::start");
#endif /* _hover_start_c_type */

#ifndef _hover_stop_c_type
# define _hover_stop_c_type
GENOM_EVENT(hover_stop, "::hover::stop");
#endif /* _hover_stop_c_type */

#ifndef _hover_main_c_type
# define _hover_main_c_type
GENOM_EVENT(hover_main, "::hover::main");
#endif /* _hover_main_c_type */

#ifndef _hover_pause_start_c_type
# define _hover_pause_start_c_type
GENOM_EVENT(hover_pause_start, "::hover::pause::start");
#endif /* _hover_pause_start_c_type */

#ifndef _hover_pause_main_c_type
# define _hover_pause_main_c_type
GENOM_EVENT(hover_pause_main, "::hover::pause::main");
#endif /* _hover_pause_main_c_type */

#ifndef _hover_genom_state_c_type
# define _hover_genom_state_c_type
typedef struct hover_genom_state {
  genom_state_component *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} hover_genom_state;
#endif /* _hover_genom_state_c_type */

#ifndef _hover_base_c_type
# define _hover_base_c_type
typedef struct hover_base {
  robot_base *(*data)(genom_context self);
  genom_event (*read)(genom_context self);
} hover_base;
#endif /* _hover_base_c_type */

#ifndef _hover_command_c_type
# define _hover_command_c_type
typedef struct hover_command {
  robot_efforts *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} hover_command;
#endif /* _hover_command_c_type */

/* Codels of hover. */
genom_event hover_init(hover_ids *ids, const genom_context self);
genom_event hover_begin(const hover_base *base, hover_place *setpoint, double *elapsed, const genom_context self);
genom_event hover_step(double duration, const hover_craft *craft, const hover_gains *gains, double speed, const hover_place *wanted, bool sent, const hover_base *base, hover_place *setpoint, double *elapsed, const hover_command *command, const genom_context self);
genom_event hover_release(const hover_command *command, const genom_context self);
genom_event hover_set(const hover_place *goal, double tolerance, hover_place *wanted, bool *sent, const genom_context self);
genom_event hover_arrive(const hover_place *goal, double tolerance, const hover_base *base, const genom_context self);
genom_event hover_rest(const genom_context self);

#ifdef __cplusplus
}
#endif

#endif /* H_HOVER_C_TYPES */
