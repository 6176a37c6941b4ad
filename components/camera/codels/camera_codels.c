/*
 * Codels of the control task of camera: they validate requests.
 */
#include "camera_c_types.h"
#include "camera_rig.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("camera.gen");

/* Throws OUT_OF_RANGE unless the value, which may be NaN, is within the limits. */
static genom_event
within(double value, double lower, double upper, const char *what, genom_context self)
{
  camera_OUT_OF_RANGE_detail detail = { .value = value, .lower = lower, .upper = upper };

  if (value >= lower && value <= upper) return genom_ok;
  strncpy(detail.what, what, sizeof(detail.what) - 1);
  return camera_OUT_OF_RANGE(&detail, self);
}

/* Validation codel of attribute set_rate. Throws OUT_OF_RANGE. */
genom_event
camera_check_rate(double rate, const genom_context self)
{
  return within(rate, CAMERA_RATE_MIN, CAMERA_RATE_MAX, "rate, images per second", self);
}

static genom_event
check(const camera_distortion *lens, genom_context self)
{
  genom_event e = within(lens->k1, CAMERA_K1_MIN, CAMERA_K1_MAX, "k1", self);

  if (e != genom_ok) return e;
  return within(lens->k2, CAMERA_K2_MIN, CAMERA_K2_MAX, "k2", self);
}

/* Validation codel of attribute set_distortion. Throws OUT_OF_RANGE. */
genom_event
camera_check_distortion(const camera_distortion *left_lens, const camera_distortion *right_lens,
                        const genom_context self)
{
  genom_event e = check(left_lens, self);

  return e != genom_ok ? e : check(right_lens, self);
}
