/*
 * Codels of overwrites.
 */
#include <stdint.h>

#include "genom3/c/exception.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("overwrites.gen");

GENOM_EVENT(overwrites_ether, "::overwrites::ether");
GENOM_EVENT(overwrites_rest_state, "::overwrites::rest");

typedef struct overwrites_sample {
  double values[4];
} overwrites_sample;

typedef struct overwrites_samples {
  overwrites_sample *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} overwrites_samples;

typedef struct sequence4_int32_t {
  uint32_t _maximum, _length;
  int32_t _buffer[4];
} sequence4_int32_t;

genom_event overwrites_past_ids(double gains[4], const genom_context self);
genom_event overwrites_past_ids_and_on(double gains[4], const genom_context self);
genom_event overwrites_rest(const genom_context self);
genom_event overwrites_before_ids(uint32_t *count, const genom_context self);
genom_event overwrites_past_output(sequence4_int32_t *found, const genom_context self);
genom_event overwrites_past_port(const overwrites_samples *samples, const genom_context self);
genom_event overwrites_past_argument(const double values[4], const genom_context self);
genom_event overwrites_within(double gains[4], const overwrites_samples *samples,
                              const genom_context self);

/* Hidden from the compiler, which would warn. */
static void
scribble(void *at, long from, long to)
{
  volatile unsigned char *bytes = at;
  long i;

  for (i = from; i < to; i++) bytes[i] = 0x5a;
}

genom_event
overwrites_past_ids(double gains[4], const genom_context self)
{
  (void)self;
  scribble(gains, 4 * sizeof(*gains), 4 * sizeof(*gains) + 16);
  return overwrites_ether;
}

genom_event
overwrites_past_ids_and_on(double gains[4], const genom_context self)
{
  overwrites_past_ids(gains, self);
  return overwrites_rest_state;
}

genom_event
overwrites_rest(const genom_context self)
{
  (void)self;
  return overwrites_ether;
}

genom_event
overwrites_before_ids(uint32_t *count, const genom_context self)
{
  (void)self;
  scribble(count, -16, 0);
  return overwrites_ether;
}

genom_event
overwrites_past_output(sequence4_int32_t *found, const genom_context self)
{
  (void)self;
  scribble(found, sizeof(*found), sizeof(*found) + 16);
  return overwrites_ether;
}

genom_event
overwrites_past_port(const overwrites_samples *samples, const genom_context self)
{
  overwrites_sample *sample = samples->data(self);

  scribble(sample, sizeof(*sample), sizeof(*sample) + 16);
  return overwrites_ether;
}

genom_event
overwrites_past_argument(const double values[4], const genom_context self)
{
  (void)self;
  scribble((void *)(uintptr_t)values, 4 * sizeof(*values), 4 * sizeof(*values) + 16);
  return genom_ok;
}

genom_event
overwrites_within(double gains[4], const overwrites_samples *samples, const genom_context self)
{
  overwrites_sample *sample = samples->data(self);
  int i;

  for (i = 0; i < 4; i++) gains[i] = sample->values[i] = i;
  samples->write(self);
  return overwrites_ether;
}
