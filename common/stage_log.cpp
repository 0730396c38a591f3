#include "common/stage_log.h"

#include <cstdio>
#include <fstream>
#include <sys/resource.h>
#include <unistd.h>

namespace tremolo {
namespace {

// Lets the kernel's high-water mark start anew; where that is not allowed the mark is the
// process's.
void reset_peak() {
  std::ofstream clear("/proc/self/clear_refs");
  clear << "5\n";
}

std::uint64_t peak_resident_bytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::stoull(line.substr(6)) * 1024u;
  struct rusage usage = {};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024u;
}

}  // namespace

void StageLog::begin(std::string name) {
  current_ = std::move(name);
  if (!quiet_ && ::isatty(STDERR_FILENO)) std::fprintf(stderr, "  %-12s ...\r", current_.c_str());
  reset_peak();
  start_ = std::chrono::steady_clock::now();
}

void StageLog::end(std::string detail) {
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
  records_.push_back({current_, elapsed.count(), peak_resident_bytes(), std::move(detail)});
  if (quiet_) return;
  const StageRecord& record = records_.back();
  std::fprintf(stderr, "  %-12s %7.2f s %6.0f MB  %s\n", record.name.c_str(), record.seconds,
               static_cast<double>(record.peak_bytes) / 1e6, record.detail.c_str());
}

void StageLog::note(const std::string& text) const {
  if (!quiet_) std::fprintf(stderr, "  %s\n", text.c_str());
}

}  // namespace tremolo
