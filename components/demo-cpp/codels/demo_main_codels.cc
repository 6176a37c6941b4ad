/*
 * Codels of task main of demo: the axis moves here, one period at a time. What ports throw, a
 * lost connection say, ends the activity.
 */
#include <algorithm>
#include <cmath>
#include <sstream>

#include "demo_limits.h"
#include "demo_types.h"

/* Publishes the state of the axis. */
static void
publish(const demo::state &current, demo::position &position)
{
  position.data() = current;
  position.write();
}

/* The gain on inport parameter: 1 if it was never written, never negative. */
static double
gain(demo::parameter &parameter)
{
  try {
    parameter.read();
    const demo::gain gain = parameter.data();
    return gain > 0. ? gain : 0.;
  } catch (const genom::exception &) {
    return 1.;
  }
}

/*
 * Moves the axis for one period; true when it reached the goal.
 *
 * The speed grows with the acceleration of the axis, and is such that the axis can still stop
 * at the goal with it. The last step ends exactly there.
 */
static bool
step(double goal, double velocity, demo::state &current, demo::parameter &parameter)
{
  const double distance = goal - current.position;
  const double sign = distance < 0. ? -1. : 1.;

  double speed = std::fmax(sign * current.velocity, 0.) + DEMO_ACCELERATION * DEMO_PERIOD;
  speed = std::fmin(speed, std::fmin(velocity * gain(parameter), DEMO_SPEED_MAX));
  speed = std::fmin(speed, std::sqrt(2. * DEMO_ACCELERATION * std::fabs(distance)));

  if (std::fabs(distance) <= speed * DEMO_PERIOD) {
    current.position = goal;
    current.velocity = 0.;
    return true;
  }
  current.position += sign * speed * DEMO_PERIOD;
  current.velocity = sign * speed;
  return false;
}

/* Permanent activity of task main, state start. Yields ether. */
genom::event
demo_init(demo::ids &ids, demo::position &position)
{
  ids.velocity = DEMO_SPEED;
  ids.current = demo::state();
  ids.name = "axis";
  ids.halted = false;
  publish(ids.current, position);
  return demo::ether;
}

/* Activity goto, state start. Yields main. */
genom::event
demo_begin(bool &halted)
{
  halted = false;
  return demo::main;
}

/* Activity goto, state main. Yields pause::main until the goal is reached, then ether. */
genom::event
demo_servo(double goal, double velocity, bool halted, demo::state &current,
           demo::parameter &parameter, demo::position &position)
{
  if (halted) throw demo::HALTED();
  const bool arrived = step(goal, velocity, current, parameter);
  publish(current, position);
  return arrived ? demo::ether : demo::pause::main;
}

/* Any activity, state stop. Yields pause::stop while the axis slows down, then ether. */
genom::event
demo_brake(demo::state &current, demo::position &position)
{
  const double sign = current.velocity < 0. ? -1. : 1.;
  const double speed = std::fmax(std::fabs(current.velocity) - DEMO_ACCELERATION * DEMO_PERIOD, 0.);

  current.position += sign * speed * DEMO_PERIOD;
  current.velocity = speed > 0. ? sign * speed : 0.;
  publish(current, position);
  return speed > 0. ? demo::pause::stop : demo::ether;
}

/*
 * Any activity, external event emergency. Yields ether.
 *
 * The place of state main stays active beside this one: it sees `halted` and ends with HALTED.
 */
genom::event
demo_halt(demo::state &current, bool &halted, demo::position &position)
{
  current.velocity = 0.;
  halted = true;
  publish(current, position);
  return demo::ether;
}

/* Activity follow, state start. Yields main. */
genom::event
demo_depart(const std::string &name, uint32_t &next, demo::trace &trace, bool &halted)
{
  next = 0;
  trace.axis = name;
  trace.states.clear();
  halted = false;
  return demo::main;
}

/* Activity follow, state main. Yields pause::main until the last point, then arrived. */
genom::event
demo_travel(const std::vector<double> &route, double velocity, bool halted, uint32_t &next,
            demo::state &current, demo::trace &trace, demo::parameter &parameter,
            demo::position &position, demo::passed &passed)
{
  if (halted) throw demo::HALTED();
  trace.next = route.at(next);
  const bool arrived = step(route.at(next), velocity, current, parameter);
  publish(current, position);
  if (!arrived) return demo::pause::main;

  next++;
  trace.states.push_back(current);
  if (next < route.size())
    trace.next = route[next];
  else
    trace.next.reset();
  passed.data() = trace;
  passed.write();
  return next < route.size() ? demo::pause::main : demo::arrived;
}

/* Activity follow, state arrived: beside the task, for text takes its time. Yields ether. */
genom::event
demo_report(const demo::trace &trace, std::vector<demo::state> &stops, std::string &report)
{
  std::ostringstream text;
  stops = trace.states;
  text << trace.axis << " stopped " << stops.size() << " times";
  for (const demo::state &state : stops) text << ", at " << state.position << " m";
  report = text.str();
  return demo::ether;
}
