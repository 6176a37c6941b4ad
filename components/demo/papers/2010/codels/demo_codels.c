/*
 * Codels of the figure of 2010: an axis moves at constant speed, and ends at the goal.
 */
#include <math.h>

#include "demo_c_types.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("demo.gen");

#define PERIOD 0.005 /* s, the period of task main */
#define SPEED 1.0    /* m/s, until told otherwise */

/* Service goto, state start. Yields main. */
genom_event
demo_init_velocity(double *velocity, const genom_context self)
{
  (void)self;
  *velocity = SPEED;
  return demo_main;
}

/* Service goto, state main. Yields main until the goal is reached, then stop. */
genom_event
demo_servo(double position, double *velocity, const demo_position *position_port,
           const genom_context self)
{
  double *current = position_port->data(self);
  double distance, step;
  genom_event e;

  if (!current || !isfinite(position)) return demo_SERVO_ERROR(self);

  distance = position - *current;
  step = *velocity * PERIOD;
  *current = fabs(distance) <= step ? position : *current + copysign(step, distance);

  e = position_port->write(self);
  if (e != genom_ok) return demo_SERVO_ERROR(self);
  return *current == position ? demo_stop_event : demo_main;
}

/* Service goto, states stop and emergency. Yields ether. */
genom_event
demo_stop(const genom_context self)
{
  (void)self;
  return demo_ether;
}
