// Calls a codel and catches the C++ exceptions that escape from it: unwinding into Rust would abort
// the daemon. Costs nothing unless an exception is thrown.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <cxxabi.h>
#include <exception>
#include <typeinfo>

#include "genom3/c++/exception.h"

#include "../process/left.h"

extern "C" void ffi_call(void *cif, void (*function)(void), void *result, void **arguments);

// Reports in which codel a thread is being cancelled (last_words.rs).
extern "C" void genom_host_thread_ends(void);

static void tell(char *what, std::size_t room, const char *text)
{
  if (!room) return;
  std::strncpy(what, text ? text : "", room - 1);
  what[room - 1] = '\0';
}

static void tell_type(char *what, std::size_t room)
{
  const std::type_info *type = abi::__cxa_current_exception_type();
  if (!type) {
    tell(what, room, "an exception that is not of C++");
    return;
  }
  int status = 0;
  char *name = abi::__cxa_demangle(type->name(), nullptr, nullptr, &status);
  tell(what, room, "C++ exception of type ");
  if (room) std::strncat(what, name ? name : type->name(), room - 1 - std::strlen(what));
  std::free(name);
}

// Receives exceptions of codels with lang "c++" (genom3.md 6).
struct catcher {
  int (*caught)(catcher *self, const char *type, const char *what, const void *object);
};

// Passes the exception on with its own type, then with the types that it is derived from, until one
// is known.
static void show(catcher *who, const genom::exception &e)
{
  const void *object = dynamic_cast<const void *>(&e);
  const std::type_info *type = &typeid(e);
  while (type && !who->caught(who, type->name(), e.what(), object)) {
    const abi::__si_class_type_info *derived =
      dynamic_cast<const abi::__si_class_type_info *>(type);
    type = derived ? derived->__base_type : nullptr;
  }
}

// Runs `call`. Returns 1 if it threw: what[0..room] is the message, and `who`, unless null, is
// informed. Returns 2 if it tried to end its thread: what[0..room] says how.
template <typename F> static int guarded(F call, char *what, std::size_t room, catcher *who)
{
  try {
    call();
    return 0;
  } catch (const abi::__forced_unwind &) {
    genom_host_thread_ends();
    throw;  // the cancellation of the thread has to continue
  } catch (const genom_host::left &l) {
    tell(what, room, l.how);
    return 2;
  } catch (const genom::exception &e) {
    tell_type(what, room);
    if (who) show(who, e);
  } catch (const std::exception &e) {
    tell(what, room, e.what());
  } catch (const char *text) {
    tell(what, room, text);
  } catch (...) {
    tell_type(what, room);
  }
  return 1;
}

// As in <dlfcn.h>, but not declared noexcept, since constructors may throw.
extern "C" void *genom_host_dlopen(const char *file, int mode) __asm__("dlopen");

extern "C" int genom_host_guarded_open(
  const char *file, int mode, void **handle, char *what, std::size_t room)
{
  return guarded([&] { *handle = genom_host_dlopen(file, mode); }, what, room, nullptr);
}

// Through libffi, for any interface.
extern "C" int genom_host_guarded_call(
  void *cif, void (*function)(void), void *result, void **arguments, char *what, std::size_t room,
  catcher *who)
{
  return guarded([&] { ffi_call(cif, function, result, arguments); }, what, room, who);
}

// Without libffi, on platforms that assign integer and floating-point arguments to separate banks
// of registers (x86-64 System V, AArch64): a function reads the registers of its prototype, and the
// stack in order, and ignores what else is passed.
typedef std::uint64_t I;
typedef const char *(*function8)(I, I, I, I, I, I, I, I, double, double, double, double, double,
                                 double, double, double);
typedef const char *(*function14)(I, I, I, I, I, I, I, I, I, I, I, I, I, I, double, double, double,
                                  double, double, double, double, double);

extern "C" int genom_host_guarded_registers(
  void (*function)(void), const char **result, const I *i, std::size_t count, const double *d,
  char *what, std::size_t room, catcher *who)
{
  if (count <= 8) {
    const function8 f = reinterpret_cast<function8>(function);
    return guarded(
      [&] {
        *result = f(i[0], i[1], i[2], i[3], i[4], i[5], i[6], i[7], d[0], d[1], d[2], d[3], d[4],
                    d[5], d[6], d[7]);
      },
      what, room, who);
  }
  const function14 f = reinterpret_cast<function14>(function);
  return guarded(
    [&] {
      *result = f(i[0], i[1], i[2], i[3], i[4], i[5], i[6], i[7], i[8], i[9], i[10], i[11], i[12],
                  i[13], d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7]);
    },
    what, room, who);
}
