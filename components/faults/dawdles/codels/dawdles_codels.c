/*
 * Codels of dawdles: they keep a processor busy, as code that computes does.
 */
#include <pthread.h>
#include <signal.h>
#include <stdint.h>
#include <time.h>

#include "genom3/c/exception.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("dawdles.gen");

GENOM_EVENT(dawdles_ether, "::dawdles::ether");
GENOM_EVENT(dawdles_main, "::dawdles::main");
GENOM_EVENT(dawdles_pause_main, "::dawdles::pause::main");
GENOM_EVENT(dawdles_pause_start, "::dawdles::pause::start");

genom_event dawdles_work(uint32_t ms, const genom_context self);
genom_event dawdles_rest(const genom_context self);
genom_event dawdles_compute(const genom_context self);
genom_event dawdles_deaf(const genom_context self);
genom_event dawdles_idle(const genom_context self);
genom_event dawdles_wait(const genom_context self);
genom_event dawdles_calibrate(const genom_context self);
genom_event dawdles_drive(const genom_context self);

static double
seconds(void)
{
  struct timespec now;

  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec + now.tv_nsec * 1e-9;
}

genom_event
dawdles_work(uint32_t ms, const genom_context self)
{
  const double end = seconds() + ms * 1e-3;

  (void)self;
  while (seconds() < end) continue;
  return dawdles_pause_start;
}

genom_event
dawdles_rest(const genom_context self)
{
  (void)self;
  return dawdles_ether;
}

genom_event
dawdles_compute(const genom_context self)
{
  volatile uint32_t steps = 0;

  (void)self;
  for (;;) ++steps;
  return dawdles_ether;
}

genom_event
dawdles_deaf(const genom_context self)
{
  sigset_t all;

  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, NULL);
  return dawdles_compute(self);
}

genom_event
dawdles_idle(const genom_context self)
{
  (void)self;
  return dawdles_main;
}

genom_event
dawdles_wait(const genom_context self)
{
  (void)self;
  return dawdles_pause_main;
}

genom_event
dawdles_calibrate(const genom_context self)
{
  (void)self;
  return genom_ok;
}

genom_event
dawdles_drive(const genom_context self)
{
  (void)self;
  return genom_ok;
}
