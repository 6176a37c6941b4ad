/*
 * Memory of unbounded sequences: `struct { uint32_t _maximum, _length; T *_buffer;
 * void (*_release)(void *); }`, all zero when empty.
 */
#ifndef GENOM3_C_IDLSEQUENCE_H
#define GENOM3_C_IDLSEQUENCE_H

/* Included because GenoM3's own header provides errno, and codels rely on it. */
#include <errno.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/*
 * int genom_sequence_reserve(sequence *s, uint32_t n)
 *
 * Resizes the buffer of `s` to exactly `n` elements; 0 frees it. Elements that fit are kept, new
 * ones are zero, and `_length` never grows. Returns 0, or -1 without memory, `s` unchanged.
 * Elements that are cut off are not released: release what they own first.
 */
#define genom_sequence_reserve(s, n) \
  ((void)sizeof((s)->_release), \
   genom_sequence_resize((s), sizeof(*(s)->_buffer), (n)))

/* The part that all unbounded sequences share. */
struct genom_sequence_any {
  uint32_t _maximum, _length;
  void *_buffer;
  void (*_release)(void *buffer);
};

/* Works on a copy: a sequence of T may not be accessed as another struct. */
static inline int
genom_sequence_resize(void *sequence, size_t size, uint32_t n)
{
  struct genom_sequence_any s;
  char *buffer = NULL;

  memcpy(&s, sequence, sizeof(s));
  if (n && size > SIZE_MAX / n) return -1;
  if (s._length > n) s._length = n;

  if (n == 0) {
    if (s._release && s._buffer) s._release(s._buffer);
    memset(&s, 0, sizeof(s));
  } else {
    if (s._release == free) {
      buffer = (char *)realloc(s._buffer, n * size);
      if (!buffer) return -1;
      memset(buffer + s._length * size, 0, (n - s._length) * size);
    } else {
      buffer = (char *)calloc(n, size);
      if (!buffer) return -1;
      if (s._length && s._buffer) memcpy(buffer, s._buffer, s._length * size);
      if (s._release && s._buffer) s._release(s._buffer);
      s._release = free;
    }
    s._buffer = buffer;
    s._maximum = n;
  }

  memcpy(sequence, &s, sizeof(s));
  return 0;
}

#endif /* GENOM3_C_IDLSEQUENCE_H */
