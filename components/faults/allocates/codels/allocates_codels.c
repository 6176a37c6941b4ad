/*
 * Codels of allocates.
 */
#include <stdio.h>

#include "genom3/c/exception.h"
#include "genom3/c/idlsequence.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("allocates.gen");

GENOM_EVENT(allocates_ether, "::allocates::ether");
GENOM_EVENT(allocates_publishing, "::allocates::publishing");
GENOM_EVENT(allocates_pause_publishing, "::allocates::pause::publishing");

#define SEQUENCE(tag, type) \
  typedef struct tag { \
    uint32_t _maximum, _length; \
    type *_buffer; \
    void (*_release)(void *_buffer); \
  } tag

SEQUENCE(sequence_octet, uint8_t);
SEQUENCE(sequence_double, double);
SEQUENCE(sequence_long, int32_t);

typedef struct allocates_item {
  char *name;
  sequence_octet data;
} allocates_item;

SEQUENCE(sequence_allocates_item, allocates_item);

typedef struct allocates_latest {
  allocates_item *(*data)(genom_context self);
  genom_event (*write)(genom_context self);
} allocates_latest;

genom_event allocates_text(uint32_t length, char **text, const genom_context self);
genom_event allocates_numbers(uint32_t count, sequence_double *values, const genom_context self);
genom_event allocates_borrowed(sequence_long *values, const genom_context self);
genom_event allocates_owned(uint32_t count, sequence_long *values, const genom_context self);
genom_event allocates_nested(uint32_t count, sequence_allocates_item *items,
                             const genom_context self);
genom_event allocates_balance(int32_t *buffers, const genom_context self);
genom_event allocates_leak(uint32_t bytes, const genom_context self);
genom_event allocates_begin(uint32_t *done, const genom_context self);
genom_event allocates_publish(uint32_t times, uint32_t *done, const allocates_latest *latest,
                              const genom_context self);
genom_event allocates_end(const genom_context self);

/* Buffers given out with `give_back` and not given back. */
static int held;

static void
give_back(void *buffer)
{
  __atomic_sub_fetch(&held, 1, __ATOMIC_RELAXED);
  free(buffer);
}

static genom_event
no_memory(genom_context self)
{
  genom_unkex_detail detail = { "no memory" };

  return genom_unkex(&detail, self);
}

/* Fills an item in place: what it held is released or used again. */
static int
fill(allocates_item *item, uint32_t size)
{
  char name[32];
  char *copy;
  uint32_t i;

  snprintf(name, sizeof(name), "item of %u bytes", (unsigned)size);
  copy = (char *)realloc(item->name, strlen(name) + 1);
  if (!copy) return -1;
  item->name = strcpy(copy, name);
  if (genom_sequence_reserve(&item->data, size)) return -1;
  for (i = 0; i < size; i++) item->data._buffer[i] = (uint8_t)i;
  item->data._length = size;
  return 0;
}

genom_event
allocates_text(uint32_t length, char **text, const genom_context self)
{
  char *fresh = (char *)malloc((size_t)length + 1);

  if (!fresh) return no_memory(self);
  memset(fresh, 'x', length);
  fresh[length] = '\0';
  free(*text);
  *text = fresh;
  return genom_ok;
}

genom_event
allocates_numbers(uint32_t count, sequence_double *values, const genom_context self)
{
  uint32_t i;

  if (genom_sequence_reserve(values, count)) return no_memory(self);
  for (i = 0; i < count; i++) values->_buffer[i] = i;
  values->_length = count;
  return genom_ok;
}

genom_event
allocates_borrowed(sequence_long *values, const genom_context self)
{
  static int32_t numbers[] = { 1, 2, 3, 5, 8 };

  (void)self;
  if (values->_release) values->_release(values->_buffer);
  values->_maximum = values->_length = sizeof(numbers) / sizeof(*numbers);
  values->_buffer = numbers;
  values->_release = NULL;
  return genom_ok;
}

genom_event
allocates_owned(uint32_t count, sequence_long *values, const genom_context self)
{
  int32_t *buffer = (int32_t *)calloc(count ? count : 1, sizeof(*buffer));

  if (!buffer) return no_memory(self);
  if (values->_release) values->_release(values->_buffer);
  __atomic_add_fetch(&held, 1, __ATOMIC_RELAXED);
  values->_maximum = values->_length = count;
  values->_buffer = buffer;
  values->_release = give_back;
  return genom_ok;
}

genom_event
allocates_nested(uint32_t count, sequence_allocates_item *items, const genom_context self)
{
  uint32_t i;

  for (i = count; i < items->_length; i++) {
    free(items->_buffer[i].name);
    genom_sequence_reserve(&items->_buffer[i].data, 0);
  }
  if (genom_sequence_reserve(items, count)) return no_memory(self);
  items->_length = count;
  for (i = 0; i < count; i++) {
    if (fill(&items->_buffer[i], i)) return no_memory(self);
  }
  return genom_ok;
}

genom_event
allocates_balance(int32_t *buffers, const genom_context self)
{
  (void)self;
  *buffers = __atomic_load_n(&held, __ATOMIC_RELAXED);
  return genom_ok;
}

genom_event
allocates_leak(uint32_t bytes, const genom_context self)
{
  /* Written, so that the system counts it; volatile, so that the compiler keeps it. */
  volatile char *forgotten = (volatile char *)malloc(bytes);
  uint32_t i;

  if (!forgotten) return no_memory(self);
  for (i = 0; i < bytes; i++) forgotten[i] = 1;
  return genom_ok;
}

genom_event
allocates_begin(uint32_t *done, const genom_context self)
{
  (void)self;
  *done = 0;
  return allocates_publishing;
}

genom_event
allocates_publish(uint32_t times, uint32_t *done, const allocates_latest *latest,
                  const genom_context self)
{
  allocates_item *item = latest->data(self);
  genom_event e;

  if (!item || fill(item, *done % 64)) return no_memory(self);
  e = latest->write(self);
  if (e != genom_ok) return e;
  return ++*done < times ? allocates_pause_publishing : allocates_ether;
}

genom_event
allocates_end(const genom_context self)
{
  (void)self;
  return allocates_ether;
}
