// Protection of METIS against SIGTERM. METIS installs its own handler, which longjmps back into the
// call, even out of malloc: a process that receives SIGTERM meanwhile may hang for ever. So only
// the main thread handles SIGTERM, and not while METIS runs.
#pragma once

namespace tremolo {

// Block or unblock SIGTERM in this thread; threads that it creates inherit the setting.
void block_term_signal();
void take_term_signal();

// Blocks SIGTERM in this thread for its lifetime; a pending signal is delivered afterwards.
class TermHeldBack {
 public:
  TermHeldBack() { block_term_signal(); }
  ~TermHeldBack() { take_term_signal(); }
  TermHeldBack(const TermHeldBack&) = delete;
  TermHeldBack& operator=(const TermHeldBack&) = delete;
};

}  // namespace tremolo
