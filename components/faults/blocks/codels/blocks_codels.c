/*
 * Codels of blocks: they wait on a semaphore of the library, without a time-out.
 */
#include <errno.h>
#include <semaphore.h>
#include <unistd.h>

#include "genom3/c/exception.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("blocks.gen");

GENOM_EVENT(blocks_ether, "::blocks::ether");
GENOM_EVENT(blocks_pause_start, "::blocks::pause::start");

genom_event blocks_hang(const genom_context self);
genom_event blocks_hang_async(const genom_context self);
genom_event blocks_hang_steady(const genom_context self);
genom_event blocks_hang_until(const char *file, const genom_context self);
genom_event blocks_wait(const genom_context self);
genom_event blocks_validate(const genom_context self);
genom_event blocks_release(const genom_context self);
genom_event blocks_count(uint32_t *count, const genom_context self);
genom_event blocks_count_stop(const genom_context self);

static sem_t gate;

__attribute__((constructor)) static void
open_gate(void)
{
  sem_init(&gate, 0, 0);
}

static void
block(void)
{
  while (sem_wait(&gate) && errno == EINTR) continue;
}

genom_event
blocks_hang(const genom_context self)
{
  (void)self;
  block();
  return blocks_ether;
}

genom_event
blocks_hang_async(const genom_context self)
{
  (void)self;
  block();
  return blocks_ether;
}

genom_event
blocks_hang_steady(const genom_context self)
{
  (void)self;
  block();
  return blocks_ether;
}

genom_event
blocks_hang_until(const char *file, const genom_context self)
{
  (void)self;
  while (access(file, F_OK)) usleep(1000);
  return blocks_ether;
}

genom_event
blocks_wait(const genom_context self)
{
  (void)self;
  block();
  return genom_ok;
}

genom_event
blocks_validate(const genom_context self)
{
  (void)self;
  block();
  return genom_ok;
}

genom_event
blocks_release(const genom_context self)
{
  (void)self;
  sem_post(&gate);
  return genom_ok;
}

genom_event
blocks_count(uint32_t *count, const genom_context self)
{
  (void)self;
  ++*count;
  return blocks_pause_start;
}

genom_event
blocks_count_stop(const genom_context self)
{
  (void)self;
  return blocks_ether;
}
