// Runs work that may crash or hang in a child process with limits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/result.h"

namespace tremolo {

// seconds: by the clock, more than 0. memory: bytes that the child may take above what this process
// has; 0: no limit. answer: bytes that it may send.
struct ChildLimits {
  double seconds = 60;
  std::uint64_t memory = 0;
  std::uint64_t answer = 0;
};

using ChildWork = std::function<std::vector<std::byte>()>;

// Runs `work` in a forked child that writes no files, sees no standard streams and dies with this
// process, and returns what it returned. This process may have threads; the child has one, and runs
// no exit handlers. Errors: kContent if the work crashed ("crashed (signal 11)"), threw, took
// longer or needed more than it may; kSystem if there is no pipe or process to be had.
Result<std::vector<std::byte>> answer_of_child(const ChildWork& work, const ChildLimits& limits);

}  // namespace tremolo
