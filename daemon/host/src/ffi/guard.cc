// Calls a codel through libffi and stops the C++ exceptions it lets escape: unwinding further,
// into Rust, would abort the daemon. Costs nothing as long as nothing is thrown.

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <cxxabi.h>
#include <exception>
#include <typeinfo>

extern "C" void ffi_call(void *cif, void (*function)(void), void *result, void **arguments);

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

// 0: the function returned; 1: it threw, and what[0..room] says what.
extern "C" int genom_host_guarded_call(
  void *cif, void (*function)(void), void *result, void **arguments, char *what, std::size_t room)
{
  try {
    ffi_call(cif, function, result, arguments);
    return 0;
  } catch (const abi::__forced_unwind &) {
    throw;  // the thread is being cancelled: that must go on
  } catch (const std::exception &e) {
    tell(what, room, e.what());
  } catch (const char *text) {
    tell(what, room, text);
  } catch (...) {
    tell_type(what, room);
  }
  return 1;
}
