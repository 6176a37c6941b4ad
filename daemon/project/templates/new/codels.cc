#include <cmath>

#include "%NAME%_cxx_types.h"

namespace {
const double PERIOD = 0.01; // seconds, as in the description
const double GREATEST = 2.0; // metres per second
}

// Validates the inputs of attribute set_speed.
genom::event
%NAME%_check_speed(double speed)
{
  if (!(speed > 0.0 && speed <= GREATEST)) throw %NAME%::e_out_of_range({ GREATEST });
  return genom::ok;
}

// Task motion begins.
genom::event
%NAME%_begin(%NAME%::ids &ids)
{
  ids.position = 0.0;
  ids.speed = 0.5;
  return %NAME%::shown;
}

// Each period: what others read.
genom::event
%NAME%_show(double position, %NAME%::current &current)
{
  current.data().position = position;
  current.write();
  return %NAME%::pause::shown;
}

// Each period while moving.
genom::event
%NAME%_step(double goal, double speed, double &position)
{
  const double left = goal - position;
  const double step = speed * PERIOD;
  if (std::fabs(left) <= step) {
    position = goal;
    return %NAME%::ether;
  }
  position += std::copysign(step, left);
  return %NAME%::pause::start;
}

// Interrupted: it stays where it is.
genom::event
%NAME%_halt()
{
  return %NAME%::ether;
}
