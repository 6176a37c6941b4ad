/*
 * Codels of crashes.
 */
#include <signal.h>
#include <stdlib.h>

#include "genom3/c/exception.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("crashes.gen");

GENOM_EVENT(crashes_ether, "::crashes::ether");

genom_event crashes_segfault(const genom_context self);
genom_event crashes_abort(const genom_context self);
genom_event crashes_leave(const genom_context self);
genom_event crashes_divide(int32_t by, const genom_context self);

genom_event
crashes_segfault(const genom_context self)
{
  /* Hidden from the compiler, which would warn. */
  volatile int *volatile nowhere = NULL;

  (void)self;
  *nowhere = 1;
  return crashes_ether;
}

genom_event
crashes_abort(const genom_context self)
{
  (void)self;
  abort();
}

genom_event
crashes_leave(const genom_context self)
{
  (void)self;
  exit(0);
}

genom_event
crashes_divide(int32_t by, const genom_context self)
{
  volatile int32_t quotient;

  (void)self;
  /* Not all processors trap. */
  if (by == 0) raise(SIGFPE);
  quotient = 1000 / by;
  (void)quotient;
  return genom_ok;
}
