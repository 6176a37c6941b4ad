/*
 * The scene that the camera looks at, drawn by following the ray of each pixel.
 */
#include <math.h>
#include <string.h>

#include "camera_scene.h"

#define WALL 3.0        /* m: distance; its disparity is 500 px * 0.12 m / 3 m = 20 px */
#define FLOOR 0.6       /* m: below the lenses */
#define BOARD 1.5       /* m: distance; its disparity is 40 px */
#define BOARD_SIDE 0.25 /* m: half of a side */
#define SWING 0.35      /* m: to either side */
#define SWING_TIME 8.0  /* s: to and fro */

/* The three textures differ. */
enum { WALL_TEXTURE, FLOOR_TEXTURE, BOARD_TEXTURE };

/* Mixes the bits of its arguments; the constants are those of the finaliser of MurmurHash3. */
static uint32_t
mix(uint32_t x, uint32_t y, uint32_t seed)
{
  uint32_t h = x * 0x9e3779b1u ^ (y + seed * 0x27d4eb2fu) * 0x85ebca6bu;

  h ^= h >> 16;
  h *= 0x85ebca6bu;
  h ^= h >> 13;
  h *= 0xc2b2ae35u;
  return h ^ h >> 16;
}

/* Value noise: random values from 0 to 1 on a grid of distance 1, and smooth between them. */
static double
noise(double x, double y, uint32_t seed)
{
  const double left = floor(x), top = floor(y);
  const uint32_t i = (uint32_t)(int32_t)left, j = (uint32_t)(int32_t)top;
  const double u = x - left, v = y - top;
  const double s = u * u * (3. - 2. * u), t = v * v * (3. - 2. * v);
  const double upper = mix(i, j, seed) * (1. - s) + mix(i + 1, j, seed) * s;
  const double lower = mix(i, j + 1, seed) * (1. - s) + mix(i + 1, j + 1, seed) * s;

  return (upper * (1. - t) + lower * t) / UINT32_MAX;
}

/* Noise that is fine enough to be compared and coarse enough to be seen, from -0.5 to 0.5; fine and
   coarse are the distances of the grids, m. */
static double
grain(double x, double y, double fine, double coarse, uint32_t seed)
{
  return 0.65 * noise(x / fine, y / fine, seed) + 0.35 * noise(x / coarse, y / coarse, ~seed) - 0.5;
}

/* Where a length is within its tile of 0.3 m: from 0 to 1. */
static double
within(double length)
{
  return length / 0.3 - floor(length / 0.3);
}

static uint8_t
grey(double value)
{
  return (uint8_t)lround(255. * fmin(fmax(value, 0.), 1.));
}

/* The wall has lines, which the lenses bend. */
static uint8_t
wall(double x, double y, uint32_t seed)
{
  const bool line = within(x) < 0.12 || within(y) < 0.12;

  return grey((line ? 0.3 : 0.6) + 0.55 * grain(x, y, 0.02, 0.15, 3 * seed + WALL_TEXTURE));
}

/* The floor is tiled. */
static uint8_t
tiles(double x, double z, uint32_t seed)
{
  const bool dark = (within(x / 2.) < 0.5) == (within(z / 2.) < 0.5);

  return grey((dark ? 0.3 : 0.5) + 0.5 * grain(x, z, 0.02, 0.15, 3 * seed + FLOOR_TEXTURE));
}

/* The board has a dark frame. */
static uint8_t
board(double x, double y, uint32_t seed)
{
  const bool frame = fmax(fabs(x), fabs(y)) > 0.9 * BOARD_SIDE;

  return grey((frame ? 0.2 : 0.75) + 0.4 * grain(x, y, 0.01, 0.07, 3 * seed + BOARD_TEXTURE));
}

/* The wall, or the floor before it, along a ray. */
static uint8_t
background(double x, double ray_x, double ray_y, uint32_t seed)
{
  if (ray_y * WALL > FLOOR) {
    const double z = FLOOR / ray_y;

    return tiles(x + ray_x * z, z, seed);
  }
  return wall(x + ray_x * WALL, ray_y * WALL, seed);
}

/*
 * The distance from the centre without distortion, for one with it: solves
 * r (1 + k1 r^2 + k2 r^4) = distorted by Newton's method. Within the limits of camera_rig.h, ten
 * steps are more than a double has digits.
 */
static double
undistorted(double distorted, const camera_distortion *lens)
{
  double r = distorted;
  int step;

  for (step = 0; step < 10; step++) {
    const double s = r * r;

    r -= (r * (1. + s * (lens->k1 + s * lens->k2)) - distorted)
         / (1. + s * (3. * lens->k1 + s * 5. * lens->k2));
  }
  return r;
}

static void
prepare_eye(struct camera_eye *eye, uint32_t seed, const camera_distortion *lens)
{
  int row, column, pixel = 0;

  for (row = 0; row < CAMERA_HEIGHT; row++)
    for (column = 0; column < CAMERA_WIDTH; column++, pixel++) {
      const double x = (column - CAMERA_CX) / CAMERA_FOCAL;
      const double y = (row - CAMERA_CY) / CAMERA_FOCAL;
      const double distance = sqrt(x * x + y * y);
      /* No pixel is at the centre: that is between four of them. */
      const double scale = undistorted(distance, lens) / distance;

      eye->ray_x[pixel] = (float)(x * scale);
      eye->ray_y[pixel] = (float)(y * scale);
      eye->still[pixel] = background(eye->x, x * scale, y * scale, seed);
    }
}

void
camera_scene_prepare(struct camera_scene *scene, uint32_t seed, const camera_distortion lens[2])
{
  if (scene->ready && scene->seed == seed && !memcmp(scene->lens, lens, sizeof(scene->lens)))
    return;
  scene->seed = seed;
  memcpy(scene->lens, lens, sizeof(scene->lens));
  scene->eye[0].x = 0.;
  scene->eye[1].x = CAMERA_BASELINE;
  prepare_eye(&scene->eye[0], seed, &lens[0]);
  prepare_eye(&scene->eye[1], seed, &lens[1]);
  scene->ready = true;
}

void
camera_scene_draw(const struct camera_scene *scene, const struct camera_eye *eye, double date,
                  uint8_t *pixels)
{
  const double centre = SWING * sin(2. * M_PI * date / SWING_TIME);
  int pixel;

  memcpy(pixels, eye->still, CAMERA_PIXELS);
  for (pixel = 0; pixel < CAMERA_PIXELS; pixel++) {
    const double x = eye->x + eye->ray_x[pixel] * BOARD - centre;
    const double y = eye->ray_y[pixel] * BOARD;

    if (fabs(x) < BOARD_SIDE && fabs(y) < BOARD_SIDE)
      pixels[pixel] = board(x, y, scene->seed);
  }
}
