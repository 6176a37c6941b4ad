/*
 * Events of codels in C++: what a codel of a lang "c++" component returns. An event is the
 * address of its full name, such as "::demo::main".
 */
#ifndef GENOM3_CXX_EVENT_H
#define GENOM3_CXX_EVENT_H

/* Every object that includes a component's header defines its events; the linker keeps one. */
#define GENOM_CXX_WEAK __attribute__((weak, visibility("default")))

/* GENOM_CXX_EVENT(main, "::demo::main") defines event `main` of the enclosing namespace. */
#define GENOM_CXX_EVENT(symbol, name) \
  extern const char symbol[] GENOM_CXX_WEAK; \
  const char symbol[] = name

namespace genom {

typedef const char *event;

/* Success of a function's or validation codel. */
static const event ok = 0;

GENOM_CXX_EVENT(fatal, "::genom::fatal");

}

#endif /* GENOM3_CXX_EVENT_H */
