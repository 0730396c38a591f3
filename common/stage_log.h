// Log of a long computation: its stages, with time and memory.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace tremolo {

struct StageRecord {
  std::string name;
  double seconds = 0;
  double cpu_seconds = 0;        // of all threads
  std::uint64_t peak_bytes = 0;  // largest resident memory while the stage ran
  std::string detail;            // one line about the outcome
  double limit_seconds = 0;      // no machine of this kind could be faster; 0: not known
  std::string limit_reason;      // the origin of that time
};

inline double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Collects stages and, unless quiet, prints a line a stage on stderr: the name when it begins (only
// on a terminal), name, seconds, peak and detail when it ends, and the limit if there is one.
class StageLog {
 public:
  explicit StageLog(bool quiet) : quiet_(quiet) {}

  void begin(std::string name);
  // The shortest time this stage could take, for its record; to be called before its end.
  void limit(double seconds, std::string reason);
  void end(std::string detail);
  void note(const std::string& text) const;

  const std::vector<StageRecord>& records() const { return records_; }

 private:
  bool quiet_;
  std::string current_;
  std::chrono::steady_clock::time_point start_;
  double cpu_start_ = 0;
  double limit_seconds_ = 0;
  std::string limit_reason_;
  std::vector<StageRecord> records_;
};

}  // namespace tremolo
