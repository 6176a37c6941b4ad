/*
 * Codels of grabs.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <sys/resource.h>
#include <unistd.h>

#include "genom3/c/exception.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("grabs.gen");

#define CODEL(name) \
  genom_event name(const genom_context self); \
  genom_event name(const genom_context self)

/* Like code that ignores the result of setrlimit. */
static genom_event
limit(int resource, rlim_t most)
{
  struct rlimit limits;

  getrlimit(resource, &limits);
  limits.rlim_cur = most;
  setrlimit(resource, &limits);
  return genom_ok;
}

CODEL(grabs_limit_files) { (void)self; return limit(RLIMIT_NOFILE, 8); }
CODEL(grabs_limit_memory) { (void)self; return limit(RLIMIT_AS, 1 << 20); }
CODEL(grabs_limit_file_size) { (void)self; return limit(RLIMIT_FSIZE, 1); }
CODEL(grabs_alarm) { (void)self; raise(SIGALRM); return genom_ok; }
CODEL(grabs_user_signal) { (void)self; raise(SIGUSR1); return genom_ok; }
CODEL(grabs_default_signal) { (void)self; signal(SIGALRM, SIG_DFL); return genom_ok; }

CODEL(grabs_close_standard)
{
  (void)self;
  close(0);
  close(1);
  close(2);
  return genom_ok;
}

CODEL(grabs_close_streams)
{
  (void)self;
  fclose(stdout);
  fclose(stderr);
  return genom_ok;
}
