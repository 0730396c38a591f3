// Ctrl-C and its like during a run: the run ends early, but what it has made so far is written.
#pragma once

namespace tremolo {

// While one of these lives, the first SIGINT, SIGTERM or SIGHUP is remembered and does nothing
// else. A second one finds what stood there before (formats/file/atomic_file.h): the program ends
// at once. One at a time; for programs.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  // The signal that came; 0: none.
  int signal() const;
};

}  // namespace tremolo
