/*
 * Codels of unruly.
 */
#define _GNU_SOURCE
#include <fenv.h>
#include <locale.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "genom3/c/exception.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("unruly.gen");

GENOM_EVENT(unruly_ether, "::unruly::ether");

genom_event unruly_start(const genom_context self);
genom_event unruly_stop(const genom_context self);
genom_event unruly_constructed(int32_t *constructed, const genom_context self);
genom_event unruly_turns(uint32_t *turns, const genom_context self);
genom_event unruly_fork(int32_t *status, const genom_context self);
genom_event unruly_shell(int32_t *status, const genom_context self);
genom_event unruly_block_signals(const genom_context self);
genom_event unruly_ignore_signals(const genom_context self);
genom_event unruly_speak(const genom_context self);
genom_event unruly_change_world(const genom_context self);

static int32_t constructed;
static uint32_t turns;
static bool asked_to_end;
static bool running;
static pthread_t thread;

__attribute__((constructor)) static void
construct(void)
{
  constructed++;
}

static void *
turn(void *unused)
{
  const struct timespec pause = { 0, 1000000 };

  (void)unused;
  while (!__atomic_load_n(&asked_to_end, __ATOMIC_ACQUIRE)) {
    __atomic_add_fetch(&turns, 1, __ATOMIC_RELAXED);
    nanosleep(&pause, NULL);
  }
  return NULL;
}

static genom_event
failed(int error, genom_context self)
{
  genom_syserr_detail detail;

  detail.code = error;
  return genom_syserr(&detail, self);
}

genom_event
unruly_start(const genom_context self)
{
  int error = pthread_create(&thread, NULL, turn, NULL);

  if (error) return failed(error, self);
  running = true;
  return unruly_ether;
}

genom_event
unruly_stop(const genom_context self)
{
  (void)self;
  if (running) {
    __atomic_store_n(&asked_to_end, true, __ATOMIC_RELEASE);
    pthread_join(thread, NULL);
    running = false;
  }
  return unruly_ether;
}

genom_event
unruly_constructed(int32_t *value, const genom_context self)
{
  (void)self;
  *value = constructed;
  return genom_ok;
}

genom_event
unruly_turns(uint32_t *value, const genom_context self)
{
  (void)self;
  *value = __atomic_load_n(&turns, __ATOMIC_RELAXED);
  return genom_ok;
}

genom_event
unruly_fork(int32_t *status, const genom_context self)
{
  int result = 0;
  pid_t child = fork();

  (void)self;
  if (child == 0) _exit(3);
  *status = child > 0 && waitpid(child, &result, 0) == child ? WEXITSTATUS(result) : -1;
  return genom_ok;
}

genom_event
unruly_shell(int32_t *status, const genom_context self)
{
  int result = system("exit 4");

  (void)self;
  *status = result >= 0 ? WEXITSTATUS(result) : -1;
  return genom_ok;
}

genom_event
unruly_block_signals(const genom_context self)
{
  sigset_t all;

  (void)self;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, NULL);
  return genom_ok;
}

genom_event
unruly_ignore_signals(const genom_context self)
{
  (void)self;
  signal(SIGINT, SIG_IGN);
  signal(SIGTERM, SIG_IGN);
  signal(SIGCHLD, SIG_IGN);
  return genom_ok;
}

genom_event
unruly_speak(const genom_context self)
{
  (void)self;
  fputs("unruly says something", stdout);
  fputs("unruly complains", stderr);
  fflush(NULL);
  return genom_ok;
}

genom_event
unruly_change_world(const genom_context self)
{
  (void)self;
  if (chdir("/")) return failed(1, self);
  umask(0777);
  setlocale(LC_ALL, "");
  fesetround(FE_TOWARDZERO);
  return genom_ok;
}
