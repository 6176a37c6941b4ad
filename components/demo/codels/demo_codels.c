/*
 * Codels of the control task of demo: they validate requests.
 */
#include "demo_c_types.h"
#include "demo_limits.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("demo.gen");

/* True for NaN as well. */
static bool
outside(double value, double lower, double upper)
{
  return !(value >= lower && value <= upper);
}

/* Validation codel of attribute set_speed. Throws OUT_OF_RANGE. */
genom_event
demo_check_velocity(double velocity, const genom_context self)
{
  demo_OUT_OF_RANGE_detail detail = { velocity, 0., DEMO_SPEED_MAX, "velocity, m/s" };

  if (outside(velocity, 0., DEMO_SPEED_MAX)) return demo_OUT_OF_RANGE(&detail, self);
  return genom_ok;
}

/* Validation codel of activity goto. Throws OUT_OF_RANGE. */
genom_event
demo_check_goal(double goal, const genom_context self)
{
  demo_OUT_OF_RANGE_detail detail = { goal, DEMO_GOAL_MIN, DEMO_GOAL_MAX, "goal, m" };

  if (outside(goal, DEMO_GOAL_MIN, DEMO_GOAL_MAX)) return demo_OUT_OF_RANGE(&detail, self);
  return genom_ok;
}

/* Codel of function reset. Throws MOVING. */
genom_event
demo_reset(demo_state *current, const genom_context self)
{
  if (current->velocity != 0.) return demo_MOVING(self);
  current->position = 0.;
  return genom_ok;
}
