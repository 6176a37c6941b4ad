/*
 * Codels of sim: a model of MuJoCo, advanced by one period at each tick.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "sim_c_types.h"
#include "sim_world.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("sim.gen");

/* How far a number of steps may be from an integer. */
#define SIM_EXACT 1e-9

/* MuJoCo would write them to a file in the working directory. */
static void
quiet(const char *warning)
{
  (void)warning;
}

static void
forget(sim_world *world)
{
  const uint64_t model_number = world->model_number;

  mj_deleteData(world->data);
  mj_deleteModel(world->model);
  memset(world, 0, sizeof(*world));
  world->model_number = model_number;
}

static genom_event
no_model(const char *file, const char *why, genom_context self)
{
  sim_NO_MODEL_detail detail;

  snprintf(detail.why, sizeof(detail.why), "%s: %s", file, why);
  return sim_NO_MODEL(&detail, self);
}

/* Permanent activity of task main, state start. Yields ether. */
genom_event
sim_init(sim_world **world, const genom_context self)
{
  (void)self;
  mju_user_warning = quiet;
  *world = calloc(1, sizeof(**world));
  return sim_ether;
}

/* Permanent activity of task main, state stop. Yields ether. */
genom_event
sim_free(sim_world **world, const genom_context self)
{
  (void)self;
  if (*world) forget(*world);
  free(*world);
  *world = NULL;
  return sim_ether;
}

/* Activity simulate, state start. Yields main. Throws NO_MODEL. */
genom_event
sim_load(const char model[256], sim_world **world, const genom_context self)
{
  char why[400] = "";
  sim_world *made = *world;
  double steps;
  int joint;

  if (!made) return no_model(model, "no memory", self);
  forget(made);
  made->model = mj_loadXML(model, NULL, why, sizeof(why));
  if (!made->model) return no_model(model, why, self);

  steps = SIM_PERIOD / made->model->opt.timestep;
  made->steps = (uint64_t)lround(steps);
  if (made->steps < 1 || fabs(steps - (double)made->steps) > SIM_EXACT * steps) {
    snprintf(why, sizeof(why), "its time step of %g s does not divide a period of %g s",
             made->model->opt.timestep, SIM_PERIOD);
    forget(made);
    return no_model(model, why, self);
  }
  made->base = -1;
  for (joint = 0; joint < made->model->njnt; joint++) {
    const int type = made->model->jnt_type[joint];

    if (type == mjJNT_FREE && made->base < 0) made->base = joint;
    if (type != mjJNT_HINGE && type != mjJNT_SLIDE) continue;
    if (made->joints == 16) {
      forget(made);
      return no_model(model, "it has more than 16 joints", self);
    }
    made->joint[made->joints++] = joint;
  }
  if (made->model->nu > 16 || made->model->nsensordata > 64) {
    forget(made);
    return no_model(model, "it has more than 16 actuators, or 64 values of sensors", self);
  }
  made->data = mj_makeData(made->model);
  if (!made->data) {
    forget(made);
    return no_model(model, "no memory", self);
  }
  made->model_number++;
  mj_forward(made->model, made->data);
  return sim_main;
}

static void
listen(const sim_world *world, const sim_command *command, genom_context self)
{
  const robot_efforts *efforts;
  int i;

  if (command->read(self) != genom_ok) return;
  efforts = command->data(self);
  if (!efforts) return;
  for (i = 0; i < world->model->nu && i < (int)efforts->effort._length; i++) {
    const double effort = efforts->effort._buffer[i];

    if (isfinite(effort)) world->data->ctrl[i] = effort;
  }
}

/* Publishes where the robot is, if it moves freely. */
static genom_event
tell_base(const sim_world *world, const sim_base *base, uint64_t date, genom_context self)
{
  robot_base *now = base->data(self);

  if (world->base < 0) return genom_ok;
  if (now) {
    const mjtNum *pose = world->data->qpos + world->model->jnt_qposadr[world->base];
    const mjtNum *speed = world->data->qvel + world->model->jnt_dofadr[world->base];

    now->date = date;
    mju_copy(now->position, pose, 3);
    mju_copy(now->attitude, pose + 3, 4);
    mju_copy(now->velocity, speed, 3);
    mju_copy(now->rate, speed + 3, 3);
  }
  return base->write(self);
}

static genom_event
tell(const sim_world *world, const sim_joints *joints, const sim_base *base,
     const sim_sensors *sensors, genom_context self)
{
  const mjModel *model = world->model;
  const mjData *data = world->data;
  const uint64_t date = world->periods * (uint64_t)(SIM_PERIOD * 1e9);
  robot_joints *now = joints->data(self);
  robot_measured *seen = sensors->data(self);
  genom_event e;
  int i;

  if (now) {
    now->date = date;
    now->position._length = now->velocity._length = now->effort._length = world->joints;
    for (i = 0; i < world->joints; i++) {
      const int joint = world->joint[i];

      now->position._buffer[i] = data->qpos[model->jnt_qposadr[joint]];
      now->velocity._buffer[i] = data->qvel[model->jnt_dofadr[joint]];
      now->effort._buffer[i] = data->qfrc_actuator[model->jnt_dofadr[joint]];
    }
  }
  if (seen) {
    seen->date = date;
    seen->value._length = (uint32_t)model->nsensordata;
    for (i = 0; i < (int)model->nsensordata; i++) seen->value._buffer[i] = data->sensordata[i];
  }
  e = joints->write(self);
  if (e != genom_ok) return e;
  e = tell_base(world, base, date, self);
  if (e != genom_ok) return e;
  return sensors->write(self);
}

/* Activity simulate, state main. Yields pause::main, and ether when its time is over. */
genom_event
sim_step(double duration, sim_world **world, const sim_command *command,
         const sim_joints *joints, const sim_base *base, const sim_sensors *sensors,
         const genom_context self)
{
  sim_world *here = *world;
  genom_event e;
  uint64_t step;

  listen(here, command, self);
  for (step = 0; step < here->steps; step++) mj_step(here->model, here->data);
  here->periods++;
  e = tell(here, joints, base, sensors, self);
  if (e != genom_ok) return e;
  return duration > 0. && here->periods * SIM_PERIOD >= duration ? sim_ether : sim_pause_main;
}

/* Activity simulate, state stop. Yields ether. */
genom_event
sim_rest(const genom_context self)
{
  (void)self;
  return sim_ether;
}
