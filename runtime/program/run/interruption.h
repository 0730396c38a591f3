// A signal during a run ends the run early; the results up to then are still written.
#pragma once

namespace tremolo {

// While an object exists, the first SIGINT, SIGTERM or SIGHUP is stored and has no other effect. A
// second one is handled as before (formats/file/atomic_file.h): the program ends at once. There may
// be one object at a time, in programs only.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  // The number of the signal that was received; 0: none.
  int signal() const;
};

}  // namespace tremolo
