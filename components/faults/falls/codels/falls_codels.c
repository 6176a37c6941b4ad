/*
 * Codels of falls.
 */
#include <stddef.h>
#include <stdint.h>

#include "genom3/c/exception.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("falls.gen");

GENOM_EVENT(falls_tick_state, "::falls::tick");
GENOM_EVENT(falls_pause_tick, "::falls::pause::tick");
GENOM_EVENT(falls_ether, "::falls::ether");

typedef struct falls_ticks {
  int32_t *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} falls_ticks;

genom_event falls_begin(int32_t *done, const genom_context self);
genom_event falls_stop(const genom_context self);
genom_event falls_tick(int32_t at, int32_t *done, const falls_ticks *ticks,
                       const genom_context self);

genom_event
falls_begin(int32_t *done, const genom_context self)
{
  (void)self;
  *done = 0;
  return falls_tick_state;
}

genom_event
falls_tick(int32_t at, int32_t *done, const falls_ticks *ticks, const genom_context self)
{
  /* Hidden from the compiler, which would warn. */
  volatile int *volatile nowhere = NULL;
  genom_event e;

  *done += 1;
  *ticks->data(self) = *done;
  e = ticks->write(self);
  if (*done == at) *nowhere = 1;
  if (e != genom_ok) return e;
  return *done < 100000 ? falls_pause_tick : falls_ether;
}

genom_event
falls_stop(const genom_context self)
{
  (void)self;
  return falls_ether;
}
