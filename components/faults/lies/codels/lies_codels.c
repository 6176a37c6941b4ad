/*
 * Codels of lies: all but the first differ from the description.
 */
#include "genom3/c/exception.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("lies.gen");

typedef struct lies_pose {
  double x, y;
  float heading;
} lies_pose;

/* As an older version of the header may have had it. */
typedef struct old_pose {
  float x, y;
  float heading;
} old_pose;

genom_event lies_honest(double x, lies_pose *pose, const genom_context self);
genom_event lies_layout(const old_pose *pose, const genom_context self);
genom_event lies_scalar(int32_t x, const genom_context self);
genom_event lies_address(const double *x, const genom_context self);
genom_event lies_count(double x, const genom_context self);

genom_event
lies_honest(double x, lies_pose *pose, const genom_context self)
{
  (void)self;
  pose->x = x;
  pose->y = 0.;
  pose->heading = 0.f;
  return genom_ok;
}

genom_event
lies_layout(const old_pose *pose, const genom_context self)
{
  (void)self;
  return pose->heading > 0.f ? genom_fatal : genom_ok;
}

genom_event
lies_scalar(int32_t x, const genom_context self)
{
  (void)self;
  return x > 0 ? genom_fatal : genom_ok;
}

genom_event
lies_address(const double *x, const genom_context self)
{
  (void)self;
  return *x > 0. ? genom_fatal : genom_ok;
}

genom_event
lies_count(double x, const genom_context self)
{
  (void)self;
  return x > 0. ? genom_fatal : genom_ok;
}
