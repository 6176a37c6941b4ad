/*
 * Limits of the axis.
 */
#ifndef DEMO_LIMITS_H
#define DEMO_LIMITS_H

#define DEMO_PERIOD 0.005      /* s, the period of task main */
#define DEMO_ACCELERATION 2.0  /* m/s^2, to speed up and to slow down */
#define DEMO_SPEED 0.5         /* m/s, until set_speed */
#define DEMO_SPEED_MAX 2.0     /* m/s */
#define DEMO_GOAL_MIN (-10.0)  /* m */
#define DEMO_GOAL_MAX 10.0     /* m */

#endif /* DEMO_LIMITS_H */
