/*
 * Codels of misses: one of two.
 */
#include "genom3/c/exception.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("misses.gen");

genom_event misses_present(const genom_context self);

genom_event
misses_present(const genom_context self)
{
  (void)self;
  return genom_ok;
}
