/*
 * Codels of task main of demo: they move the axis, one period at a time.
 */
#include <math.h>

#include "demo_c_types.h"
#include "demo_limits.h"

/* Publishes the state of the axis; the exception of the port, if any, is the caller's to return. */
static genom_event
publish(const demo_state *current, const demo_position *position, genom_context self)
{
  demo_state *sample = position->data(self);

  if (sample) *sample = *current;
  return position->write(self);
}

/* The gain on inport parameter: 1 if it was never written, never negative. */
static double
gain(const demo_parameter *parameter, genom_context self)
{
  const demo_gain *sample;

  if (parameter->read(self) != genom_ok) return 1.;
  sample = parameter->data(self);
  if (!sample) return 1.;
  return *sample > 0. ? *sample : 0.;
}

/* Permanent activity of task main, state start. Yields ether. */
genom_event
demo_init(demo_ids *ids, const demo_position *position, const genom_context self)
{
  genom_event e;

  ids->velocity = DEMO_SPEED;
  ids->current.position = 0.;
  ids->current.velocity = 0.;
  ids->halted = false;

  e = publish(&ids->current, position, self);
  return e == genom_ok ? demo_ether : e;
}

/* Activity goto, state start. Yields main. */
genom_event
demo_begin(bool *halted, const genom_context self)
{
  (void)self;
  *halted = false;
  return demo_main;
}

/*
 * Activity goto, state main. Yields pause::main until the goal is reached, then ether.
 * Throws HALTED.
 *
 * The speed grows with the acceleration of the axis, and is such that the axis can still stop
 * at the goal with it. The last step ends exactly there.
 */
genom_event
demo_servo(double goal, double velocity, bool halted, demo_state *current,
           const demo_parameter *parameter, const demo_position *position,
           const genom_context self)
{
  const double distance = goal - current->position;
  const double sign = distance < 0. ? -1. : 1.;
  double speed;
  bool arrived;
  genom_event e;

  if (halted) return demo_HALTED(self);

  speed = fmax(sign * current->velocity, 0.) + DEMO_ACCELERATION * DEMO_PERIOD;
  speed = fmin(speed, fmin(velocity * gain(parameter, self), DEMO_SPEED_MAX));
  speed = fmin(speed, sqrt(2. * DEMO_ACCELERATION * fabs(distance)));

  arrived = fabs(distance) <= speed * DEMO_PERIOD;
  if (arrived) {
    current->position = goal;
    current->velocity = 0.;
  } else {
    current->position += sign * speed * DEMO_PERIOD;
    current->velocity = sign * speed;
  }

  e = publish(current, position, self);
  if (e != genom_ok) return e;
  return arrived ? demo_ether : demo_pause_main;
}

/* Activity goto, state stop. Yields pause::stop while the axis slows down, then ether. */
genom_event
demo_brake(demo_state *current, const demo_position *position, const genom_context self)
{
  const double sign = current->velocity < 0. ? -1. : 1.;
  const double speed = fmax(fabs(current->velocity) - DEMO_ACCELERATION * DEMO_PERIOD, 0.);
  genom_event e;

  current->position += sign * speed * DEMO_PERIOD;
  current->velocity = speed > 0. ? sign * speed : 0.;

  e = publish(current, position, self);
  if (e != genom_ok) return e;
  return speed > 0. ? demo_pause_stop : demo_ether;
}

/*
 * Activity goto, external event emergency. Yields ether.
 *
 * The place of state main stays active beside this one: it sees `halted` and ends with HALTED.
 */
genom_event
demo_halt(demo_state *current, bool *halted, const demo_position *position,
          const genom_context self)
{
  genom_event e;

  current->velocity = 0.;
  *halted = true;

  e = publish(current, position, self);
  return e == genom_ok ? demo_ether : e;
}
