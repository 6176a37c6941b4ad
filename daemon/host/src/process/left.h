// Thrown when a codel calls a function of the C library that would end its thread (stand_ins.cc);
// caught by the guard around each codel (guard.cc).

#ifndef GENOM_HOST_LEFT_H
#define GENOM_HOST_LEFT_H

namespace genom_host {
  struct left {
    const char *how;  // what it called, for the message of the exception
  };
}

#endif
