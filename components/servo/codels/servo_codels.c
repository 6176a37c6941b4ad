/*
 * Codels of servo.
 */
#include "servo_c_types.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("servo.gen");

/* Period of task main, s. */
#define SERVO_PERIOD 0.001

/* Permanent activity of task main, state start. Yields ether. */
genom_event
servo_init(servo_ids *ids, const genom_context self)
{
  (void)self;
  ids->gains.stiffness = 80.;
  ids->gains.damping = 8.;
  return servo_ether;
}

/* The number of a joint, 0 if it is left out. */
static double
of(const double *numbers, uint32_t length, uint32_t joint)
{
  return joint < length ? numbers[joint] : 0.;
}

/* Activity hold, state start. Yields main. */
genom_event
servo_begin(double *elapsed, const genom_context self)
{
  (void)self;
  *elapsed = 0.;
  return servo_main;
}

/* Activity hold, state main. Yields pause::main, and stop when its time is over. */
genom_event
servo_step(double duration, const servo_gains *gains, const servo_joints *joints,
           const servo_target *target, double *elapsed, const servo_command *command,
           const genom_context self)
{
  const robot_joints *now = joints->read(self) == genom_ok ? joints->data(self) : NULL;
  const robot_target *goal = target->read(self) == genom_ok ? target->data(self) : NULL;
  robot_efforts *efforts = command->data(self);
  genom_event e;
  uint32_t i;

  if (now && efforts) {
    efforts->effort._length = now->position._length;
    for (i = 0; i < now->position._length; i++) {
      const double position = goal ? of(goal->position._buffer, goal->position._length, i) : 0.;
      const double velocity = goal ? of(goal->velocity._buffer, goal->velocity._length, i) : 0.;

      efforts->effort._buffer[i] =
        gains->stiffness * (position - now->position._buffer[i])
        + gains->damping
        * (velocity - of(now->velocity._buffer, now->velocity._length, i));
    }
    e = command->write(self);
    if (e != genom_ok) return e;
  }
  *elapsed += SERVO_PERIOD;
  return duration > 0. && *elapsed >= duration ? servo_stop : servo_pause_main;
}

/* Activity hold, state stop. Yields ether. */
genom_event
servo_release(const servo_command *command, const genom_context self)
{
  robot_efforts *efforts = command->data(self);
  genom_event e;
  uint32_t i;

  if (efforts) {
    for (i = 0; i < efforts->effort._length; i++) efforts->effort._buffer[i] = 0.;
  }
  e = command->write(self);
  return e == genom_ok ? servo_ether : e;
}
