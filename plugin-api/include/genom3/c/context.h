/*
 * The context of a codel: the last argument of every codel, through which exceptions are thrown.
 *
 * A codel uses the context it was called with, while it runs, and keeps no copy of it.
 */
#ifndef GENOM3_C_CONTEXT_H
#define GENOM3_C_CONTEXT_H

#include <stddef.h>

#include "genom3/c/event.h"

#ifdef __cplusplus
extern "C" {
#endif

struct genom_context_data;
typedef const struct genom_context_iface *genom_context;

struct genom_context_iface {
  /*
   * Records exception `ex` with a copy of the `size` bytes at `detail` (NULL and 0 without
   * detail). Returns `ex`, for the codel to return, or genom_fatal if it cannot. Pointers
   * within the detail are not followed.
   */
  genom_event (*raise)(genom_event ex, const void *detail, size_t size, genom_context self);

  /*
   * Stores the last recorded exception in `*ex`, unless `ex` is NULL, and returns its detail,
   * which is valid until the next exception.
   */
  const void *(*raised)(genom_event *ex, genom_context self);

  /* Private data of the host. */
  struct genom_context_data *data;
};

#ifdef __cplusplus
}
#endif

#endif /* GENOM3_C_CONTEXT_H */
