/*
 * The two lenses: numbers of the camera that do not change.
 */
#ifndef CAMERA_RIG_H
#define CAMERA_RIG_H

#define CAMERA_WIDTH 640  /* px */
#define CAMERA_HEIGHT 480 /* px */
#define CAMERA_PIXELS (CAMERA_WIDTH * CAMERA_HEIGHT)

#define CAMERA_FOCAL 500. /* px */
#define CAMERA_CX 319.5   /* px: the middle of the image */
#define CAMERA_CY 239.5   /* px */
#define CAMERA_BASELINE 0.12 /* m */

#define CAMERA_PERIOD 0.01 /* s, of task main */

/* Limits of requests. */
#define CAMERA_RATE_MIN 0.1
#define CAMERA_RATE_MAX 50.
/* Within these, each pixel of the image is seen along one direction only. */
#define CAMERA_K1_MIN -0.2
#define CAMERA_K1_MAX 0.2
#define CAMERA_K2_MIN 0.
#define CAMERA_K2_MAX 0.1

#endif /* CAMERA_RIG_H */
