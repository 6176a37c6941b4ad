/*
 * Codels of the figure of 2011: an axis moves at constant speed, and ends at the goal.
 */
#include <math.h>

#include "demo_c_types.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("demo.gen");

#define PERIOD 0.005 /* s, the period of task main */
#define SPEED 1.0    /* m/s, until told otherwise */
#define SPEED_MIN 0.01
#define SPEED_MAX 2.0 /* speed_max of demo-types.idl */

/* Validation codel of setspeed: brings the new speed within what the axis can do. */
genom_event
demo_chk_velocity(double *velocity, const genom_context self)
{
  (void)self;
  *velocity = fmin(fmax(*velocity, SPEED_MIN), SPEED_MAX); /* NaN becomes SPEED_MIN */
  return genom_ok;
}

/* Service goto, state start. Yields main. */
genom_event
demo_init_velocity(double *velocity, const genom_context self)
{
  (void)self;
  if (*velocity <= 0.) *velocity = SPEED; /* setspeed was never called */
  return demo_main;
}

/* Service goto, state main. Yields main until the goal is reached, then stop. */
genom_event
demo_servo(double goal, double *velocity, const demo_position *position_port,
           const genom_context self)
{
  double *current = position_port->data(self);
  double distance, step;
  genom_event e;

  if (!current || !isfinite(goal)) return demo_SERVO_ERROR(self);

  distance = goal - *current;
  step = *velocity * PERIOD;
  *current = fabs(distance) <= step ? goal : *current + copysign(step, distance);

  e = position_port->write(self);
  if (e != genom_ok) return demo_SERVO_ERROR(self);
  return *current == goal ? demo_stop_event : demo_main;
}

/* Service goto, states stop and emergency. Yields ether. */
genom_event
demo_stop(const genom_context self)
{
  (void)self;
  return demo_ether;
}
