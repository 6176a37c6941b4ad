/* What codels written in C++ do with a header; exits 0 if the types behave. */
#include "h.h"

#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

struct demo_opaque {
  std::vector<double> log;
};

/* An array bound of C++ must be a constant expression. */
static double weights[m_tiny_one < 1 ? 3 : 4];

genom_event
check(int32_t v, int32_t current, const genom_context self)
{
  if (v < current) {
    demo_e_sys_detail d;
    d.code = 1;
    std::snprintf(d.what, sizeof(d.what), "%d below %d", v, current);
    return demo_e_sys(&d, self);
  }
  return v ? genom_ok : demo_e_void(self);
}

genom_event
t_init(demo_ids *ids, const demo_mpin *mpin, const demo_mpout *mpout, const demo_name *name,
       const demo_note *note, const demo_point *point, const demo_matrix *matrix,
       const demo_colour *colour, const demo_shared *shared, genom_context self)
{
  ids->nat = new demo_opaque();
  ids->nat->log.push_back(1.);
  ids->st = {1, nullptr, m_GREEN};
  if (genom_sequence_reserve(&ids->sq, 8)) return demo_e_void(self);
  ids->sq._buffer[ids->sq._length++] = ids->st;
  if (mpin->read("a", self) || !mpin->data("a", self)) return demo_e_void(self);
  mpout->open("b", self);
  ids->bsq = *mpout->data("b", self);
  std::strcpy(name->data(self), "name");
  *note->data(self) = strdup("note");
  point->data(self)[2] = 3.;
  matrix->data(self)[1][2] = 4;
  if (*colour->data(self) == m_RED && shared->data(self)->x) return demo_step;
  return demo_pause_start;
}

int
main()
{
  demo_four a, b;
  a._length = 2;
  a._buffer[0] = 1.;
  a._buffer[1] = 2.;
  b = a;
  demo_four c(a);
  demo_holder h = demo_holder();
  demo_holder *g = new demo_holder(h);
  *g = h;
  sequence3_demo_choice many;
  demo_choice one;
  one._d = m_GREEN;
  one._u.b._length = 1;
  many._buffer[2] = one;
  bool good = b._maximum == 4 && b._length == 2 && b._buffer[1] == 2. && c._buffer[0] == 1. &&
    many._maximum == 3 && many._buffer[2]._u.b._length == 1 && h.twice._maximum == 2 &&
    h.twice._buffer[1]._maximum == 4 && g->strings._maximum == 2 &&
    sizeof(weights) == 3 * sizeof(double) && std::string(demo_start) == "::demo::start" &&
    std::string(demo_pause_start) == "::demo::pause::start" && genom_ok == 0 &&
    std::string(m_name) == "a\n\"b\" \\q" && m_letter == 'x' && m_yes && m_favourite == m_GREEN;
#if __cplusplus >= 201402L
  demo_four e = {4, 1, {3.}};
  b = {4, 2, {1., 2.}};
  good = good && e._length == 1 && e._buffer[0] == 3. && b._buffer[1] == 2.;
#endif
  delete g;
  return good ? 0 : 1;
}
