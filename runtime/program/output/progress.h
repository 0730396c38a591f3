// Pieces of work on all threads, told on stderr.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <mutex>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "common/parallel.h"
#include "common/result.h"
#include "runtime/program/output/tell.h"

namespace tremolo {

// wanted: 0 for all cores.
inline unsigned thread_count(unsigned wanted) {
  return wanted > 0 ? wanted : std::max(1u, std::thread::hardware_concurrency());
}

// work(i) gives a Status. The first error, by index, is the whole's. A line every ten seconds and
// at the end: "what: finished of count".
template <class Work>
Status for_all(const char* what, std::size_t count, unsigned threads, const Work& work) {
  std::vector<Status> done(count, Success{});
  std::mutex mutex;
  std::size_t finished = 0;
  auto told = std::chrono::steady_clock::now();
  parallel_for(count, threads, [&](std::size_t i) {
    done[i] = work(i);
    const std::lock_guard lock(mutex);
    ++finished;
    const auto now = std::chrono::steady_clock::now();
    if (finished < count && now - told < std::chrono::seconds(10)) return;
    told = now;
    tell("tremolo: {}: {} of {}\n", what, finished, count);
  });
  for (const Status& status : done)
    if (!status) return status.error();
  return Success{};
}

}  // namespace tremolo
