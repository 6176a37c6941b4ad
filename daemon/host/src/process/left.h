// How codels that leave their thread or process by a function of the C library come back to the
// host: these functions throw it (stand_ins.cc), the guard around each codel catches it (guard.cc).

#ifndef GENOM_HOST_LEFT_H
#define GENOM_HOST_LEFT_H

namespace genom_host {
  struct left {
    const char *how;  // in words
  };
}

#endif
