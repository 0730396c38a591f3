// What a long computation is doing: stage by stage, with time and memory.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace tremolo {

struct StageRecord {
  std::string name;
  double seconds = 0;
  std::uint64_t peak_bytes = 0;  // largest resident memory while the stage ran
  std::string detail;            // one line about the outcome
};

// Collects stages and, unless quiet, prints a line a stage on stderr: the name when it begins (only
// on a terminal), name, seconds, peak and detail when it ends.
class StageLog {
 public:
  explicit StageLog(bool quiet) : quiet_(quiet) {}

  void begin(std::string name);
  void end(std::string detail);
  void note(const std::string& text) const;

  const std::vector<StageRecord>& records() const { return records_; }

 private:
  bool quiet_;
  std::string current_;
  std::chrono::steady_clock::time_point start_;
  std::vector<StageRecord> records_;
};

}  // namespace tremolo
