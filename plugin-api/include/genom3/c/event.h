/*
 * Events: what a codel returns. An event is the address of its full name, such as "::demo::main".
 *
 * Within one library an event has one address, so codels may compare with ==. Across libraries
 * only the text counts.
 */
#ifndef GENOM3_C_EVENT_H
#define GENOM3_C_EVENT_H

#include <assert.h>
#include <stddef.h>
#include <stdint.h>

typedef const char *genom_event;

/* Every object that includes a component's header defines its events; the linker keeps one. */
#define GENOM_WEAK __attribute__((weak, visibility("default")))

/*
 * GENOM_EVENT(demo_main, "::demo::main") defines the event `demo_main`.
 *
 * A const object has internal linkage in C++ unless declared extern; C warns about an extern
 * that has an initialiser.
 */
#ifdef __cplusplus
# define GENOM_EVENT(symbol, name) \
  extern "C" { extern const char symbol[] GENOM_WEAK; } \
  const char symbol[] = name
#else
# define GENOM_EVENT(symbol, name) \
  extern const char symbol[] GENOM_WEAK; \
  const char symbol[] = name
#endif

#endif /* GENOM3_C_EVENT_H */
