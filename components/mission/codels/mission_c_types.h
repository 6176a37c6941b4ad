/* Types and codels of mission in C: made by genomd, do not edit. */
#ifndef H_MISSION_C_TYPES
#define H_MISSION_C_TYPES

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

#ifndef _axis_OUT_OF_RANGE_c_type
# define _axis_OUT_OF_RANGE_c_type
GENOM_EVENT(axis_OUT_OF_RANGE_id, "::axis::OUT_OF_RANGE");
typedef struct axis_OUT_OF_RANGE_detail {
  double value;
  double lower;
  double upper;
  char what[64];
} axis_OUT_OF_RANGE_detail;

static inline genom_event
axis_OUT_OF_RANGE(const axis_OUT_OF_RANGE_detail *detail, genom_context self)
{
  return self->raise(axis_OUT_OF_RANGE_id, detail, sizeof(*detail), self);
}
#endif /* _axis_OUT_OF_RANGE_c_type */

#ifndef _axis_HALTED_c_type
# define _axis_HALTED_c_type
GENOM_EVENT(axis_HALTED_id, "::axis::HALTED");
typedef void axis_HALTED_detail;

static inline genom_event
axis_HALTED(genom_context self)
{
  return self->raise(axis_HALTED_id, NULL, 0, self);
}
#endif /* _axis_HALTED_c_type */

#ifndef _mission_state_c_type
# define _mission_state_c_type
struct mission_state {
  double position;
  double velocity;
};
#ifndef _mission_state_forward_c_type
# define _mission_state_forward_c_type
typedef struct mission_state mission_state;
#endif
#endif /* _mission_state_c_type */

#ifndef _mission_ends_c_type
# define _mission_ends_c_type
struct mission_ends {
  double near;
  double far;
};
#ifndef _mission_ends_forward_c_type
# define _mission_ends_forward_c_type
typedef struct mission_ends mission_ends;
#endif
#endif /* _mission_ends_c_type */

#ifndef _mission_factor_c_type
# define _mission_factor_c_type
typedef double mission_factor;
#endif /* _mission_factor_c_type */

#ifndef _mission_ids_c_type
# define _mission_ids_c_type
struct mission_ids {
  mission_ends turns;
  double margin;
};
#ifndef _mission_ids_forward_c_type
# define _mission_ids_forward_c_type
typedef struct mission_ids mission_ids;
#endif
#endif /* _mission_ids_c_type */

#ifndef _mission_ether_c_type
# define _mission_ether_c_type
GENOM_EVENT(mission_ether, "::mission::ether");
#endif /* _mission_ether_c_type */

#ifndef _mission_start_c_type
# define _mission_start_c_type
GENOM_EVENT(mission_start, "::mission::start");
#endif /* _mission_start_c_type */

#ifndef _mission_stop_c_type
# define _mission_stop_c_type
GENOM_EVENT(mission_stop, "::mission::stop");
#endif /* _mission_stop_c_type */

#ifndef _mission_main_c_type
# define _mission_main_c_type
GENOM_EVENT(mission_main, "::mission::main");
#endif /* _mission_main_c_type */

#ifndef _mission_leg_c_type
# define _mission_leg_c_type
GENOM_EVENT(mission_leg, "::mission::leg");
#endif /* _mission_leg_c_type */

#ifndef _mission_pause_main_c_type
# define _mission_pause_main_c_type
GENOM_EVENT(mission_pause_main, "::mission::pause::main");
#endif /* _mission_pause_main_c_type */

#ifndef _mission_genom_state_c_type
# define _mission_genom_state_c_type
typedef struct mission_genom_state {
  genom_state_component *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} mission_genom_state;
#endif /* _mission_genom_state_c_type */

#ifndef _mission_position_c_type
# define _mission_position_c_type
typedef struct mission_position {
  mission_state *(*data)(genom_context self);
  genom_event (*read)(genom_context self);
} mission_position;
#endif /* _mission_position_c_type */

#ifndef _mission_gain_c_type
# define _mission_gain_c_type
typedef struct mission_gain {
  mission_factor *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} mission_gain;
#endif /* _mission_gain_c_type */

#ifndef _mission_goto_c_type
# define _mission_goto_c_type
typedef struct mission_goto {
  genom_event (*call)(double goal, genom_context self);
} mission_goto;
#endif /* _mission_goto_c_type */

/* Codels of mission. */
genom_event mission_init(mission_ids *ids, const mission_gain *gain, const genom_context self);
genom_event mission_watch(const mission_ends *turns, double margin, const mission_position *position, const mission_gain *gain, const genom_context self);
genom_event mission_begin(uint32_t *legs, const genom_context self);
genom_event mission_turn(uint32_t rounds, const mission_ends *turns, uint32_t *legs, double *goal, const genom_context self);
genom_event mission_send(double goal, const mission_goto *goto_, const genom_context self);
genom_event mission_end(const genom_context self);

#ifdef __cplusplus
}
#endif

#endif /* H_MISSION_C_TYPES */
