/*
 * Codels of spins.
 */
#include <time.h>

#include "genom3/c/exception.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("spins.gen");

GENOM_EVENT(spins_start, "::spins::start");
GENOM_EVENT(spins_ether, "::spins::ether");

#define CODEL(name) \
  genom_event name(const genom_context self); \
  genom_event name(const genom_context self)

CODEL(spins_spin) { (void)self; return spins_start; }
CODEL(spins_spin_steady) { (void)self; return spins_start; }
CODEL(spins_stop) { (void)self; return spins_ether; }

CODEL(spins_listen)
{
  const struct timespec data = { 0, 10 * 1000 * 1000 };

  (void)self;
  nanosleep(&data, NULL);
  return spins_start;
}
