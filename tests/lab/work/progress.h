// Pieces of work on all threads, with a line on stderr now and then.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>
#include <thread>

#include "common/parallel.h"
#include "runtime/apps/tremolo/output/tell.h"

namespace tremolo {

// wanted: requested number of threads, 0 for all cores.
inline unsigned thread_count(unsigned wanted) {
  return wanted > 0 ? wanted : std::max(1u, std::thread::hardware_concurrency());
}

// Calls work(i) for each i below count. A line every ten seconds and at the end says "what:
// finished of count". An exception of a piece is rethrown once the threads have stopped.
template <class Work>
void for_all(const std::string& what, std::size_t count, unsigned threads, const Work& work) {
  std::mutex mutex;
  std::size_t finished = 0;
  auto last_report = std::chrono::steady_clock::now();
  parallel_for(count, threads, [&](std::size_t i) {
    work(i);
    const std::lock_guard lock(mutex);
    ++finished;
    const auto now = std::chrono::steady_clock::now();
    if (finished < count && now - last_report < std::chrono::seconds(10)) return;
    last_report = now;
    tell("tremolo: {}: {} of {}\n", what, finished, count);
  });
}

}  // namespace tremolo
