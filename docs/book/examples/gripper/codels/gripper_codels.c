#include <math.h>

#include "gripper_c_types.h"

static const double PERIOD = 0.01;     /* s, as in the description */
static const double WIDEST = 0.12;     /* m */
static const double FASTEST = 0.5;     /* m/s */

/* ANCHOR: begin */
static void
show(const gripper_fingers *now, const gripper_state *state, genom_context self)
{
  *state->data(self) = *now;
  state->write(self);
}

/* Task motion begins: the gripper is open. */
genom_event
gripper_begin(gripper_ids *ids, const gripper_state *state, const genom_context self)
{
  ids->now.width = WIDEST;
  ids->now.holds = false;
  ids->speed = 0.1;
  show(&ids->now, state, self);
  return gripper_ether;
}
/* ANCHOR_END: begin */

/* ANCHOR: check */
/* Attribute set_speed: refuses what the motors cannot do, and what is no number. */
genom_event
gripper_check_speed(double speed, const genom_context self)
{
  gripper_OUT_OF_RANGE_detail detail = { FASTEST };

  if (!(speed > 0. && speed <= FASTEST)) return gripper_OUT_OF_RANGE(&detail, self);
  return genom_ok;
}
/* ANCHOR_END: check */

/* Activity move: refuses what the fingers cannot reach. */
genom_event
gripper_check_width(double width, const genom_context self)
{
  gripper_OUT_OF_RANGE_detail detail = { WIDEST };

  if (!(width >= 0. && width <= WIDEST)) return gripper_OUT_OF_RANGE(&detail, self);
  return genom_ok;
}

/* ANCHOR: step */
/* One period towards a width; true when it is reached. */
static bool
approach(double width, double speed, gripper_fingers *now)
{
  const double left = width - now->width;

  if (fabs(left) <= speed * PERIOD) {
    now->width = width;
    return true;
  }
  now->width += copysign(speed * PERIOD, left);
  return false;
}

/* Activity move, each period until the width is reached. */
genom_event
gripper_step(double width, double speed, gripper_fingers *now, const gripper_state *state,
             const genom_context self)
{
  const bool there = approach(width, speed, now);

  now->holds = false;
  show(now, state, self);
  return there ? gripper_ether : gripper_pause_start;
}
/* ANCHOR_END: step */

/* ANCHOR: close */
/* Activity grasp, each period until the fingers touch the thing, or each other. */
genom_event
gripper_close(double speed, const gripper_thing *thing, gripper_fingers *now,
              const gripper_state *state, const genom_context self)
{
  double width = 0.;

  if (thing->read(self) == genom_ok && thing->data(self)) width = *thing->data(self);
  if (!approach(fmax(width, 0.), speed, now)) {
    show(now, state, self);
    return gripper_pause_start;
  }
  now->holds = now->width > 0.;
  show(now, state, self);
  return now->holds ? gripper_held : gripper_NOTHING_HELD(self);
}
/* ANCHOR_END: close */

/* Activity grasp, when something is held. */
genom_event
gripper_report(const gripper_fingers *now, double *width, const genom_context self)
{
  (void)self;
  *width = now->width;
  return gripper_ether;
}

/* ANCHOR: halt */
/* Any motion that is asked to stop: the fingers stay where they are. */
genom_event
gripper_halt(const genom_context self)
{
  (void)self;
  return gripper_ether;
}
/* ANCHOR_END: halt */
