// C++ objects for a host that knows their types at run time only: std::string, storage of
// std::vector, handles of ports with a vtable, exceptions. The layouts that Rust code relies on
// are asserted here, for the C++ library that this host and the codels share.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <cxxabi.h>
#include <new>
#include <string>
#include <type_traits>
#include <typeinfo>
#include <vector>

#include "genom3/c++/exception.h"
#include "genom3/c++/idloptional.h"
#include "genom3/c++/idlsequence.h"

static_assert(sizeof(void *) == 8, "the types' sizes are those of 64-bit machines");
static_assert(sizeof(std::vector<double>) == 3 * sizeof(void *), "begin, end, end of storage");
static_assert(sizeof(std::vector<std::string>) == 3 * sizeof(void *), "for any element");
static_assert(alignof(std::vector<double>) == alignof(void *), "");
static_assert(alignof(std::string) == 8 && alignof(std::vector<bool>) == 8, "");

typedef genom::bounded_sequence<double, 4> four;
typedef genom::bounded_sequence<char, 3> three;
static_assert(std::is_standard_layout<four>::value && std::is_aggregate<four>::value, "");
static_assert(offsetof(four, e) == 0 && offsetof(four, n) == 32 && sizeof(four) == 40, "");
static_assert(offsetof(three, n) == 8 && sizeof(three) == 16, "");
static_assert(sizeof(four::size_type) == 8, "");
typedef genom::optional<double> maybe;
static_assert(std::is_standard_layout<maybe>::value && std::is_aggregate<maybe>::value, "");
static_assert(offsetof(maybe, _present) == 0 && offsetof(maybe, _value) == 8, "");
enum plain_enum { A = 0, genom_max_plain_enum = 0xffffffff };
static_assert(sizeof(plain_enum) == 4, "enums are 32 bits wide");
// A vtable pointer, followed by the detail.
static_assert(sizeof(genom::exception) == 8 && std::is_polymorphic<genom::exception>::value, "");
static_assert(sizeof(genom::unkex) == 8 + 128 && sizeof(genom::syserr) == 16, "");

// Whether std::vector consists of begin, end and end of storage, in this order.
template <typename T> static bool keeps(const T &value)
{
  std::vector<T> v;
  void *words[3];
  static_assert(sizeof(words) == sizeof(v), "");
  std::memcpy(words, &v, sizeof(words));
  if (words[0] || words[1] || words[2]) return false;
  v.reserve(5);
  v.push_back(value);
  v.push_back(value);
  std::memcpy(words, &v, sizeof(words));
  return words[0] == &v[0] && words[1] == &v[0] + 2 && words[2] == &v[0] + v.capacity();
}

extern "C" int genom_host_cxx_layout_holds() noexcept
{
  return keeps<std::int8_t>(1) && keeps<double>(1) && keeps<std::string>("x") &&
         keeps<std::vector<double>>({1});
}

extern "C" std::size_t genom_host_string_size() noexcept { return sizeof(std::string); }
extern "C" std::size_t genom_host_flags_size() noexcept { return sizeof(std::vector<bool>); }

extern "C" void genom_host_string_make(void *at) noexcept { new (at) std::string; }

extern "C" void genom_host_string_drop(void *at) noexcept
{
  static_cast<std::string *>(at)->~basic_string();
}

extern "C" void genom_host_string_set(void *at, const char *text, std::size_t length) noexcept
{
  static_cast<std::string *>(at)->assign(text, length);
}

extern "C" const char *genom_host_string_get(const void *at, std::size_t *length) noexcept
{
  const std::string &text = *static_cast<const std::string *>(at);
  *length = text.size();
  return text.data();
}

// std::vector<bool> packs bits, so it is accessed here only.
typedef std::vector<bool> flags;

extern "C" void genom_host_flags_make(void *at) noexcept { new (at) flags; }
extern "C" void genom_host_flags_drop(void *at) noexcept { static_cast<flags *>(at)->~flags(); }

extern "C" void genom_host_flags_set(void *at, const std::uint8_t *from, std::size_t n) noexcept
{
  flags &to = *static_cast<flags *>(at);
  to.resize(n);
  for (std::size_t i = 0; i < n; i++) to[i] = from[i] != 0;
}

extern "C" std::size_t genom_host_flags_length(const void *at) noexcept
{
  return static_cast<const flags *>(at)->size();
}

extern "C" void genom_host_flags_get(const void *at, std::uint8_t *to) noexcept
{
  const flags &from = *static_cast<const flags *>(at);
  for (std::size_t i = 0; i < from.size(); i++) to[i] = from[i];
}

// As std::allocator does.
extern "C" void *genom_host_storage(std::size_t bytes) noexcept { return ::operator new(bytes); }
extern "C" void genom_host_storage_free(void *at) noexcept { ::operator delete(at); }

// The demangled name, to be released with free(); null if it cannot be demangled.
extern "C" char *genom_host_demangle(const char *name) noexcept
{
  int status = 0;
  return abi::__cxa_demangle(name, nullptr, nullptr, &status);
}

// An exception to throw: a vtable in the host's memory, and a detail, which is copied byte by byte,
// or constructed by `construct`.
struct raise {
  const void *const *vtable;
  const std::type_info *type;
  const void *detail;
  std::size_t size;
  void (*construct)(const void *detail, const void *type, void *to);
};

// Entries of the vtable of such an exception: what(), its name, and for a detail that owns memory
// the function that destroys it and its type.
enum { WHAT = 0, NAME = 1, DROP = 2, TYPE = 3 };

static void drop_it(void *object)
{
  const void *const *vtable = *static_cast<const void *const *const *>(object);
  typedef void (*drop)(const void *type, void *at);
  reinterpret_cast<drop>(const_cast<void *>(vtable[DROP]))(
    vtable[TYPE], static_cast<char *>(object) + 8);
}

static void throw_it(const raise *what)
{
  if (!what) return;
  char *object = static_cast<char *>(abi::__cxa_allocate_exception(8 + what->size));
  std::memcpy(object, &what->vtable, 8);
  if (what->construct)
    what->construct(what->detail, what->vtable[TYPE], object + 8);
  else if (what->size)
    std::memcpy(object + 8, what->detail, what->size);
  abi::__cxa_throw(object, const_cast<std::type_info *>(what->type),
                   what->construct ? drop_it : nullptr);
}

// what() of such an exception: returns the name, which is in the vtable.
extern "C" const char *genom_host_raised_what(const void *self) noexcept
{
  const char *const *const *object = static_cast<const char *const *const *>(self);
  return (*object)[NAME];
}

// The type for exceptions that the codels have no type for.
extern "C" const void *genom_host_exception_type() noexcept { return &typeid(genom::exception); }

// Ports as declared in genom3.md 6, for data of any type: a reference is passed as an address.
struct methods {
  const void *(*data)(void *port, const char *id, const raise **failed);
  const raise *(*act)(void *port, int action, const char *id);
};

enum { READ = 0, WRITE = 1, OPEN = 2, CLOSE = 3 };

struct handle {
  const methods *m;
  void *port;

  const void *data(const char *id) const
  {
    const raise *failed = nullptr;
    const void *at = m->data(port, id, &failed);
    throw_it(failed);
    return at;
  }
  void act(int action, const char *id) const { throw_it(m->act(port, action, id)); }
};

struct in_port {
  virtual const void *data() const { return h.data(nullptr); }
  virtual void read() { h.act(READ, nullptr); }
  handle h;
  explicit in_port(handle h): h(h) {}
};

struct out_port {
  virtual const void *data() const { return h.data(nullptr); }
  virtual void write() { h.act(WRITE, nullptr); }
  handle h;
  explicit out_port(handle h): h(h) {}
};

struct multiple_in_port {
  virtual const void *data(const char *id) const { return h.data(id); }
  virtual void read(const char *id) { h.act(READ, id); }
  handle h;
  explicit multiple_in_port(handle h): h(h) {}
};

struct multiple_out_port {
  virtual const void *data(const char *id) const { return h.data(id); }
  virtual void write(const char *id) { h.act(WRITE, id); }
  virtual void open(const char *id) { h.act(OPEN, id); }
  virtual void close(const char *id) { h.act(CLOSE, id); }
  handle h;
  explicit multiple_out_port(handle h): h(h) {}
};

static_assert(sizeof(in_port) == 24 && sizeof(multiple_out_port) == 24, "three words");

// Constructs a handle of three words at `at`, which needs no destruction.
extern "C" void genom_host_port_make(
  void *at, int out, int multiple, const methods *m, void *port) noexcept
{
  const handle h = {m, port};
  if (multiple) {
    if (out)
      new (at) multiple_out_port(h);
    else
      new (at) multiple_in_port(h);
  } else {
    if (out)
      new (at) out_port(h);
    else
      new (at) in_port(h);
  }
}

// Called by a remote's function, which libffi makes; exceptions pass through that function.
struct remote {
  const raise *(*call)(const void *data, void *const *arguments);
  const void *data;
};

extern "C" void genom_host_remote_enter(void *, void *, void **arguments, const remote *bound)
{
  throw_it(bound->call(bound->data, arguments));
}
