#include "formats/file/standard_streams.h"

#include <cstdio>
#include <fcntl.h>

namespace tremolo {

void hold_standard_streams() {
  for (int stream = 0; stream < 3; ++stream) {
    if (::fcntl(stream, F_GETFD) >= 0) continue;
    // The lowest free number is this one: those below are open.
    if (::open("/dev/null", stream == 0 ? O_WRONLY : O_RDONLY) < 0) return;
  }
}

Status flush_standard_output() {
  const bool streamed = bool(std::cout.flush());
  if (std::fflush(stdout) == 0 && streamed) return Success{};
  return system_error("standard output cannot be written");
}

}  // namespace tremolo
