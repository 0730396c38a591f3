#include "runtime/apps/tremolo/output/run_progress.h"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <iterator>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>

#include "runtime/apps/tremolo/output/tell.h"

namespace tremolo {
namespace {

constexpr double kFirstOnTerminal = 1.0, kNextOnTerminal = 0.5;  // s
constexpr double kFirstLine = 10.0, kNextLine = 30.0;

std::string duration_text(double seconds) {
  if (seconds < 100) return fmt::format("{:.0f} s", seconds);
  if (seconds < 6000) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

}  // namespace

RunProgress::RunProgress(std::string name, double duration, bool terminal)
    : name_(std::move(name)),
      duration_(duration),
      terminal_(terminal),
      next_(terminal ? kFirstOnTerminal : kFirstLine) {}

std::string RunProgress::due(double seconds, double reached) {
  if (seconds < next_ || !(reached > 0)) return {};
  next_ = seconds + (terminal_ ? kNextOnTerminal : kNextLine);
  const double left = seconds * std::max(duration_ - reached, 0.0) / reached;
  std::string text =
      fmt::format("  {}: {:.0f} %, {:.4g} of {:.4g} s, about {} left", name_,
                  100 * reached / duration_, reached, duration_, duration_text(left));
  if (!terminal_) return text + "\n";
  const std::size_t length = text.size();
  if (length < shown_) text.append(shown_ - length, ' ');
  shown_ = length;
  return text + "\r";
}

std::string RunProgress::end() {
  if (shown_ == 0) return {};
  return std::string(std::exchange(shown_, 0), ' ') + "\r";
}

ToldProgress::ToldProgress(std::string name, double duration)
    : progress_(std::move(name), duration, ::isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()) {}

ToldProgress::~ToldProgress() {
  tell("{}", progress_.end());
}

void ToldProgress::reached(double time) {
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start_;
  const std::string text = progress_.due(spent.count(), time);
  if (!text.empty()) tell("{}", text);
}

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
