/*
 * Codels of task main of camera: they take the images.
 */
#include <math.h>
#include <stdlib.h>

#include "camera_c_types.h"
#include "camera_rig.h"
#include "camera_scene.h"

/* Permanent activity of task main, state start. Yields ether. */
genom_event
camera_init(camera_ids *ids, const genom_context self)
{
  (void)self;
  *ids = (camera_ids){
    .rate = 10.,
    .seed = 1,
    .left_lens = { .k1 = -0.2, .k2 = 0.02 },
    .right_lens = { .k1 = -0.16, .k2 = 0.01 },
  };
  return camera_ether;
}

/* Permanent activity of task main, state stop. Yields ether. */
genom_event
camera_close(camera_scene **scene, const genom_context self)
{
  (void)self;
  free(*scene);
  *scene = NULL;
  return camera_ether;
}

static images_lens
lens(const camera_distortion *distortion)
{
  return (images_lens){
    .focal = CAMERA_FOCAL,
    .cx = CAMERA_CX,
    .cy = CAMERA_CY,
    .k1 = distortion->k1,
    .k2 = distortion->k2,
  };
}

/* Activity capture, state start. Yields aim. */
genom_event
camera_begin(double rate, uint32_t *taken, double *waited, const genom_context self)
{
  (void)self;
  /* The first image is due at once. */
  *waited = 1. / rate;
  *taken = 0;
  return camera_aim;
}

/* Activity capture, state aim. Yields main. Throws NO_MEMORY. */
genom_event
camera_prepare(uint32_t seed, const camera_distortion *left_lens,
               const camera_distortion *right_lens, camera_scene **scene,
               const camera_calibration *calibration, const genom_context self)
{
  const camera_distortion lenses[2] = { *left_lens, *right_lens };
  images_rig *rig = calibration->data(self);
  genom_event e;

  if (!*scene) *scene = calloc(1, sizeof(**scene));
  if (!*scene) return camera_NO_MEMORY(self);
  camera_scene_prepare(*scene, seed, lenses);

  if (rig)
    *rig = (images_rig){
      .height = CAMERA_HEIGHT,
      .width = CAMERA_WIDTH,
      .left = lens(left_lens),
      .right = lens(right_lens),
      .baseline = CAMERA_BASELINE,
    };
  e = calibration->write(self);
  return e == genom_ok ? camera_main : e;
}

static void
expose(const camera_scene *scene, const struct camera_eye *eye, const char *name, double date,
       images_frame *image)
{
  const long long nanoseconds = llround(date * 1e9);

  image->stamp.sec = (int32_t)(nanoseconds / 1000000000);
  image->stamp.nanosec = (uint32_t)(nanoseconds % 1000000000);
  strncpy(image->frame_id, name, sizeof(image->frame_id) - 1);
  strncpy(image->encoding, "mono8", sizeof(image->encoding) - 1);
  image->height = CAMERA_HEIGHT;
  image->width = CAMERA_WIDTH;
  image->is_bigendian = 0;
  image->step = CAMERA_WIDTH;
  image->data._length = CAMERA_PIXELS;
  camera_scene_draw(scene, eye, date, image->data._buffer);
}

/*
 * Activity capture, state main. Yields pause::main until all images are taken, then ether; and aim
 * if the scene is not there: it is known to codels only, and not in a file of `genomctl freeze`.
 *
 * Dates of images are multiples of 1 / rate, whenever this codel runs: the same images have the
 * same dates in each run.
 */
genom_event
camera_take(uint32_t images, double rate, const camera_scene *scene, double *clock,
            uint32_t *taken, double *waited, const camera_left *left, const camera_right *right,
            const genom_context self)
{
  images_frame *image;
  genom_event e;

  if (!scene) return camera_aim;
  /* Half a period: sums of periods are not exact. */
  if (*waited + CAMERA_PERIOD / 2. < 1. / rate) {
    *waited += CAMERA_PERIOD;
    return camera_pause_main;
  }
  *waited += CAMERA_PERIOD - 1. / rate;

  image = left->data(self);
  if (image) expose(scene, &scene->eye[0], "left", *clock, image);
  e = left->write(self);
  if (e != genom_ok) return e;

  image = right->data(self);
  if (image) expose(scene, &scene->eye[1], "right", *clock, image);
  e = right->write(self);
  if (e != genom_ok) return e;

  *clock += 1. / rate;
  *taken += 1;
  return *taken == images ? camera_ether : camera_pause_main;
}

/* Activity capture, state stop. Yields ether. */
genom_event
camera_rest(const genom_context self)
{
  (void)self;
  return camera_ether;
}
