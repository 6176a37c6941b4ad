/*
 * Codels of hover. The thrust points where the position is to be corrected to, against gravity; the
 * attitude follows the thrust.
 */
#include <math.h>

#include "hover_c_types.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("hover.gen");

/* Period of task main, s. */
#define HOVER_PERIOD 0.001

/* m/s^2 */
#define GRAVITY 9.81

/* How far from the vertical the thrust may point: the tangent of that angle. */
#define LEAN 0.6

/* m/s: slower than that it has arrived. */
#define AT_REST 0.1

static double
dot(const double a[3], const double b[3])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void
cross(const double a[3], const double b[3], double to[3])
{
  to[0] = a[1] * b[2] - a[2] * b[1];
  to[1] = a[2] * b[0] - a[0] * b[2];
  to[2] = a[0] * b[1] - a[1] * b[0];
}

static void
unit(double a[3])
{
  const double length = sqrt(dot(a, a));
  int i;

  for (i = 0; i < 3; i++) a[i] /= length;
}

/* The axes of the robot in the frame of the world. */
static void
axes_of(const double q[4], double axis[3][3])
{
  const double w = q[0], x = q[1], y = q[2], z = q[3];

  axis[0][0] = 1. - 2. * (y * y + z * z);
  axis[0][1] = 2. * (x * y + w * z);
  axis[0][2] = 2. * (x * z - w * y);
  axis[1][0] = 2. * (x * y - w * z);
  axis[1][1] = 1. - 2. * (x * x + z * z);
  axis[1][2] = 2. * (y * z + w * x);
  axis[2][0] = 2. * (x * z + w * y);
  axis[2][1] = 2. * (y * z - w * x);
  axis[2][2] = 1. - 2. * (x * x + y * y);
}

static const robot_base *
look(const hover_base *base, genom_context self)
{
  return base->read(self) == genom_ok ? base->data(self) : NULL;
}

/* Permanent activity of task main, state start. Yields ether. */
genom_event
hover_init(hover_ids *ids, const genom_context self)
{
  (void)self;
  *ids = (hover_ids){
    .craft = { .mass = 1., .arm = 0.12, .drag = 0.02, .thrust = 6. },
    .gains = { .position = 4., .velocity = 3.2, .tilt = 1.8, .tilt_rate = 0.22, .yaw = 0.5,
               .yaw_rate = 0.15 },
    .speed = 1.,
  };
  return hover_ether;
}

/* Activity fly, state start. Yields main, and pause::start until it is known where it is. */
genom_event
hover_begin(const hover_base *base, hover_place *setpoint, double *elapsed,
            const genom_context self)
{
  const robot_base *now = look(base, self);

  if (!now) return hover_pause_start;
  *setpoint = (hover_place){ now->position[0], now->position[1], now->position[2] };
  *elapsed = 0.;
  return hover_main;
}

/* Moves the place where it is to be, at a speed, towards where it is wanted. Returns the velocity of
   that place. */
static void
approach(hover_place *setpoint, const hover_place *wanted, double speed, double velocity[3])
{
  double way[3] = { wanted->x - setpoint->x, wanted->y - setpoint->y, wanted->z - setpoint->z };
  const double left = sqrt(dot(way, way));
  int i;

  if (!(left > speed * HOVER_PERIOD)) {
    *setpoint = *wanted;
    for (i = 0; i < 3; i++) velocity[i] = 0.;
    return;
  }
  for (i = 0; i < 3; i++) velocity[i] = way[i] / left * speed;
  setpoint->x += velocity[0] * HOVER_PERIOD;
  setpoint->y += velocity[1] * HOVER_PERIOD;
  setpoint->z += velocity[2] * HOVER_PERIOD;
}

/* The force that is wanted, N, in the frame of the world: always upwards. */
static void
force_for(const hover_craft *craft, const hover_gains *gains, const hover_place *setpoint,
          const double velocity[3], const robot_base *now, double force[3])
{
  const double place[3] = { setpoint->x, setpoint->y, setpoint->z };
  double sideways;
  int i;

  for (i = 0; i < 3; i++)
    force[i] = craft->mass
               * (gains->position * (place[i] - now->position[i])
                  + gains->velocity * (velocity[i] - now->velocity[i]));
  force[2] = fmax(force[2] + craft->mass * GRAVITY, 0.2 * craft->mass * GRAVITY);
  sideways = hypot(force[0], force[1]) / (LEAN * force[2]);
  if (sideways > 1.)
    for (i = 0; i < 2; i++) force[i] /= sideways;
}

/* The torque that turns it so that its z axis has the direction of the force, and its x axis no part
   to the left, N m in the frame of the robot. */
static void
torque_for(const hover_gains *gains, const double force[3], double axis[3][3],
           const robot_base *now, double torque[3])
{
  const double ahead[3] = { 1., 0., 0. };
  double wanted[3][3], error[3] = { 0., 0., 0. }, turn[3];
  int i;

  for (i = 0; i < 3; i++) wanted[2][i] = force[i];
  unit(wanted[2]);
  cross(wanted[2], ahead, wanted[1]);
  unit(wanted[1]);
  cross(wanted[1], wanted[2], wanted[0]);
  /* Half of the sum over the axes, each crossed with where it is to be. */
  for (i = 0; i < 3; i++) {
    int k;

    cross(axis[i], wanted[i], turn);
    for (k = 0; k < 3; k++) error[k] += 0.5 * turn[k];
  }
  for (i = 0; i < 3; i++) {
    const double stiff = i == 2 ? gains->yaw : gains->tilt;
    const double damped = i == 2 ? gains->yaw_rate : gains->tilt_rate;

    torque[i] = stiff * dot(error, axis[i]) - damped * now->rate[i];
  }
}

/* The thrust of each rotor. */
static void
share(const hover_craft *craft, double thrust, const double torque[3], robot_efforts *efforts)
{
  static const int x[4] = { 1, 1, -1, -1 }, y[4] = { 1, -1, -1, 1 };
  int i;

  efforts->effort._length = 4;
  for (i = 0; i < 4; i++) {
    const double one = thrust / 4. + y[i] * torque[0] / (4. * craft->arm)
                       - x[i] * torque[1] / (4. * craft->arm)
                       + x[i] * y[i] * torque[2] / (4. * craft->drag);

    efforts->effort._buffer[i] = fmin(fmax(one, 0.), craft->thrust);
  }
}

/* Activity fly, state main. Yields pause::main, and stop when its time is over. */
genom_event
hover_step(double duration, const hover_craft *craft, const hover_gains *gains, double speed,
           const hover_place *wanted, bool sent, const hover_base *base, hover_place *setpoint,
           double *elapsed, const hover_command *command, const genom_context self)
{
  const robot_base *now = look(base, self);
  robot_efforts *efforts = command->data(self);
  double velocity[3] = { 0., 0., 0. }, force[3], torque[3], axis[3][3];
  genom_event e;

  if (now && efforts) {
    if (sent) approach(setpoint, wanted, speed, velocity);
    force_for(craft, gains, setpoint, velocity, now, force);
    axes_of(now->attitude, axis);
    torque_for(gains, force, axis, now, torque);
    share(craft, fmax(dot(force, axis[2]), 0.), torque, efforts);
    e = command->write(self);
    if (e != genom_ok) return e;
  }
  *elapsed += HOVER_PERIOD;
  return duration > 0. && *elapsed >= duration ? hover_stop : hover_pause_main;
}

/* Activity fly, state stop. Yields ether. */
genom_event
hover_release(const hover_command *command, const genom_context self)
{
  robot_efforts *efforts = command->data(self);
  genom_event e;
  uint32_t i;

  if (efforts) {
    efforts->effort._length = 4;
    for (i = 0; i < 4; i++) efforts->effort._buffer[i] = 0.;
  }
  e = command->write(self);
  return e == genom_ok ? hover_ether : e;
}

/* Activity go, state start. Yields main. Throws NO_PLACE. */
genom_event
hover_set(const hover_place *goal, double tolerance, hover_place *wanted, bool *sent,
          const genom_context self)
{
  if (!isfinite(goal->x) || !isfinite(goal->y) || !isfinite(goal->z) || !(tolerance > 0.))
    return hover_NO_PLACE(self);
  *wanted = *goal;
  *sent = true;
  return hover_main;
}

/* Activity go, state main. Yields ether when it is there, at rest. Throws NO_POSITION. */
genom_event
hover_arrive(const hover_place *goal, double tolerance, const hover_base *base,
             const genom_context self)
{
  const robot_base *now = look(base, self);
  double way[3];

  if (!now) return hover_NO_POSITION(self);
  way[0] = goal->x - now->position[0];
  way[1] = goal->y - now->position[1];
  way[2] = goal->z - now->position[2];
  return dot(way, way) < tolerance * tolerance
             && dot(now->velocity, now->velocity) < AT_REST * AT_REST
           ? hover_ether
           : hover_pause_main;
}

/* Activity go, state stop. Yields ether. */
genom_event
hover_rest(const genom_context self)
{
  (void)self;
  return hover_ether;
}
