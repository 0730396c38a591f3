#include "common/stage_log.h"

#include <cstdio>
#include <fstream>
#include <sys/resource.h>
#include <unistd.h>

#include "common/text.h"

namespace tremolo {
namespace {

// Resets the kernel's high-water mark; if that is not allowed the mark is the process's.
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
  return usage.ru_maxrss * 1024u;
}

// Of this process and of the children that it has waited for, as the mesher is one.
double processor_seconds() {
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  double sum = 0.0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    struct rusage usage = {};
    ::getrusage(who, &usage);
    sum += seconds(usage.ru_utime) + seconds(usage.ru_stime);
  }
  return sum;
}

}  // namespace

void StageLog::begin(std::string name) {
  current_ = std::move(name);
  if (!quiet_ && ::isatty(STDERR_FILENO)) std::fprintf(stderr, "  %-12s ...\r", current_.c_str());
  reset_peak();
  limit_seconds_ = 0;
  limit_reason_.clear();
  cpu_start_ = processor_seconds();
  start_ = std::chrono::steady_clock::now();
}

void StageLog::limit(double seconds, std::string reason) {
  limit_seconds_ = seconds;
  limit_reason_ = std::move(reason);
}

void StageLog::end(std::string detail) {
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
  records_.push_back({current_, elapsed.count(), processor_seconds() - cpu_start_,
                      peak_resident_bytes(), std::move(detail), limit_seconds_, limit_reason_});
  if (quiet_) return;
  const StageRecord& record = records_.back();
  std::fprintf(stderr, "  %-12s %7.2f s %7.2f s cpu %6.0f MB  %s\n", record.name.c_str(),
               record.seconds, record.cpu_seconds, static_cast<double>(record.peak_bytes) / 1e6,
               printable(record.detail).c_str());
  if (record.limit_seconds > 0)
    std::fprintf(stderr, "  %12s %7.2f s: %s\n", "limit", record.limit_seconds,
                 record.limit_reason.c_str());
}

void StageLog::note(const std::string& text) const {
  if (!quiet_) std::fprintf(stderr, "  %s\n", printable(text).c_str());
}

}  // namespace tremolo
