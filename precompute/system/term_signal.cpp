#include "precompute/system/term_signal.h"

#include <csignal>

namespace tremolo {
namespace {

void set_term(int how) {
  sigset_t term;
  sigemptyset(&term);
  sigaddset(&term, SIGTERM);
  pthread_sigmask(how, &term, nullptr);
}

}  // namespace

void block_term_signal() {
  set_term(SIG_BLOCK);
}

void take_term_signal() {
  set_term(SIG_UNBLOCK);
}

}  // namespace tremolo
