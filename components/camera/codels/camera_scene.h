/*
 * The scene that the camera looks at: a wall, a floor, and a board that swings before the wall.
 *
 * Coordinates are in metres from the left lens: x to the right, y down, z in the direction of view.
 */
#ifndef CAMERA_SCENE_H
#define CAMERA_SCENE_H

#include <stdbool.h>
#include <stdint.h>

#include "camera_c_types.h"
#include "camera_rig.h"

/* What one lens sees. */
struct camera_eye {
  double x;                        /* m: where the lens is */
  float ray_x[CAMERA_PIXELS];      /* the direction in which each pixel looks: x / z and y / z, */
  float ray_y[CAMERA_PIXELS];      /*   row by row */
  uint8_t still[CAMERA_PIXELS];    /* the image without the board */
};

struct camera_scene {
  bool ready;                      /* what follows was computed */
  uint32_t seed;
  camera_distortion lens[2];
  struct camera_eye eye[2];        /* left, right */
};

/* Computes what does not move: for textures from this seed, seen through these lenses. */
void camera_scene_prepare(struct camera_scene *scene, uint32_t seed,
                          const camera_distortion lens[2]);

/* Draws what an eye sees at this date, s: CAMERA_PIXELS bytes. */
void camera_scene_draw(const struct camera_scene *scene, const struct camera_eye *eye, double date,
                       uint8_t *pixels);

#endif /* CAMERA_SCENE_H */
