/*
 * The types, events, exceptions, ports and codels of demo.gen, in C.
 */
#ifndef DEMO_C_TYPES_H
#define DEMO_C_TYPES_H

#include <stdbool.h>

#include "genom3/c/context.h"
#include "genom3/c/event.h"
#include "genom3/c/exception.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Types */

typedef struct demo_state {
  double position; /* m */
  double velocity; /* m/s */
} demo_state;

typedef double demo_gain;

typedef struct demo_ids {
  double velocity; /* greatest speed, m/s */
  demo_state current;
  bool halted;
} demo_ids;

/* Ports */

typedef struct demo_parameter {
  demo_gain *(*data)(genom_context self);
  genom_event (*read)(genom_context self);
} demo_parameter;

typedef struct demo_position {
  demo_state *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} demo_position;

/* Codels */

genom_event demo_init(demo_ids *ids, const demo_position *position, const genom_context self);
genom_event demo_check_velocity(double velocity, const genom_context self);
genom_event demo_check_goal(double goal, const genom_context self);
genom_event demo_reset(demo_state *current, const genom_context self);
genom_event demo_begin(bool *halted, const genom_context self);
genom_event demo_servo(double goal, double velocity, bool halted, demo_state *current,
                       const demo_parameter *parameter, const demo_position *position,
                       const genom_context self);
genom_event demo_brake(demo_state *current, const demo_position *position,
                      const genom_context self);
genom_event demo_halt(demo_state *current, bool *halted, const demo_position *position,
                      const genom_context self);

#ifdef __cplusplus
}
#endif

/* Events */

GENOM_EVENT(demo_main, "::demo::main");
GENOM_EVENT(demo_ether, "::demo::ether");
GENOM_EVENT(demo_pause_main, "::demo::pause::main");
GENOM_EVENT(demo_pause_stop, "::demo::pause::stop");

/* Exceptions */

GENOM_EVENT(demo_OUT_OF_RANGE_id, "::demo::OUT_OF_RANGE");

typedef struct demo_OUT_OF_RANGE_detail {
  double value, lower, upper;
  char what[64];
} demo_OUT_OF_RANGE_detail;

static inline genom_event
demo_OUT_OF_RANGE(const demo_OUT_OF_RANGE_detail *detail, genom_context self)
{
  return self->raise(demo_OUT_OF_RANGE_id, detail, sizeof(*detail), self);
}

GENOM_EVENT(demo_MOVING_id, "::demo::MOVING");

static inline genom_event
demo_MOVING(genom_context self)
{
  return self->raise(demo_MOVING_id, NULL, 0, self);
}

GENOM_EVENT(demo_HALTED_id, "::demo::HALTED");

static inline genom_event
demo_HALTED(genom_context self)
{
  return self->raise(demo_HALTED_id, NULL, 0, self);
}

#endif /* DEMO_C_TYPES_H */
