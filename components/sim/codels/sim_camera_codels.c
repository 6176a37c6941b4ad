/*
 * Codels of the cameras of sim: a ray for each pixel, so that no graphics hardware is needed, and
 * images are equal to the bit in each run.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "sim_c_types.h"
#include "sim_world.h"

/* Period of task eyes, ms. */
#define EYES_PERIOD 10

/* How far a camera sees, m. */
#define FURTHEST 100.

/* Part of the light that comes from everywhere. */
#define AMBIENT 0.35

/* What is seen where nothing is. */
static const double SKY[3] = { 0.55, 0.68, 0.82 };

/* A copy of the model as it was: it is drawn while the robot moves on. */
struct sim_eye {
  mjModel *model;
  mjData *data;
  uint64_t model_number;
  uint64_t date;      /* ns, of the copy */
  size_t pixels;      /* for which there is memory below */
  mjtNum *rays;       /* 3 for each pixel */
  mjtNum *normals;    /* 3 for each pixel */
  mjtNum *distances;
  int *geoms;
};

static genom_event
no_camera(const char *name, const char *why, genom_context self)
{
  sim_NO_CAMERA_detail detail;

  snprintf(detail.why, sizeof(detail.why), "%s: %s", name, why);
  return sim_NO_CAMERA(&detail, self);
}

static void
blind(sim_eye *eye)
{
  mj_deleteData(eye->data);
  mj_deleteModel(eye->model);
  eye->data = NULL;
  eye->model = NULL;
}

/* Permanent activity of task eyes, state start. Yields ether. */
genom_event
sim_eyes_init(sim_eye **eye, const genom_context self)
{
  (void)self;
  *eye = calloc(1, sizeof(**eye));
  return sim_ether;
}

/* Permanent activity of task eyes, state stop. Yields ether. */
genom_event
sim_eyes_free(sim_eye **eye, const genom_context self)
{
  (void)self;
  if (*eye) {
    blind(*eye);
    free((*eye)->rays);
    free((*eye)->normals);
    free((*eye)->distances);
    free((*eye)->geoms);
  }
  free(*eye);
  *eye = NULL;
  return sim_ether;
}

/* Memory for images of so many pixels: false if there is none. */
static bool
room(sim_eye *eye, size_t pixels)
{
  if (pixels <= eye->pixels) return true;
  free(eye->rays);
  free(eye->normals);
  free(eye->distances);
  free(eye->geoms);
  eye->rays = malloc(3 * pixels * sizeof(*eye->rays));
  eye->normals = malloc(3 * pixels * sizeof(*eye->normals));
  eye->distances = malloc(pixels * sizeof(*eye->distances));
  eye->geoms = malloc(pixels * sizeof(*eye->geoms));
  eye->pixels = eye->rays && eye->normals && eye->distances && eye->geoms ? pixels : 0;
  return eye->pixels > 0;
}

/* Activity watch, state start. Yields look. Throws NO_CAMERA. */
genom_event
sim_camera_open(const char camera[32], uint32_t width, uint32_t height, uint32_t every,
                sim_eye **eye, uint64_t *due, uint32_t *taken, const sim_image *image,
                const sim_depth *depth, const genom_context self)
{
  const uint64_t pixels = (uint64_t)width * height;
  genom_event e;

  if (!*camera) return no_camera("\"\"", "a camera needs a name in the model", self);
  if (width > images_BYTES || pixels == 0 || pixels > images_BYTES / 3)
    return no_camera(camera, "an image has from 1 to 102400 pixels", self);
  if (every == 0 || every % EYES_PERIOD != 0)
    return no_camera(camera, "images are taken every 10 ms, 20 ms, ...", self);
  if (!*eye || !room(*eye, (size_t)pixels)) return no_camera(camera, "no memory", self);
  *due = 0;
  *taken = 0;
  e = image->open(camera, self);
  if (e != genom_ok) return e;
  e = depth->open(camera, self);
  return e == genom_ok ? sim_look : e;
}

/* Activity watch, state look. Yields draw when an image is due, otherwise pause::look. */
genom_event
sim_camera_look(const sim_world *world, uint32_t every, uint64_t *due, sim_eye **eye,
                const genom_context self)
{
  const uint64_t period = (uint64_t)lround(every / (1e3 * SIM_PERIOD));
  sim_eye *here = *eye;

  (void)self;
  if (!here || !world || !world->model) return sim_pause_look;
  /* Dates of images are those of the simulation, which may have begun again. */
  if (*due > world->periods + period) *due = 0;
  if (world->periods < *due) return sim_pause_look;
  *due = (world->periods / period + 1) * period;

  if (!here->model || here->model_number != world->model_number) {
    blind(here);
    here->model = mj_copyModel(NULL, world->model);
    if (here->model) here->data = mj_makeData(here->model);
    if (!here->data) {
      blind(here);
      return sim_pause_look;
    }
    here->model_number = world->model_number;
  }
  mju_copy(here->data->qpos, world->data->qpos, (int)world->model->nq);
  mju_copy(here->data->mocap_pos, world->data->mocap_pos, 3 * (int)world->model->nmocap);
  mju_copy(here->data->mocap_quat, world->data->mocap_quat, 4 * (int)world->model->nmocap);
  here->date = world->periods * (uint64_t)(SIM_PERIOD * 1e9);
  return sim_draw;
}

/* Rays through the middle of each pixel, in the frame of the world: a camera looks along its -z,
   with y upwards. As long as one unit of depth. */
static void
aim(sim_eye *eye, int camera, uint32_t width, uint32_t height)
{
  const mjtNum *axes = eye->data->cam_xmat + 9 * camera;
  const double scale = tan(eye->model->cam_fovy[camera] * mjPI / 360.) * 2. / height;
  mjtNum *ray = eye->rays;
  uint32_t row, column;
  int i;

  for (row = 0; row < height; row++)
    for (column = 0; column < width; column++, ray += 3) {
      const double x = (column + 0.5 - 0.5 * width) * scale;
      const double y = (0.5 * height - row - 0.5) * scale;

      for (i = 0; i < 3; i++) ray[i] = axes[3 * i] * x + axes[3 * i + 1] * y - axes[3 * i + 2];
    }
}

/* How bright a surface is: most where it faces the first light of the model, or the camera if it
   has none. */
static double
brightness(const sim_eye *eye, int camera, const mjtNum *point, const mjtNum *normal)
{
  const mjtNum *lamp =
    eye->model->nlight ? eye->data->light_xpos : eye->data->cam_xpos + 3 * camera;
  mjtNum towards[3];

  mju_sub3(towards, lamp, point);
  mju_normalize3(towards);
  return AMBIENT + (1. - AMBIENT) * fmax(0., mju_dot3(towards, normal));
}

static uint8_t
byte(double part)
{
  return (uint8_t)lround(255. * fmin(fmax(part, 0.), 1.));
}

static void
paint(const sim_eye *eye, int camera, size_t pixel, uint8_t *rgb)
{
  const mjModel *model = eye->model;
  const int geom = eye->geoms[pixel];
  const float *colour;
  mjtNum point[3];
  double bright;
  int i;

  if (geom < 0 || eye->distances[pixel] < 0.) {
    for (i = 0; i < 3; i++) rgb[i] = byte(SKY[i]);
    return;
  }
  colour = model->geom_matid[geom] >= 0 ? model->mat_rgba + 4 * model->geom_matid[geom]
                                        : model->geom_rgba + 4 * geom;
  mju_addScl3(point, eye->data->cam_xpos + 3 * camera, eye->rays + 3 * pixel,
              eye->distances[pixel]);
  bright = brightness(eye, camera, point, eye->normals + 3 * pixel);
  for (i = 0; i < 3; i++) rgb[i] = byte(colour[i] * bright);
}

/* In mm, little-endian: 0 if nothing is there. Rays are as long as one unit of depth. */
static void
measure(const sim_eye *eye, size_t pixel, uint8_t *to)
{
  const double away = eye->geoms[pixel] < 0 ? 0. : eye->distances[pixel] * 1e3;
  const uint16_t depth = away > 0. && away < 65535.5 ? (uint16_t)lround(away) : 0;

  to[0] = (uint8_t)depth;
  to[1] = (uint8_t)(depth >> 8);
}

static void
label(const sim_eye *eye, const char *name, uint32_t width, uint32_t height, const char *encoding,
      uint32_t bytes, images_frame *frame)
{
  frame->stamp.sec = (int32_t)(eye->date / 1000000000);
  frame->stamp.nanosec = (uint32_t)(eye->date % 1000000000);
  snprintf(frame->frame_id, sizeof(frame->frame_id), "%s", name);
  snprintf(frame->encoding, sizeof(frame->encoding), "%s", encoding);
  frame->height = height;
  frame->width = width;
  frame->is_bigendian = 0;
  frame->step = width * bytes;
  frame->data._length = width * height * bytes;
}

/* Activity watch, state draw. Yields pause::look until all images are taken, then ether; and look if
   there is no copy of the model: it is not in a file of `genomctl freeze`. Throws NO_CAMERA. */
genom_event
sim_camera_draw(const char camera[32], uint32_t width, uint32_t height, uint32_t images,
                sim_eye **eye, uint32_t *taken, const sim_image *image, const sim_depth *depth,
                const genom_context self)
{
  /* What the viewer of MuJoCo shows. */
  static const mjtByte groups[mjNGROUP] = { 1, 1, 1, 0, 0, 0 };
  sim_eye *here = *eye;
  images_frame *colours = image->data(camera, self), *depths = depth->data(camera, self);
  const size_t pixels = (size_t)width * height;
  genom_event e;
  size_t pixel;
  int at;

  if (!here || !here->model) return sim_look;
  if (!room(here, pixels)) return no_camera(camera, "no memory", self);
  at = mj_name2id(here->model, mjOBJ_CAMERA, camera);
  if (at < 0) return no_camera(camera, "the model has no such camera", self);
  if (here->model->cam_projection[at] != mjPROJ_PERSPECTIVE)
    return no_camera(camera, "only cameras with perspective are drawn", self);

  mj_kinematics(here->model, here->data);
  mj_comPos(here->model, here->data);
  mj_camlight(here->model, here->data);
  mj_flex(here->model, here->data);
  aim(here, at, width, height);
  mj_multiRay(here->model, here->data, here->data->cam_xpos + 3 * at, here->rays, groups, 1,
              here->model->cam_bodyid[at] ? here->model->cam_bodyid[at] : -1, here->geoms,
              here->distances, here->normals, (int)pixels, FURTHEST);
  if (colours) {
    label(here, camera, width, height, "rgb8", 3, colours);
    for (pixel = 0; pixel < pixels; pixel++)
      paint(here, at, pixel, colours->data._buffer + 3 * pixel);
  }
  if (depths) {
    label(here, camera, width, height, "16UC1", 2, depths);
    for (pixel = 0; pixel < pixels; pixel++)
      measure(here, pixel, depths->data._buffer + 2 * pixel);
  }
  e = image->write(camera, self);
  if (e != genom_ok) return e;
  e = depth->write(camera, self);
  if (e != genom_ok) return e;
  *taken += 1;
  return images > 0 && *taken >= images ? sim_ether : sim_pause_look;
}

/* Activity watch, state stop. Yields ether. */
genom_event
sim_camera_rest(const genom_context self)
{
  (void)self;
  return sim_ether;
}
