// Runs work that may crash or hang in a child process with limits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/result.h"

namespace tremolo {

// Limits of a child process.
struct ChildLimits {
  double seconds = 60;       // elapsed time, above 0
  std::uint64_t memory = 0;  // bytes that the child may use beyond this process; 0: no limit
  std::uint64_t answer = 0;  // bytes that it may send
};

using ChildWork = std::function<std::vector<std::byte>()>;

// Runs `work` in a forked child that writes no files, has no standard streams and ends with this
// process, and returns its result. This process may have threads; the child has one, and runs no
// exit handlers. Errors: kContent if the work crashed ("crashed (signal 11)"), threw, or exceeded
// its time or memory; kSystem if no pipe or process can be created.
Result<std::vector<std::byte>> answer_of_child(const ChildWork& work, const ChildLimits& limits);

}  // namespace tremolo
