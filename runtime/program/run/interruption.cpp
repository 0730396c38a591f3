#include "runtime/program/run/interruption.h"

#include <csignal>
#include <iterator>

namespace tremolo {
namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};
struct sigaction before[std::size(kSignals)];
volatile std::sig_atomic_t came = 0;

void put_back() {
  for (std::size_t i = 0; i < std::size(kSignals); ++i)
    ::sigaction(kSignals[i], &before[i], nullptr);
}

extern "C" void tremolo_on_interruption(int signal) {
  came = signal;
  put_back();
}

}  // namespace

Interruption::Interruption() {
  came = 0;
  struct sigaction action = {};
  action.sa_handler = tremolo_on_interruption;
  action.sa_flags = SA_RESTART;
  for (const int signal : kSignals) sigaddset(&action.sa_mask, signal);
  for (std::size_t i = 0; i < std::size(kSignals); ++i) {
    ::sigaction(kSignals[i], nullptr, &before[i]);
    // A signal that was ignored before, as under nohup, stays ignored.
    if (before[i].sa_handler != SIG_IGN) ::sigaction(kSignals[i], &action, nullptr);
  }
}

Interruption::~Interruption() {
  put_back();
}

int Interruption::signal() const {
  return came;
}

}  // namespace tremolo
