/* Types and codels of demo in C: made by genomd, do not edit. */
#ifndef H_DEMO_C_TYPES
#define H_DEMO_C_TYPES

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

#ifndef _m_col_c_type
# define _m_col_c_type
typedef uint32_t m_col;
enum {
  m_RED = 0,
  m_GREEN = 1,
  m_BLUE = 2
};
#endif /* _m_col_c_type */

#ifndef _m_t_c_type
# define _m_t_c_type
struct m_t {
  uint8_t o;
  int8_t c;
};
#ifndef _m_t_forward_c_type
# define _m_t_forward_c_type
typedef struct m_t m_t;
#endif
#endif /* _m_t_c_type */

#ifndef _node_forward_c_type
# define _node_forward_c_type
typedef struct node node;
#endif /* _node_forward_c_type */

#ifndef _sequence_node_c_type
# define _sequence_node_c_type
struct sequence_node {
  uint32_t _maximum, _length;
  node *_buffer;
  void (*_release)(void *_buffer);
};
#ifndef _sequence_node_forward_c_type
# define _sequence_node_forward_c_type
typedef struct sequence_node sequence_node;
#endif
#endif /* _sequence_node_c_type */

#ifndef _nodes_c_type
# define _nodes_c_type
typedef sequence_node nodes;
#endif /* _nodes_c_type */

#ifndef _node_c_type
# define _node_c_type
struct node {
  int32_t value;
  nodes children;
  sequence_node more;
};
#ifndef _node_forward_c_type
# define _node_forward_c_type
typedef struct node node;
#endif
#endif /* _node_c_type */

#ifndef _i_long_type_c_type
# define _i_long_type_c_type
typedef int32_t i_long_type;
#endif /* _i_long_type_c_type */

#ifndef _i_param_c_type
# define _i_param_c_type
struct i_param {
  int32_t x;
};
#ifndef _i_param_forward_c_type
# define _i_param_forward_c_type
typedef struct i_param i_param;
#endif
#endif /* _i_param_c_type */

#ifndef _i_bad_c_type
# define _i_bad_c_type
GENOM_EVENT(i_bad_id, "::i::bad");
typedef struct i_bad_detail {
  int32_t why;
} i_bad_detail;

static inline genom_event
i_bad(const i_bad_detail *detail, genom_context self)
{
  return self->raise(i_bad_id, detail, sizeof(*detail), self);
}
#endif /* _i_bad_c_type */

