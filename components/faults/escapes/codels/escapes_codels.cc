/*
 * Codels of escapes.
 */
#include <memory>
#include <stdexcept>
#include <string>

#include "genom3/c/exception.h"

#include "genom/describe.h"

GENOM_DESCRIPTION("escapes.gen");

GENOM_EVENT(escapes_ether, "::escapes::ether");
GENOM_EVENT(escapes_running, "::escapes::running");
GENOM_EVENT(escapes_pause_running, "::escapes::pause::running");

/* The native type: the host only sees a pointer to it. */
struct escapes_engine {
  uint32_t revolutions = 0;
  std::string state = "cold";
};

/* Destructors run while the exception leaves the codel. */
struct Guard {
  escapes_engine *engine;
  ~Guard() { engine->state = "safe"; }
};

extern "C" {

genom_event
escapes_build(escapes_engine **engine, const genom_context)
{
  *engine = new escapes_engine;
  return escapes_ether;
}

genom_event
escapes_destroy(escapes_engine **engine, const genom_context)
{
  delete *engine;
  *engine = nullptr;
  return escapes_ether;
}

genom_event
escapes_fail(const genom_context)
{
  throw std::runtime_error("the motor is on fire");
}

genom_event
escapes_strange(const genom_context)
{
  throw 42;
}

genom_event
escapes_begin(uint32_t *done, const genom_context)
{
  *done = 0;
  return escapes_running;
}

genom_event
escapes_run(uint32_t after, uint32_t *done, const escapes_engine *engine, const genom_context)
{
  /* The mapping gives natives as const; codels in the field cast it away. */
  auto *turning = const_cast<escapes_engine *>(engine);
  Guard guard{turning};

  turning->revolutions++;
  if (++*done > after) {
    throw std::runtime_error("stalled after " + std::to_string(after) + " periods");
  }
  return escapes_pause_running;
}

genom_event
escapes_end(const genom_context)
{
  return escapes_ether;
}

genom_event
escapes_revolutions(const escapes_engine *engine, uint32_t *revolutions, const genom_context)
{
  *revolutions = engine ? engine->revolutions : 0;
  return genom_ok;
}

} /* extern "C" */
