// SIGTERM and METIS. METIS installs a handler of its own for SIGTERM that longjmps back into the
// call, out of malloc too: a process that is told to end while METIS orders may hang for ever. So
// only the main thread takes SIGTERM, and not while METIS runs.
#pragma once

namespace tremolo {

// Lets this thread take SIGTERM or not; threads that it makes inherit which.
void block_term_signal();
void take_term_signal();

// Holds SIGTERM back in this thread while it lives; one that came is delivered after.
class TermHeldBack {
 public:
  TermHeldBack() { block_term_signal(); }
  ~TermHeldBack() { take_term_signal(); }
  TermHeldBack(const TermHeldBack&) = delete;
  TermHeldBack& operator=(const TermHeldBack&) = delete;
};

}  // namespace tremolo
