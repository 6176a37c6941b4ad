/*
 * Exceptions of codels in C++: thrown with `throw`, by codels and by methods of ports.
 *
 * An exception `X` of a .gen file is `struct X : genom::exception { struct detail {..} detail; }`.
 */
#ifndef GENOM3_CXX_EXCEPTION_H
#define GENOM3_CXX_EXCEPTION_H

#include <cstdint>

#include "genom3/c++/event.h"

namespace genom {

/*
 * Base of all exceptions. It has one virtual function and nothing else: the host makes objects
 * of derived types by that layout.
 */
struct __attribute__((visibility("default"))) exception {
  virtual const char *what() const { return fatal; }
};

/* A system call failed. */
GENOM_CXX_EVENT(syserr_id, "::genom::syserr");

struct __attribute__((visibility("default"))) syserr : public exception {
  struct detail {
    std::int32_t code; /* errno */
  } detail;

  syserr(): detail() {}
  explicit syserr(const struct detail &d): detail(d) {}
  const char *what() const { return syserr_id; }
};

/* An error that is not declared, with a message. */
GENOM_CXX_EVENT(unkex_id, "::genom::unkex");

struct __attribute__((visibility("default"))) unkex : public exception {
  struct detail {
    char what[128]; /* NUL included */
  } detail;

  unkex(): detail() {}
  explicit unkex(const struct detail &d): detail(d) {}
  const char *what() const { return unkex_id; }
};

}

#endif /* GENOM3_CXX_EXCEPTION_H */
