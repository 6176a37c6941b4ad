/*
 * What any codel may return: genom_ok, and the exceptions that need no declaration.
 *
 * A service reports its own exceptions to clients as they are; declare yours in the .gen file
 * rather than throw these two from a service.
 */
#ifndef GENOM3_C_EXCEPTION_H
#define GENOM3_C_EXCEPTION_H

#include <stdint.h>

#include "genom3/c/context.h"
#include "genom3/c/event.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Success of a function's or validation codel, and of the methods of ports and remotes. */
extern genom_event genom_ok GENOM_WEAK;
genom_event genom_ok = 0;

#ifdef __cplusplus
}
#endif

/* An exception could not be recorded. */
GENOM_EVENT(genom_fatal, "::genom::fatal");

/* An error that is not declared, with a message. */
GENOM_EVENT(genom_unkex_id, "::genom::unkex");

typedef struct genom_unkex_detail {
  char what[128]; /* NUL included */
} genom_unkex_detail;

static inline genom_event
genom_unkex(const genom_unkex_detail *detail, genom_context self)
{
  return self->raise(genom_unkex_id, detail, sizeof(*detail), self);
}

/* A system call failed. */
GENOM_EVENT(genom_syserr_id, "::genom::syserr");

typedef struct genom_syserr_detail {
  int32_t code; /* errno */
} genom_syserr_detail;

static inline genom_event
genom_syserr(const genom_syserr_detail *detail, genom_context self)
{
  return self->raise(genom_syserr_id, detail, sizeof(*detail), self);
}

#endif /* GENOM3_C_EXCEPTION_H */
