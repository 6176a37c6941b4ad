/*
 * Codels of the control task of demo: they validate requests.
 */
#include "demo_limits.h"
#include "demo_types.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("demo-cpp.gen");

/* True for NaN as well. */
static bool
outside(double value, double lower, double upper)
{
  return !(value >= lower && value <= upper);
}

/* Validation codel of attribute set_speed. Throws OUT_OF_RANGE. */
genom::event
demo_check_velocity(double velocity)
{
  if (outside(velocity, 0., DEMO_SPEED_MAX))
    throw demo::OUT_OF_RANGE({ velocity, 0., DEMO_SPEED_MAX, "velocity, m/s" });
  return genom::ok;
}

/* Validation codel of activity goto. Throws OUT_OF_RANGE. */
genom::event
demo_check_goal(double goal)
{
  if (outside(goal, DEMO_GOAL_MIN, DEMO_GOAL_MAX))
    throw demo::OUT_OF_RANGE({ goal, DEMO_GOAL_MIN, DEMO_GOAL_MAX, "goal, m" });
  return genom::ok;
}

/* Validation codel of activity follow. Throws BAD_ROUTE. */
genom::event
demo_check_route(const std::vector<double> &route)
{
  if (route.empty()) throw demo::BAD_ROUTE({ "a route has at least one point", route });
  for (double goal : route) {
    if (outside(goal, DEMO_GOAL_MIN, DEMO_GOAL_MAX))
      throw demo::BAD_ROUTE({ "the axis cannot reach " + std::to_string(goal) + " m", route });
  }
  return genom::ok;
}

/* Codel of function reset. Throws MOVING. */
genom::event
demo_reset(demo::state &current)
{
  if (current.velocity != 0.) throw demo::MOVING();
  current.position = 0.;
  return genom::ok;
}
