/*
 * What the tasks of sim share.
 */
#ifndef SIM_WORLD_H
#define SIM_WORLD_H

#include <stdint.h>

#include <mujoco/mujoco.h>

/* Period of task main, s. */
#define SIM_PERIOD 0.001

struct sim_world {
  mjModel *model;     /* NULL: nothing is simulated yet */
  mjData *data;
  uint64_t model_number;  /* of the model: another one, another number */
  uint64_t steps;     /* in one period */
  uint64_t periods;   /* that are over */
  int joints;         /* with one degree of freedom */
  int joint[16];      /* their indices */
  int base;           /* index of the first free joint, -1 if there is none */
};

#endif
