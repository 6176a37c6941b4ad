/*
 * Codels of strays.
 */
#include <errno.h>

#include "genom3/c/exception.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("strays.gen");

GENOM_EVENT(strays_ether, "::strays::ether");
GENOM_EVENT(strays_other, "::strays::other");
GENOM_EVENT(strays_nowhere, "::strays::nowhere");
GENOM_EVENT(strays_DECLARED_id, "::strays::DECLARED");
GENOM_EVENT(strays_UNDECLARED_id, "::strays::UNDECLARED");

typedef struct strays_DECLARED_detail {
  int32_t code;
  char what[16];
} strays_DECLARED_detail;

typedef struct strays_UNDECLARED_detail {
  int32_t code;
} strays_UNDECLARED_detail;

#define CODEL(name) \
  genom_event name(const genom_context self); \
  genom_event name(const genom_context self)

static genom_event
throw_declared(int32_t code, genom_context self)
{
  strays_DECLARED_detail detail = { code, "as declared" };

  return self->raise(strays_DECLARED_id, &detail, sizeof(detail), self);
}

static genom_event
throw_undeclared(genom_context self)
{
  strays_UNDECLARED_detail detail = { 7 };

  return self->raise(strays_UNDECLARED_id, &detail, sizeof(detail), self);
}

CODEL(strays_unknown) { (void)self; return strays_nowhere; }
CODEL(strays_nothing) { (void)self; return genom_ok; }
CODEL(strays_elsewhere) { (void)self; return strays_other; }
CODEL(strays_do_next) { (void)self; return strays_ether; }
CODEL(strays_do_other) { (void)self; return strays_ether; }
CODEL(strays_do_stop) { (void)self; return strays_ether; }
CODEL(strays_undeclared) { return throw_undeclared(self); }
CODEL(strays_declared) { return throw_declared(42, self); }
CODEL(strays_unraised) { (void)self; return strays_DECLARED_id; }
CODEL(strays_undeclared_function) { return throw_undeclared(self); }
CODEL(strays_second) { return throw_declared(2, self); }
CODEL(strays_validate) { (void)self; return strays_nowhere; }

CODEL(strays_system_error)
{
  genom_syserr_detail detail = { EBUSY };

  return genom_syserr(&detail, self);
}

genom_event strays_first(int32_t *first, const genom_context self);
genom_event strays_third(int32_t *first, const genom_context self);

genom_event
strays_first(int32_t *first, const genom_context self)
{
  (void)self;
  *first = 1;
  return genom_ok;
}

genom_event
strays_third(int32_t *first, const genom_context self)
{
  (void)self;
  *first = 3;
  return genom_ok;
}
