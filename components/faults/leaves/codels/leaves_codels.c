/*
 * Codels of leaves.
 */
#define _GNU_SOURCE
#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "genom3/c/exception.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("leaves.gen");

GENOM_EVENT(leaves_ether, "::leaves::ether");
GENOM_EVENT(leaves_jump_state, "::leaves::jump");

#define CODEL(name) \
  genom_event name(const genom_context self); \
  genom_event name(const genom_context self)

CODEL(leaves_exit_thread) { (void)self; pthread_exit(NULL); }
CODEL(leaves_wild) { (void)self; return (genom_event)0x123456789000; }
CODEL(leaves_small) { (void)self; return (genom_event)7; }
CODEL(leaves_terminate) { (void)self; raise(SIGTERM); return genom_ok; }
CODEL(leaves_hang_up) { (void)self; raise(SIGHUP); return genom_ok; }
CODEL(leaves_exit_process) { (void)self; _exit(0); }

CODEL(leaves_exit_thread_by_call)
{
  (void)self;
  syscall(SYS_exit, 0);
  return leaves_ether;
}

CODEL(leaves_exit_process_by_call)
{
  (void)self;
  syscall(SYS_exit_group, 0);
  return genom_ok;
}

CODEL(leaves_cancel_thread)
{
  (void)self;
  pthread_cancel(pthread_self());
  pthread_testcancel();
  return leaves_ether;
}

static void *
leave(void *unused)
{
  (void)unused;
  exit(0);
}

CODEL(leaves_exit_later)
{
  pthread_t thread;

  (void)self;
  if (!pthread_create(&thread, NULL, leave, NULL)) pthread_detach(thread);
  return genom_ok;
}

static jmp_buf place;

CODEL(leaves_mark)
{
  (void)self;
  /* This frame does not exist any more when the jump comes back here. */
  if (setjmp(place)) return leaves_ether;
  return leaves_jump_state;
}

CODEL(leaves_jump)
{
  (void)self;
  longjmp(place, 1);
}

CODEL(leaves_jump_within)
{
  jmp_buf here;

  (void)self;
  if (setjmp(here)) return leaves_ether;
  longjmp(here, 1);
}
