/*
 * Codels of trespasses.
 */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "genom3/c/exception.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("trespasses.gen");

GENOM_EVENT(trespasses_start, "::trespasses::start");
GENOM_EVENT(trespasses_ether, "::trespasses::ether");

/* A file is opened, a byte goes one way or the other. */
static int32_t
touch(const char *path, int flags)
{
  char byte = 'x';
  int file = open(path, flags | O_CLOEXEC, 0600);
  int32_t error = 0;

  if (file < 0) return errno;
  switch (flags & O_WRONLY ? write(file, &byte, 1) : read(file, &byte, 1)) {
    case -1: error = errno; break;
    case 0: error = ENODATA; break;
  }
  close(file);
  return error;
}

genom_event
trespasses_read_file(const char *path, int32_t *error, const genom_context self);
genom_event
trespasses_read_file(const char *path, int32_t *error, const genom_context self)
{
  (void)self;
  *error = touch(path, O_RDONLY);
  return genom_ok;
}

genom_event
trespasses_write_file(const char *path, int32_t *error, const genom_context self);
genom_event
trespasses_write_file(const char *path, int32_t *error, const genom_context self)
{
  (void)self;
  *error = touch(path, O_WRONLY | O_CREAT);
  return genom_ok;
}

/* Connects a new socket, and sends a byte. */
static int32_t
reach(int family, int kind, const void *address, socklen_t length)
{
  int32_t error = 0;
  int made = socket(family, kind | SOCK_CLOEXEC, 0);

  if (made < 0) return errno;
  if (connect(made, address, length) < 0 || send(made, "x", 1, MSG_NOSIGNAL) < 0) error = errno;
  close(made);
  return error;
}

static int32_t
reach_port(int kind, uint16_t port)
{
  struct sockaddr_in address = { .sin_family = AF_INET, .sin_port = htons(port) };

  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return reach(AF_INET, kind, &address, sizeof address);
}

genom_event
trespasses_connect_tcp(uint16_t port, int32_t *error, const genom_context self);
genom_event
trespasses_connect_tcp(uint16_t port, int32_t *error, const genom_context self)
{
  (void)self;
  *error = reach_port(SOCK_STREAM, port);
  return genom_ok;
}

genom_event
trespasses_send_udp(uint16_t port, int32_t *error, const genom_context self);
genom_event
trespasses_send_udp(uint16_t port, int32_t *error, const genom_context self)
{
  (void)self;
  *error = reach_port(SOCK_DGRAM, port);
  return genom_ok;
}

genom_event
trespasses_connect_unix(const char *path, int32_t *error, const genom_context self);
genom_event
trespasses_connect_unix(const char *path, int32_t *error, const genom_context self)
{
  struct sockaddr_un address = { .sun_family = AF_UNIX };

  (void)self;
  snprintf(address.sun_path, sizeof address.sun_path, "%s", path);
  *error = reach(AF_UNIX, SOCK_STREAM, &address, sizeof address);
  return genom_ok;
}

genom_event
trespasses_open_files(int32_t *opened, const genom_context self);
genom_event
trespasses_open_files(int32_t *opened, const genom_context self)
{
  static int files[1 << 20];
  int32_t count = 0;

  (void)self;
  while (count < 1 << 20 && (files[count] = open("/dev/null", O_RDONLY | O_CLOEXEC)) >= 0) count++;
  *opened = count;
  while (count > 0) close(files[--count]);
  return genom_ok;
}

genom_event
trespasses_lift_limit(int32_t *error, const genom_context self);
genom_event
trespasses_lift_limit(int32_t *error, const genom_context self)
{
  struct rlimit limit;

  (void)self;
  getrlimit(RLIMIT_NOFILE, &limit);
  limit.rlim_cur = limit.rlim_max = limit.rlim_max + 1000;
  *error = setrlimit(RLIMIT_NOFILE, &limit) < 0 ? errno : 0;
  return genom_ok;
}

static int32_t
set_policy(int policy, int priority)
{
  struct sched_param wanted = { .sched_priority = priority };

  return pthread_setschedparam(pthread_self(), policy, &wanted);
}

genom_event
trespasses_go_real_time(int32_t *error, const genom_context self);
genom_event
trespasses_go_real_time(int32_t *error, const genom_context self)
{
  (void)self;
  *error = set_policy(SCHED_FIFO, 1);
  if (*error == 0) set_policy(SCHED_OTHER, 0);
  return genom_ok;
}

genom_event
trespasses_spin_real_time(int32_t *error, const genom_context self);
genom_event
trespasses_spin_real_time(int32_t *error, const genom_context self)
{
  struct timespec start, now;

  (void)self;
  *error = set_policy(SCHED_FIFO, 1);
  if (*error != 0) return trespasses_ether;
  clock_gettime(CLOCK_MONOTONIC, &start);
  /* Not for ever, so that a machine that does not stop it can be used again. */
  do clock_gettime(CLOCK_MONOTONIC, &now);
  while (now.tv_sec - start.tv_sec < 20);
  set_policy(SCHED_OTHER, 0);
  return trespasses_ether;
}

static void
wait_for_ever(void)
{
  for (;;) pause();
}

genom_event
trespasses_fork_children(int32_t most, int32_t *made, const genom_context self);
genom_event
trespasses_fork_children(int32_t most, int32_t *made, const genom_context self)
{
  (void)self;
  for (*made = 0; *made < most; ++*made) {
    pid_t child = fork();

    if (child == 0) wait_for_ever();
    if (child < 0) break;
  }
  return genom_ok;
}

genom_event
trespasses_leave_daemon(int32_t *pid, const genom_context self);
genom_event
trespasses_leave_daemon(int32_t *pid, const genom_context self)
{
  int ends[2];
  pid_t child;

  (void)self;
  *pid = 0;
  if (pipe2(ends, O_CLOEXEC) < 0) return genom_ok;
  child = fork();
  if (child == 0) {
    setsid();
    child = fork();
    if (child == 0) wait_for_ever();
    if (write(ends[1], &child, sizeof child) < 0) _exit(1);
    _exit(0);
  }
  if (child > 0) {
    if (read(ends[0], &child, sizeof child) == sizeof child) *pid = child;
    waitpid(-1, NULL, WNOHANG);
  }
  close(ends[0]);
  close(ends[1]);
  return genom_ok;
}

genom_event
trespasses_allocate(const genom_context self);
genom_event
trespasses_allocate(const genom_context self)
{
  enum { size = 1 << 22 };
  /* The compiler may not leave out what nobody reads. */
  volatile char *block = malloc(size);

  (void)self;
  for (int at = 0; at < size; at += 4096) block[at] = 1;
  return trespasses_start;
}
