#include "runtime/math/thread_pool.h"

#include <atomic>

#include <gtest/gtest.h>

namespace tremolo {
namespace {

TEST(ThreadPool, EveryIndexOfEveryLoopRunsOnce) {
  for (const unsigned threads : {1u, 2u, 3u, 5u}) {
    ThreadPool pool(threads);
    EXPECT_EQ(pool.threads(), threads);
    // Many short loops: helpers come late to most of them.
    for (std::size_t round = 0; round < 3000; ++round) {
      const std::size_t count = round % 17;
      std::vector<std::atomic<int>> calls(count);
      pool.run(count, [&](std::size_t index, unsigned thread) {
        if (thread < threads) ++calls[index];
      });
      for (std::size_t index = 0; index < count; ++index) ASSERT_EQ(calls[index], 1) << round;
    }
  }
}

TEST(ThreadPool, NoTwoCallsAtATimeShareAThreadNumber) {
  ThreadPool pool(4);
  std::atomic<int> inside[4] = {};
  std::atomic<int> clashes = 0;
  for (int round = 0; round < 200; ++round)
    pool.run(50, [&](std::size_t, unsigned thread) {
      if (inside[thread]++ != 0) ++clashes;
      --inside[thread];
    });
  EXPECT_EQ(clashes, 0);
}

}  // namespace
}  // namespace tremolo
