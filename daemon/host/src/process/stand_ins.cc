// Replaces functions of the C library by which code ends its thread or its process. Definitions of
// the program precede those of its libraries, so codels call these.
//
// A codel shares its thread with its task, and its process with all components. If it tries to end
// its thread, its service ends instead, with an exception that says so; if it ends the process, it
// is named, and the process ends with a failure. For all other code the functions do what the C
// library's do.

#include <atomic>
#include <dlfcn.h>
#include <sys/syscall.h>

#include "left.h"

// Whether this thread of the daemon runs a codel (running.rs).
extern "C" bool genom_host_in_codel(void);
// Reports who ends the process, unless it ends normally or is a child; returns whether it reported.
extern "C" bool genom_host_process_ends(const char *how);
// A signal is being sent to this process (signals.rs).
extern "C" void genom_host_signal_sent(int signal, int pid);

typedef unsigned long word;
typedef long (*system_call)(long, word, word, word, word, word, word);
typedef void (*thread_exit)(void *);
typedef int (*thread_cancel)(word);
typedef word (*thread_self)(void);

// The C library's function with this name.
template <typename F> static F next(std::atomic<F> &known, const char *name)
{
  F found = known.load(std::memory_order_relaxed);
  if (!found) {
    found = reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
    known.store(found, std::memory_order_relaxed);
  }
  return found;
}

static std::atomic<system_call> real_syscall;
static std::atomic<thread_exit> real_exit;
static std::atomic<thread_cancel> real_cancel;
static std::atomic<thread_self> real_self;

[[noreturn]] static void end_process(int status)
{
  for (;;) {
    next(real_syscall, "syscall")(SYS_exit_group, static_cast<word>(status), 0, 0, 0, 0, 0);
  }
}

extern "C" {

long syscall(long number, word a, word b, word c, word d, word e, word f)
{
  if (__builtin_expect(number == SYS_exit, 0) && genom_host_in_codel()) {
    throw genom_host::left{"it called syscall(SYS_exit), which would end its task's thread"};
  }
  if (__builtin_expect(number == SYS_exit_group, 0)) {
    if (genom_host_process_ends("syscall(SYS_exit_group)")) a = 1;
  }
  return next(real_syscall, "syscall")(number, a, b, c, d, e, f);
}

[[noreturn]] void pthread_exit(void *value)
{
  if (genom_host_in_codel()) {
    throw genom_host::left{"it called pthread_exit, which would end its task's thread"};
  }
  next(real_exit, "pthread_exit")(value);
  __builtin_unreachable();
}

int pthread_cancel(word thread)
{
  if (genom_host_in_codel() && thread == next(real_self, "pthread_self")()) {
    throw genom_host::left{"it called pthread_cancel on its task's thread"};
  }
  return next(real_cancel, "pthread_cancel")(thread);
}

[[noreturn]] void _exit(int status)
{
  end_process(genom_host_process_ends("_exit") ? 1 : status);
}

[[noreturn]] void _Exit(int status)
{
  end_process(genom_host_process_ends("_Exit") ? 1 : status);
}

int kill(int pid, int signal)
{
  if (signal) genom_host_signal_sent(signal, pid);
  return static_cast<int>(next(real_syscall, "syscall")(
    SYS_kill, static_cast<word>(pid), static_cast<word>(signal), 0, 0, 0, 0));
}

// Looks up the C library's functions before codels run, and refers to the definitions above: the
// linker would drop them if nothing did.
void genom_host_stand_in(void)
{
  next(real_syscall, "syscall");
  next(real_exit, "pthread_exit");
  next(real_cancel, "pthread_cancel");
  next(real_self, "pthread_self");
  __asm__ volatile("" : : "r"(&syscall), "r"(&pthread_exit), "r"(&pthread_cancel), "r"(&_exit),
                   "r"(&_Exit), "r"(&kill));
}

}
