#include <math.h>

#include "%NAME%_c_types.h"

static const double PERIOD = 0.01; /* seconds, as in the description */
static const double GREATEST = 2.0; /* metres per second */

/* Validates the inputs of attribute set_speed. */
genom_event
%NAME%_check_speed(double speed, const genom_context self)
{
  if (!(speed > 0.0 && speed <= GREATEST)) {
    %NAME%_e_out_of_range_detail detail = { GREATEST };
    return %NAME%_e_out_of_range(&detail, self);
  }
  return genom_ok;
}

/* Task motion begins. */
genom_event
%NAME%_begin(%NAME%_ids *ids, const genom_context self)
{
  (void)self;
  ids->position = 0.0;
  ids->speed = 0.5;
  return %NAME%_shown;
}

/* Each period: what others read. */
genom_event
%NAME%_show(double position, const %NAME%_current *current, const genom_context self)
{
  current->data(self)->position = position;
  current->write(self);
  return %NAME%_pause_shown;
}

/* Each period while moving. */
genom_event
%NAME%_step(double goal, double speed, double *position, const genom_context self)
{
  (void)self;
  double left = goal - *position;
  double step = speed * PERIOD;
  if (fabs(left) <= step) {
    *position = goal;
    return %NAME%_ether;
  }
  *position += copysign(step, left);
  return %NAME%_pause_start;
}

/* Interrupted: it stays where it is. */
genom_event
%NAME%_halt(const genom_context self)
{
  (void)self;
  return %NAME%_ether;
}
