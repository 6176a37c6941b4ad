/* Types and codels of camera in C: made by genomd, do not edit. */
#ifndef H_CAMERA_C_TYPES
#define H_CAMERA_C_TYPES

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

#ifndef _images_time_c_type
# define _images_time_c_type
struct images_time {
  int32_t sec;
  uint32_t nanosec;
};
#ifndef _images_time_forward_c_type
# define _images_time_forward_c_type
typedef struct images_time images_time;
#endif
#endif /* _images_time_c_type */

#ifndef _sequence307200_octet_c_type
# define _sequence307200_octet_c_type
struct sequence307200_octet {
#if defined(__cplusplus) && __cplusplus >= 201402L
  uint32_t _maximum = 307200, _length = 0;
#else
  uint32_t _maximum, _length;
#endif
  uint8_t _buffer[307200];
#if defined(__cplusplus) && __cplusplus < 201402L
  sequence307200_octet() : _maximum(307200), _length(0) {}
#endif
};
#ifndef _sequence307200_octet_forward_c_type
# define _sequence307200_octet_forward_c_type
typedef struct sequence307200_octet sequence307200_octet;
#endif
#endif /* _sequence307200_octet_c_type */

#ifndef _images_frame_c_type
# define _images_frame_c_type
struct images_frame {
  images_time stamp;
  char frame_id[32];
  uint32_t height;
  uint32_t width;
  char encoding[16];
  uint8_t is_bigendian;
  uint32_t step;
  sequence307200_octet data;
};
#ifndef _images_frame_forward_c_type
# define _images_frame_forward_c_type
typedef struct images_frame images_frame;
#endif
#endif /* _images_frame_c_type */

#ifndef _images_lens_c_type
# define _images_lens_c_type
struct images_lens {
  double focal;
  double cx;
  double cy;
  double k1;
  double k2;
};
#ifndef _images_lens_forward_c_type
# define _images_lens_forward_c_type
typedef struct images_lens images_lens;
#endif
#endif /* _images_lens_c_type */

#ifndef _images_rig_c_type
# define _images_rig_c_type
struct images_rig {
  uint32_t height;
  uint32_t width;
  images_lens left;
  images_lens right;
  double baseline;
};
#ifndef _images_rig_forward_c_type
# define _images_rig_forward_c_type
typedef struct images_rig images_rig;
#endif
#endif /* _images_rig_c_type */

#ifndef _camera_OUT_OF_RANGE_c_type
# define _camera_OUT_OF_RANGE_c_type
GENOM_EVENT(camera_OUT_OF_RANGE_id, "::camera::OUT_OF_RANGE");
typedef struct camera_OUT_OF_RANGE_detail {
  double value;
  double lower;
  double upper;
  char what[64];
} camera_OUT_OF_RANGE_detail;

static inline genom_event
camera_OUT_OF_RANGE(const camera_OUT_OF_RANGE_detail *detail, genom_context self)
{
  return self->raise(camera_OUT_OF_RANGE_id, detail, sizeof(*detail), self);
}
#endif /* _camera_OUT_OF_RANGE_c_type */

#ifndef _camera_NO_MEMORY_c_type
# define _camera_NO_MEMORY_c_type
GENOM_EVENT(camera_NO_MEMORY_id, "::camera::NO_MEMORY");
typedef void camera_NO_MEMORY_detail;

static inline genom_event
camera_NO_MEMORY(genom_context self)
{
  return self->raise(camera_NO_MEMORY_id, NULL, 0, self);
}
#endif /* _camera_NO_MEMORY_c_type */

#ifndef _camera_distortion_c_type
# define _camera_distortion_c_type
struct camera_distortion {
  double k1;
  double k2;
};
#ifndef _camera_distortion_forward_c_type
# define _camera_distortion_forward_c_type
typedef struct camera_distortion camera_distortion;
#endif
#endif /* _camera_distortion_c_type */

#ifndef _camera_scene_c_type
# define _camera_scene_c_type
typedef struct camera_scene camera_scene;
#endif /* _camera_scene_c_type */

#ifndef _camera_ids_c_type
# define _camera_ids_c_type
struct camera_ids {
  camera_scene *scene;
  double rate;
  uint32_t seed;
  camera_distortion left_lens;
  camera_distortion right_lens;
  double clock;
};
#ifndef _camera_ids_forward_c_type
# define _camera_ids_forward_c_type
typedef struct camera_ids camera_ids;
#endif
#endif /* _camera_ids_c_type */

#ifndef _images_BYTES_c_type
# define _images_BYTES_c_type
static const uint32_t images_BYTES = 307200U;
#endif /* _images_BYTES_c_type */

#ifndef _camera_ether_c_type
# define _camera_ether_c_type
GENOM_EVENT(camera_ether, "::camera::ether");
#endif /* _camera_ether_c_type */

#ifndef _camera_start_c_type
# define _camera_start_c_type
GENOM_EVENT(camera_start, "::camera::start");
#endif /* _camera_start_c_type */

#ifndef _camera_stop_c_type
# define _camera_stop_c_type
GENOM_EVENT(camera_stop, "::camera::stop");
#endif /* _camera_stop_c_type */

#ifndef _camera_aim_c_type
# define _camera_aim_c_type
GENOM_EVENT(camera_aim, "::camera::aim");
#endif /* _camera_aim_c_type */

#ifndef _camera_main_c_type
# define _camera_main_c_type
GENOM_EVENT(camera_main, "::camera::main");
#endif /* _camera_main_c_type */

#ifndef _camera_pause_main_c_type
# define _camera_pause_main_c_type
GENOM_EVENT(camera_pause_main, "::camera::pause::main");
#endif /* _camera_pause_main_c_type */

#ifndef _camera_genom_state_c_type
# define _camera_genom_state_c_type
typedef struct camera_genom_state {
  genom_state_component *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} camera_genom_state;
#endif /* _camera_genom_state_c_type */

#ifndef _camera_left_c_type
# define _camera_left_c_type
typedef struct camera_left {
  images_frame *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} camera_left;
#endif /* _camera_left_c_type */

#ifndef _camera_right_c_type
# define _camera_right_c_type
typedef struct camera_right {
  images_frame *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} camera_right;
#endif /* _camera_right_c_type */

#ifndef _camera_calibration_c_type
# define _camera_calibration_c_type
typedef struct camera_calibration {
  images_rig *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} camera_calibration;
#endif /* _camera_calibration_c_type */

/* Codels of camera. */
genom_event camera_init(camera_ids *ids, const genom_context self);
genom_event camera_close(camera_scene **scene, const genom_context self);
genom_event camera_check_rate(double rate, const genom_context self);
genom_event camera_check_distortion(const camera_distortion *left_lens, const camera_distortion *right_lens, const genom_context self);
genom_event camera_begin(double rate, uint32_t *taken, double *waited, const genom_context self);
genom_event camera_prepare(uint32_t seed, const camera_distortion *left_lens, const camera_distortion *right_lens, camera_scene **scene, const camera_calibration *calibration, const genom_context self);
genom_event camera_take(uint32_t images, double rate, const camera_scene *scene, double *clock, uint32_t *taken, double *waited, const camera_left *left, const camera_right *right, const genom_context self);
genom_event camera_rest(const genom_context self);

#ifdef __cplusplus
}
#endif

#endif /* H_CAMERA_C_TYPES */
