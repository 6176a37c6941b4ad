/*
 * Codels of mission.
 */
#include <math.h>

#include "mission_c_types.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("mission.gen");

/* Lowest speed factor: at 0 the axis would never reach its goal. */
#define MISSION_SLOWEST 0.25

static genom_event
publish(double value, const mission_gain *gain, genom_context self)
{
  double *sample = gain->data(self);

  if (sample) *sample = value;
  return gain->write(self);
}

/* Permanent activity of task watch, state start. Yields main. */
genom_event
mission_init(mission_ids *ids, const mission_gain *gain, const genom_context self)
{
  genom_event e;

  ids->turns.near = 0.;
  ids->turns.far = 0.5;
  ids->margin = 0.1;
  e = publish(1., gain, self);
  return e == genom_ok ? mission_main : e;
}

/* Permanent activity of task watch, state main. Yields pause::main. */
genom_event
mission_watch(const mission_ends *turns, double margin, const mission_position *position,
              const mission_gain *gain, const genom_context self)
{
  const mission_state *axis = NULL;
  double distance, value = 1.;
  genom_event e;

  if (position->read(self) == genom_ok) axis = position->data(self);
  if (axis && margin > 0.) {
    distance = fmin(fabs(axis->position - turns->near), fabs(axis->position - turns->far));
    value = fmax(fmin(distance / margin, 1.), MISSION_SLOWEST);
  }
  e = publish(value, gain, self);
  return e == genom_ok ? mission_pause_main : e;
}

/* Activity patrol, state start. Yields main. */
genom_event
mission_begin(uint32_t *legs, const genom_context self)
{
  (void)self;
  *legs = 0;
  return mission_main;
}

/* Activity patrol, state main: chooses the next goal. Yields leg, and ether after the last one. */
genom_event
mission_turn(uint32_t rounds, const mission_ends *turns, uint32_t *legs, double *goal,
             const genom_context self)
{
  (void)self;
  if (*legs / 2 >= rounds) return mission_ether;
  *goal = *legs % 2 == 0 ? turns->far : turns->near;
  ++*legs;
  return mission_leg;
}

/*
 * Activity patrol, state leg. Yields main.
 * Throws what the axis does, and what stands for an axis that is not there.
 *
 * The call lasts as long as the leg: the codel is async, so that it holds up nobody.
 */
genom_event
mission_send(double goal, const mission_goto *axis, const genom_context self)
{
  const genom_event e = axis->call(goal, self);

  return e == genom_ok ? mission_main : e;
}

/* Activity patrol, state stop. Yields ether. */
genom_event
mission_end(const genom_context self)
{
  (void)self;
  return mission_ether;
}
