#ifndef _demo_opaque_c_type
# define _demo_opaque_c_type
typedef struct demo_opaque demo_opaque;
#endif /* _demo_opaque_c_type */

#ifndef _demo_e_sys_c_type
# define _demo_e_sys_c_type
GENOM_EVENT(demo_e_sys_id, "::demo::e_sys");
typedef struct demo_e_sys_detail {
  int16_t code;
  char what[128];
} demo_e_sys_detail;

static inline genom_event
demo_e_sys(const demo_e_sys_detail *detail, genom_context self)
{
  return self->raise(demo_e_sys_id, detail, sizeof(*detail), self);
}
#endif /* _demo_e_sys_c_type */

#ifndef _demo_e_void_c_type
# define _demo_e_void_c_type
GENOM_EVENT(demo_e_void_id, "::demo::e_void");
typedef void demo_e_void_detail;

static inline genom_event
demo_e_void(genom_context self)
{
  return self->raise(demo_e_void_id, NULL, 0, self);
}
#endif /* _demo_e_void_c_type */

#ifndef _demo_arr2_c_type
# define _demo_arr2_c_type
typedef int32_t demo_arr2[2][3];
#endif /* _demo_arr2_c_type */

#ifndef _demo_text_c_type
# define _demo_text_c_type
typedef char *demo_text;
#endif /* _demo_text_c_type */

#ifndef _demo_short_text_c_type
# define _demo_short_text_c_type
typedef char demo_short_text[8];
#endif /* _demo_short_text_c_type */

#ifndef _sequence4_double_c_type
# define _sequence4_double_c_type
struct sequence4_double {
#if defined(__cplusplus) && __cplusplus >= 201402L
  uint32_t _maximum = 4, _length = 0;
#else
  uint32_t _maximum, _length;
#endif
  double _buffer[4];
#if defined(__cplusplus) && __cplusplus < 201402L
  sequence4_double() : _maximum(4), _length(0) {}
#endif
};
#ifndef _sequence4_double_forward_c_type
# define _sequence4_double_forward_c_type
typedef struct sequence4_double sequence4_double;
#endif
#endif /* _sequence4_double_c_type */

#ifndef _demo_four_c_type
# define _demo_four_c_type
typedef sequence4_double demo_four;
#endif /* _demo_four_c_type */

#ifndef _optional_m_t_c_type
# define _optional_m_t_c_type
struct optional_m_t {
  bool _present;
  m_t _value;
};
#ifndef _optional_m_t_forward_c_type
# define _optional_m_t_forward_c_type
typedef struct optional_m_t optional_m_t;
#endif
#endif /* _optional_m_t_c_type */

#ifndef _demo_maybe_c_type
# define _demo_maybe_c_type
typedef optional_m_t demo_maybe;
#endif /* _demo_maybe_c_type */

#ifndef _demo_vector3_c_type
# define _demo_vector3_c_type
typedef double demo_vector3[3];
#endif /* _demo_vector3_c_type */

#ifndef _demo_s_c_type
# define _demo_s_c_type
struct demo_s {
  int32_t a;
  char *b;
  m_col c;
};
#ifndef _demo_s_forward_c_type
# define _demo_s_forward_c_type
typedef struct demo_s demo_s;
#endif
#endif /* _demo_s_c_type */

#ifndef _demo_outer_inner_c_type
# define _demo_outer_inner_c_type
struct demo_outer_inner {
  double d;
  uint8_t o;
};
#ifndef _demo_outer_inner_forward_c_type
# define _demo_outer_inner_forward_c_type
typedef struct demo_outer_inner demo_outer_inner;
#endif
#endif /* _demo_outer_inner_c_type */

#ifndef _optional_long_c_type
# define _optional_long_c_type
struct optional_long {
  bool _present;
  int32_t _value;
};
#ifndef _optional_long_forward_c_type
# define _optional_long_forward_c_type
typedef struct optional_long optional_long;
#endif
#endif /* _optional_long_c_type */

#ifndef _demo_outer_c_type
# define _demo_outer_c_type
struct demo_outer {
  demo_outer_inner x[2];
  optional_long l;
  uint64_t q;
};
#ifndef _demo_outer_forward_c_type
# define _demo_outer_forward_c_type
typedef struct demo_outer demo_outer;
#endif
#endif /* _demo_outer_c_type */

#ifndef _sequence2_m_t_c_type
# define _sequence2_m_t_c_type
struct sequence2_m_t {
#if defined(__cplusplus) && __cplusplus >= 201402L
  uint32_t _maximum = 2, _length = 0;
#else
  uint32_t _maximum, _length;
#endif
  m_t _buffer[2];
#if defined(__cplusplus) && __cplusplus < 201402L
  sequence2_m_t() : _maximum(2), _length(0) {}
#endif
};
#ifndef _sequence2_m_t_forward_c_type
# define _sequence2_m_t_forward_c_type
typedef struct sequence2_m_t sequence2_m_t;
#endif
#endif /* _sequence2_m_t_c_type */

#ifndef _demo_choice_c_type
# define _demo_choice_c_type
struct demo_choice {
  m_col _d;
  union demo_choice_members {
    int32_t a;
    demo_four b;
    sequence2_m_t c;
#ifdef __cplusplus
    demo_choice_members() { memset((void *)this, 0, sizeof(*this)); }
    demo_choice_members(const demo_choice_members &from) { *this = from; }
    demo_choice_members &operator=(const demo_choice_members &from) {
      memcpy((void *)this, (const void *)&from, sizeof(*this));
      return *this;
    }
#endif
  } _u;
};
#ifndef _demo_choice_forward_c_type
# define _demo_choice_forward_c_type
typedef struct demo_choice demo_choice;
#endif
#endif /* _demo_choice_c_type */

#ifndef _demo_flag_c_type
# define _demo_flag_c_type
struct demo_flag {
  bool _d;
  union {
    double d;
    char *t;
  } _u;
};
#ifndef _demo_flag_forward_c_type
# define _demo_flag_forward_c_type
typedef struct demo_flag demo_flag;
#endif
#endif /* _demo_flag_c_type */

#ifndef _sequence3_demo_choice_c_type
# define _sequence3_demo_choice_c_type
struct sequence3_demo_choice {
#if defined(__cplusplus) && __cplusplus >= 201402L
  uint32_t _maximum = 3, _length = 0;
#else
  uint32_t _maximum, _length;
#endif
  demo_choice _buffer[3];
#if defined(__cplusplus) && __cplusplus < 201402L
  sequence3_demo_choice() : _maximum(3), _length(0) {}
#endif
};
#ifndef _sequence3_demo_choice_forward_c_type
# define _sequence3_demo_choice_forward_c_type
typedef struct sequence3_demo_choice sequence3_demo_choice;
#endif
#endif /* _sequence3_demo_choice_c_type */

#ifndef _sequence4_long_c_type
# define _sequence4_long_c_type
struct sequence4_long {
#if defined(__cplusplus) && __cplusplus >= 201402L
  uint32_t _maximum = 4, _length = 0;
#else
  uint32_t _maximum, _length;
#endif
  int32_t _buffer[4];
#if defined(__cplusplus) && __cplusplus < 201402L
  sequence4_long() : _maximum(4), _length(0) {}
#endif
};
#ifndef _sequence4_long_forward_c_type
# define _sequence4_long_forward_c_type
typedef struct sequence4_long sequence4_long;
#endif
#endif /* _sequence4_long_c_type */

#ifndef _sequence2_sequence4_long_c_type
# define _sequence2_sequence4_long_c_type
struct sequence2_sequence4_long {
#if defined(__cplusplus) && __cplusplus >= 201402L
  uint32_t _maximum = 2, _length = 0;
#else
  uint32_t _maximum, _length;
#endif
  sequence4_long _buffer[2];
#if defined(__cplusplus) && __cplusplus < 201402L
  sequence2_sequence4_long() : _maximum(2), _length(0) {}
#endif
};
#ifndef _sequence2_sequence4_long_forward_c_type
# define _sequence2_sequence4_long_forward_c_type
typedef struct sequence2_sequence4_long sequence2_sequence4_long;
#endif
#endif /* _sequence2_sequence4_long_c_type */

#ifndef _sequence2_string4_c_type
# define _sequence2_string4_c_type
struct sequence2_string4 {
#if defined(__cplusplus) && __cplusplus >= 201402L
  uint32_t _maximum = 2, _length = 0;
#else
  uint32_t _maximum, _length;
#endif
  char _buffer[2][4];
#if defined(__cplusplus) && __cplusplus < 201402L
  sequence2_string4() : _maximum(2), _length(0) {}
#endif
};
#ifndef _sequence2_string4_forward_c_type
# define _sequence2_string4_forward_c_type
typedef struct sequence2_string4 sequence2_string4;
#endif
#endif /* _sequence2_string4_c_type */

#ifndef _sequence_string_c_type
# define _sequence_string_c_type
struct sequence_string {
  uint32_t _maximum, _length;
  char **_buffer;
  void (*_release)(void *_buffer);
};
#ifndef _sequence_string_forward_c_type
# define _sequence_string_forward_c_type
typedef struct sequence_string sequence_string;
#endif
#endif /* _sequence_string_c_type */

#ifndef _demo_s_forward_c_type
# define _demo_s_forward_c_type
typedef struct demo_s demo_s;
#endif /* _demo_s_forward_c_type */

#ifndef _sequence_demo_s_c_type
# define _sequence_demo_s_c_type
struct sequence_demo_s {
  uint32_t _maximum, _length;
  demo_s *_buffer;
  void (*_release)(void *_buffer);
};
#ifndef _sequence_demo_s_forward_c_type
# define _sequence_demo_s_forward_c_type
typedef struct sequence_demo_s sequence_demo_s;
#endif
#endif /* _sequence_demo_s_c_type */

#ifndef _optional_sequence_demo_s_c_type
# define _optional_sequence_demo_s_c_type
struct optional_sequence_demo_s {
  bool _present;
  sequence_demo_s _value;
};
#ifndef _optional_sequence_demo_s_forward_c_type
# define _optional_sequence_demo_s_forward_c_type
typedef struct optional_sequence_demo_s optional_sequence_demo_s;
#endif
#endif /* _optional_sequence_demo_s_c_type */

#ifndef _sequence_optional_long_c_type
# define _sequence_optional_long_c_type
struct sequence_optional_long {
  uint32_t _maximum, _length;
  optional_long *_buffer;
  void (*_release)(void *_buffer);
};
#ifndef _sequence_optional_long_forward_c_type
# define _sequence_optional_long_forward_c_type
typedef struct sequence_optional_long sequence_optional_long;
#endif
#endif /* _sequence_optional_long_c_type */

#ifndef _sequence2_demo_arr2_c_type
# define _sequence2_demo_arr2_c_type
struct sequence2_demo_arr2 {
#if defined(__cplusplus) && __cplusplus >= 201402L
  uint32_t _maximum = 2, _length = 0;
#else
  uint32_t _maximum, _length;
#endif
  demo_arr2 _buffer[2];
#if defined(__cplusplus) && __cplusplus < 201402L
  sequence2_demo_arr2() : _maximum(2), _length(0) {}
#endif
};
#ifndef _sequence2_demo_arr2_forward_c_type
# define _sequence2_demo_arr2_forward_c_type
typedef struct sequence2_demo_arr2 sequence2_demo_arr2;
#endif
#endif /* _sequence2_demo_arr2_c_type */

#ifndef _demo_holder_c_type
# define _demo_holder_c_type
struct demo_holder {
  demo_choice which[2];
  demo_flag other;
  sequence3_demo_choice many;
  sequence2_sequence4_long twice;
  sequence2_string4 strings;
  sequence_string texts;
  optional_sequence_demo_s perhaps;
  sequence_optional_long some;
  sequence2_demo_arr2 arrays;
  demo_e_sys_detail error;
  int32_t first[2][3];
  int32_t second;
  int16_t sh;
  uint16_t us;
  uint32_t ul;
  int64_t ll;
  float f;
  bool flags[5];
  demo_opaque *hidden;
};
#ifndef _demo_holder_forward_c_type
# define _demo_holder_forward_c_type
typedef struct demo_holder demo_holder;
#endif
#endif /* _demo_holder_c_type */

#ifndef _demo_ids_deep_deeper_c_type
# define _demo_ids_deep_deeper_c_type
struct demo_ids_deep_deeper {
  int32_t c;
  int32_t d;
};
#ifndef _demo_ids_deep_deeper_forward_c_type
# define _demo_ids_deep_deeper_forward_c_type
typedef struct demo_ids_deep_deeper demo_ids_deep_deeper;
#endif
#endif /* _demo_ids_deep_deeper_c_type */

#ifndef _demo_ids_deep_c_type
# define _demo_ids_deep_c_type
struct demo_ids_deep {
  demo_ids_deep_deeper x;
};
#ifndef _demo_ids_deep_forward_c_type
# define _demo_ids_deep_forward_c_type
typedef struct demo_ids_deep demo_ids_deep;
#endif
#endif /* _demo_ids_deep_c_type */

#ifndef _demo_ids_c_type
# define _demo_ids_c_type
struct demo_ids {
  int32_t v;
  demo_s st;
  demo_opaque *nat;
  char *us;
  sequence_demo_s sq;
  demo_four bsq;
  demo_holder hold;
  demo_arr2 arr;
  int32_t fresh;
  demo_ids_deep b[3];
};
#ifndef _demo_ids_forward_c_type
# define _demo_ids_forward_c_type
typedef struct demo_ids demo_ids;
#endif
#endif /* _demo_ids_c_type */

#ifndef _sequence_long_c_type
# define _sequence_long_c_type
struct sequence_long {
  uint32_t _maximum, _length;
  int32_t *_buffer;
  void (*_release)(void *_buffer);
};
#ifndef _sequence_long_forward_c_type
# define _sequence_long_forward_c_type
typedef struct sequence_long sequence_long;
#endif
#endif /* _sequence_long_c_type */

#ifndef _m_depth_c_type
# define _m_depth_c_type
static const int32_t m_depth = -2147483648;
#endif /* _m_depth_c_type */

#ifndef _m_big_c_type
# define _m_big_c_type
static const uint64_t m_big = 18446744073709551615ULL;
#endif /* _m_big_c_type */

#ifndef _m_cut_c_type
# define _m_cut_c_type
static const uint8_t m_cut = 44;
#endif /* _m_cut_c_type */

#ifndef _m_yes_c_type
# define _m_yes_c_type
static const bool m_yes = true;
#endif /* _m_yes_c_type */

#ifndef _m_letter_c_type
# define _m_letter_c_type
static const int8_t m_letter = 120;
#endif /* _m_letter_c_type */

#ifndef _m_name_c_type
# define _m_name_c_type
static const char *const m_name = "a\n\"b\" \\q";
#endif /* _m_name_c_type */

#ifndef _m_tiny_c_type
# define _m_tiny_c_type
static const char m_tiny[4] = "abc";
#endif /* _m_tiny_c_type */

#ifndef _m_ratio_c_type
# define _m_ratio_c_type
static const float m_ratio = 1.5;
#endif /* _m_ratio_c_type */

#ifndef _m_tiny_one_c_type
# define _m_tiny_one_c_type
static const double m_tiny_one = 1e-300;
#endif /* _m_tiny_one_c_type */

#ifndef _m_favourite_c_type
# define _m_favourite_c_type
static const m_col m_favourite = m_GREEN;
#endif /* _m_favourite_c_type */

#ifndef _demo_ether_c_type
# define _demo_ether_c_type
GENOM_EVENT(demo_ether, "::demo::ether");
#endif /* _demo_ether_c_type */

#ifndef _demo_start_c_type
# define _demo_start_c_type
GENOM_EVENT(demo_start, "::demo::start");
#endif /* _demo_start_c_type */

#ifndef _demo_stop_c_type
# define _demo_stop_c_type
GENOM_EVENT(demo_stop, "::demo::stop");
#endif /* _demo_stop_c_type */

#ifndef _demo_step_c_type
# define _demo_step_c_type
GENOM_EVENT(demo_step, "::demo::step");
#endif /* _demo_step_c_type */

#ifndef _demo_pause_start_c_type
# define _demo_pause_start_c_type
GENOM_EVENT(demo_pause_start, "::demo::pause::start");
#endif /* _demo_pause_start_c_type */

#ifndef _demo_genom_state_c_type
# define _demo_genom_state_c_type
typedef struct demo_genom_state {
  genom_state_component *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} demo_genom_state;
#endif /* _demo_genom_state_c_type */

#ifndef _demo_shared_c_type
# define _demo_shared_c_type
typedef struct demo_shared {
  i_param *(*data)(genom_context self);
  genom_event (*read)(genom_context self);
} demo_shared;
#endif /* _demo_shared_c_type */

#ifndef _demo_pin_c_type
# define _demo_pin_c_type
typedef struct demo_pin {
  demo_s *(*data)(genom_context self);
  genom_event (*read)(genom_context self);
} demo_pin;
#endif /* _demo_pin_c_type */

#ifndef _demo_pout_c_type
# define _demo_pout_c_type
typedef struct demo_pout {
  demo_s *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} demo_pout;
#endif /* _demo_pout_c_type */

#ifndef _demo_mpin_c_type
# define _demo_mpin_c_type
typedef struct demo_mpin {
  demo_s *(*data)(const char *id, genom_context self);
  genom_event (*read)(const char *id, genom_context self);
} demo_mpin;
#endif /* _demo_mpin_c_type */

#ifndef _demo_mpout_c_type
# define _demo_mpout_c_type
typedef struct demo_mpout {
  demo_four *(*data)(const char *id, genom_context self);
  genom_event (*write)(const char *id, genom_context self);
  genom_event (*open)(const char *id, genom_context self);
  genom_event (*close)(const char *id, genom_context self);
} demo_mpout;
#endif /* _demo_mpout_c_type */

#ifndef _demo_name_c_type
# define _demo_name_c_type
typedef struct demo_name {
  char *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} demo_name;
#endif /* _demo_name_c_type */

#ifndef _demo_note_c_type
# define _demo_note_c_type
typedef struct demo_note {
  demo_text *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} demo_note;
#endif /* _demo_note_c_type */

#ifndef _demo_point_c_type
# define _demo_point_c_type
typedef struct demo_point {
  double *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} demo_point;
#endif /* _demo_point_c_type */

#ifndef _demo_matrix_c_type
# define _demo_matrix_c_type
typedef struct demo_matrix {
  int32_t (*(*data)(genom_context self))[3];
  genom_event (*write)(genom_context self);
} demo_matrix;
#endif /* _demo_matrix_c_type */

#ifndef _demo_colour_c_type
# define _demo_colour_c_type
typedef struct demo_colour {
  m_col *(*data)(genom_context self);
  genom_event (*read)(genom_context self);
} demo_colour;
#endif /* _demo_colour_c_type */

#ifndef _demo_r1_c_type
# define _demo_r1_c_type
typedef struct demo_r1 {
  genom_event (*call)(i_long_type a, i_param b[3], char **d, genom_context self);
} demo_r1;
#endif /* _demo_r1_c_type */

/* Codels of demo. */
genom_event t_init(demo_ids *ids, const demo_mpin *mpin, const demo_mpout *mpout, const demo_name *name, const demo_note *note, const demo_point *point, const demo_matrix *matrix, const demo_colour *colour, const demo_shared *shared, const genom_context self);
genom_event t_step(const demo_r1 *r1, const genom_context self);
genom_event check(int32_t v, int32_t current, const genom_context self);
genom_event fc(const char *d, const char e[8], char g[8], char **c, const demo_s *h, demo_s *i, const sequence_long *j, sequence_long *k, const demo_arr2 l, demo_arr2 m, m_col n, m_col *o, bool p, const optional_long *q, const demo_e_sys_detail *r, const demo_text t, demo_text *u, uint64_t w, float x, demo_flag *y, const demo_opaque *lo, demo_opaque **lo2, const genom_context self);
genom_event fc2(const char *stb, int32_t sqa, demo_four *bsq, const demo_opaque *nat, demo_opaque **nat2, int32_t class_, int32_t input, int32_t *inout, demo_ids *all, const genom_context self);
genom_event act_start(int32_t x, int32_t *y, int32_t *z, const demo_pin *pin, const demo_pout *pout, const genom_context self);
genom_event act_step(int32_t a, int32_t self_, const genom_context self);
genom_event act_stop(int32_t z, const genom_context self);

#ifdef __cplusplus
}
#endif

#endif /* H_DEMO_C_TYPES */
