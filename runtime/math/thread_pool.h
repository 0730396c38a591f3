// Threads that wait for loops to divide. They are started once, so that a loop costs a wake-up and
// no allocation. Loops that follow each other within some 20 us cost no system call: a waiting
// thread polls for that long before it sleeps, if there is a processor for each thread.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <vector>

namespace tremolo {

class ThreadPool {
 public:
  // threads: number of threads including the caller of run(), at least 1; with 1 none is started.
  // Throws std::system_error if the system refuses.
  explicit ThreadPool(unsigned threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  unsigned threads() const { return static_cast<unsigned>(helpers_.size()) + 1; }

  // Calls body(index, thread) once for each index below count; thread < threads() identifies
  // callers that run at the same time. Indices are assigned one by one, ascending. Returns when all
  // are done. The body must not throw and must not call run(). One caller at a time.
  template <class Body>
  void run(std::size_t count, Body&& body) {
    run_erased(
        count,
        [](void* at, std::size_t index, unsigned thread) {
          (*static_cast<std::remove_reference_t<Body>*>(at))(index, thread);
        },
        &body);
  }

 private:
  using Call = void (*)(void*, std::size_t, unsigned);

  void run_erased(std::size_t count, Call call, void* body);
  void work(unsigned thread);
  void help(unsigned thread);
  void end();
  template <class Number>
  void wait_while(const std::atomic<Number>& number, Number value) const;

  int looks_ = 0;  // polls of a waiting thread before it sleeps
  std::vector<std::thread> helpers_;
  Call call_ = nullptr;
  void* body_ = nullptr;
  std::int64_t count_ = 0;
  // Indices that are not assigned yet; below zero once threads have asked in vain. It counts down,
  // so that a helper that arrives after the end of a loop cannot take an index of the next loop:
  // nobody waits for helpers, only for indices.
  std::atomic<std::int64_t> left_{0};
  std::atomic<std::int64_t> done_{0};    // indices
  std::atomic<std::uint32_t> round_{0};  // of loops; helpers wait for it to change
  std::atomic<bool> ended_{false};
};

}  // namespace tremolo
