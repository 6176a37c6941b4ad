/*
 * The events, the exception, the port and the codels of the figure of 2010, in C.
 */
#ifndef DEMO_2010_C_TYPES_H
#define DEMO_2010_C_TYPES_H

#include "genom3/c/context.h"
#include "genom3/c/event.h"
#include "genom3/c/exception.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct demo_position {
  double *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} demo_position;

genom_event demo_init_velocity(double *velocity, const genom_context self);
genom_event demo_servo(double position, double *velocity, const demo_position *position_port,
                       const genom_context self);
genom_event demo_stop(const genom_context self);

#ifdef __cplusplus
}
#endif

/* In C, the codel demo_stop has the name that event stop would have: the event takes another. */
GENOM_EVENT(demo_main, "::demo::main");
GENOM_EVENT(demo_stop_event, "::demo::stop");
GENOM_EVENT(demo_ether, "::demo::ether");

GENOM_EVENT(demo_SERVO_ERROR_id, "::demo::SERVO_ERROR");

static inline genom_event
demo_SERVO_ERROR(genom_context self)
{
  return self->raise(demo_SERVO_ERROR_id, NULL, 0, self);
}

#endif /* DEMO_2010_C_TYPES_H */
