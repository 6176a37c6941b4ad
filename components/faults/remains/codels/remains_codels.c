/*
 * Codels of remains.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "genom3/c/exception.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("remains.gen");

genom_event remains_spin(const genom_context self);
genom_event remains_spin_masked(const genom_context self);
genom_event remains_handle_signal(const genom_context self);
genom_event remains_tick_by_thread(const genom_context self);
genom_event remains_tick_by_signal(const genom_context self);
genom_event remains_keep_value(const genom_context self);
genom_event remains_child(int32_t *pid, const genom_context self);
genom_event remains_child_returns(int32_t *pid, const genom_context self);

static volatile unsigned long turns;

static genom_event
failed(int error, genom_context self)
{
  genom_syserr_detail detail;

  detail.code = error;
  return genom_syserr(&detail, self);
}

static void *
turn(void *unused)
{
  (void)unused;
  for (;;) turns++;
  return NULL;
}

static genom_event
start(genom_context self)
{
  pthread_t thread;
  int error = pthread_create(&thread, NULL, turn, NULL);

  if (error) return failed(error, self);
  pthread_detach(thread);
  return genom_ok;
}

genom_event
remains_spin(const genom_context self)
{
  return start(self);
}

genom_event
remains_spin_masked(const genom_context self)
{
  sigset_t all, before;
  genom_event e;

  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, &before);
  e = start(self);
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  return e;
}

static void
handle(int signal)
{
  (void)signal;
  turns++;
}

static int
handle_with(int signal)
{
  struct sigaction action;

  memset(&action, 0, sizeof(action));
  action.sa_handler = handle;
  return sigaction(signal, &action, NULL);
}

genom_event
remains_handle_signal(const genom_context self)
{
  return handle_with(SIGUSR2) ? failed(errno, self) : genom_ok;
}

static void
tick(union sigval unused)
{
  (void)unused;
  turns++;
}

static genom_event
repeat(struct sigevent *event, genom_context self)
{
  const struct itimerspec each = { { 0, 1000000 }, { 0, 1000000 } };
  timer_t timer;

  if (timer_create(CLOCK_MONOTONIC, event, &timer)) return failed(errno, self);
  return timer_settime(timer, 0, &each, NULL) ? failed(errno, self) : genom_ok;
}

genom_event
remains_tick_by_thread(const genom_context self)
{
  struct sigevent event;

  memset(&event, 0, sizeof(event));
  event.sigev_notify = SIGEV_THREAD;
  event.sigev_notify_function = tick;
  return repeat(&event, self);
}

genom_event
remains_tick_by_signal(const genom_context self)
{
  struct sigevent event;

  if (handle_with(SIGRTMIN + 5)) return failed(errno, self);
  memset(&event, 0, sizeof(event));
  event.sigev_notify = SIGEV_SIGNAL;
  event.sigev_signo = SIGRTMIN + 5;
  return repeat(&event, self);
}

static void
destroy(void *value)
{
  (void)value;
  turns++;
}

genom_event
remains_keep_value(const genom_context self)
{
  static pthread_key_t key;
  int error = pthread_key_create(&key, destroy);

  if (!error) error = pthread_setspecific(key, &key);
  return error ? failed(error, self) : genom_ok;
}

genom_event
remains_child(int32_t *pid, const genom_context self)
{
  (void)self;
  *pid = fork();
  if (*pid == 0) {
    const struct timespec long_enough = { 100, 0 };
    int descriptor;

    /* Like programs that run in the background. */
    for (descriptor = 0; descriptor < 3; descriptor++) close(descriptor);
    nanosleep(&long_enough, NULL);
    _exit(0);
  }
  return genom_ok;
}

genom_event
remains_child_returns(int32_t *pid, const genom_context self)
{
  (void)self;
  *pid = fork();
  return genom_ok;
}
