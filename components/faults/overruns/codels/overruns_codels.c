/*
 * Codels of overruns.
 */
#include <time.h>

#include "genom3/c/exception.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("overruns.gen");

GENOM_EVENT(overruns_ether, "::overruns::ether");
GENOM_EVENT(overruns_busy, "::overruns::busy");
GENOM_EVENT(overruns_pause_busy, "::overruns::pause::busy");
GENOM_EVENT(overruns_pause_start, "::overruns::pause::start");

typedef struct overruns_report {
  uint32_t calls;
  double again[8];
} overruns_report;

typedef struct overruns_progress {
  overruns_report *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} overruns_progress;

genom_event overruns_steady(uint32_t *steady, const genom_context self);
genom_event overruns_steady_stop(const genom_context self);
genom_event overruns_begin(uint32_t *done, const genom_context self);
genom_event overruns_work(uint32_t calls, double duration, uint32_t *done,
                          const overruns_progress *progress, const genom_context self);
genom_event overruns_end(const genom_context self);

genom_event
overruns_steady(uint32_t *steady, const genom_context self)
{
  (void)self;
  ++*steady;
  return overruns_pause_start;
}

genom_event
overruns_steady_stop(const genom_context self)
{
  (void)self;
  return overruns_ether;
}

genom_event
overruns_begin(uint32_t *done, const genom_context self)
{
  (void)self;
  *done = 0;
  return overruns_busy;
}

genom_event
overruns_work(uint32_t calls, double duration, uint32_t *done,
              const overruns_progress *progress, const genom_context self)
{
  struct timespec left;
  overruns_report *report;
  genom_event e;
  unsigned i;

  left.tv_sec = (time_t)duration;
  left.tv_nsec = (long)((duration - (double)left.tv_sec) * 1e9);
  while (nanosleep(&left, &left)) continue;

  report = progress->data(self);
  report->calls = ++*done;
  for (i = 0; i < sizeof(report->again) / sizeof(*report->again); i++) {
    report->again[i] = *done;
  }
  e = progress->write(self);
  if (e != genom_ok) return e;

  return *done < calls ? overruns_pause_busy : overruns_ether;
}

genom_event
overruns_end(const genom_context self)
{
  (void)self;
  return overruns_ether;
}
