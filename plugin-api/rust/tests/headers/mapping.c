/*
 * Every header of plugin-api in one source, C and C++, with the layouts of the SDK's tests.
 */
#include "genom3/c/context.h"
#include "genom3/c/event.h"
#include "genom3/c/exception.h"
#include "genom3/c/idlsequence.h"

#include "genom/describe.h"

/* Twice: the guards hold. */
#include "genom3/c/exception.h"
#include "genom3/c/idlsequence.h"

#include <stdbool.h>
#include <stddef.h>

GENOM_DESCRIPTION("tank.gen");

GENOM_EVENT(m_start, "::m::start");

typedef struct m_all m_all;

typedef struct optional_float {
  bool _present;
  float _value;
} optional_float;

typedef struct sequence4_double {
  uint32_t _maximum;
  uint32_t _length;
  double _buffer[4];
} sequence4_double;

typedef struct sequence_m_all {
  uint32_t _maximum, _length;
  m_all *_buffer;
  void (*_release)(void *buffer);
} sequence_m_all;

struct m_all {
  int32_t a;
  char b[8];
  bool c;
  uint32_t type;
  char *text;
  optional_float optional;
  int16_t grid[2][3];
  sequence4_double points;
  sequence_m_all children;
};

typedef struct m_e_sys_detail {
  int16_t code;
  char what[128];
} m_e_sys_detail;

/* An array of negative length where the condition is false, in any C and C++. */
#define HOLDS(name, condition) typedef char holds_##name[(condition) ? 1 : -1] __attribute__((unused))
HOLDS(a, offsetof(m_all, a) == 0);
HOLDS(b, offsetof(m_all, b) == 4);
HOLDS(c, offsetof(m_all, c) == 12);
HOLDS(type, offsetof(m_all, type) == 16);
HOLDS(text, offsetof(m_all, text) == 24);
HOLDS(optional, offsetof(m_all, optional) == 32);
HOLDS(grid, offsetof(m_all, grid) == 40);
HOLDS(points, offsetof(m_all, points) == 56);
HOLDS(children, offsetof(m_all, children) == 96);
HOLDS(all, sizeof(m_all) == 120);
HOLDS(e_sys, sizeof(m_e_sys_detail) == 130);
HOLDS(context, sizeof(struct genom_context_iface) == 24);
HOLDS(unkex, sizeof(genom_unkex_detail) == 128);
HOLDS(syserr, sizeof(genom_syserr_detail) == 4);

#ifdef __cplusplus
extern "C" {
#endif
genom_event fails(int32_t code, const genom_context self);
genom_event starts(const genom_context self);
int grows(void);
#ifdef __cplusplus
}
#endif

genom_event
fails(int32_t code, const genom_context self)
{
  genom_syserr_detail detail;

  detail.code = code;
  return code ? genom_syserr(&detail, self) : genom_ok;
}

genom_event
starts(const genom_context self)
{
  (void)self;
  return m_start;
}

/* Returns the number of the first expectation that fails, 0 when all hold. */
static int released;

static void
release(void *buffer)
{
  (void)buffer;
  released++;
}

typedef struct sequence_long {
  uint32_t _maximum, _length;
  int32_t *_buffer;
  void (*_release)(void *buffer);
} sequence_long;

int
grows(void)
{
  static int32_t borrowed[] = { 1, 2, 3 };
  sequence_long s = { 3, 3, borrowed, release };

  released = 0;
  /* A foreign buffer is copied and handed back. */
  if (genom_sequence_reserve(&s, 5)) return 1;
  if (released != 1 || s._release != free || s._buffer == borrowed) return 2;
  if (s._maximum != 5 || s._length != 3) return 3;
  if (s._buffer[0] != 1 || s._buffer[2] != 3 || s._buffer[3] || s._buffer[4]) return 4;
  /* Ours is resized; what is beyond the length is zero, whatever was there. */
  s._buffer[4] = 9;
  if (genom_sequence_reserve(&s, 2000)) return 5;
  if (s._maximum != 2000 || s._length != 3 || s._buffer[4] || s._buffer[1999]) return 6;
  if (genom_sequence_reserve(&s, 2)) return 7;
  if (s._maximum != 2 || s._length != 2 || s._buffer[1] != 2) return 8;
  if (genom_sequence_reserve(&s, 0)) return 9;
  if (s._maximum || s._length || s._buffer || s._release) return 10;
  return 0;
}
