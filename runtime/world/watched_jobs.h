// Threads of the caller's for the steps of a world, watched: whatever they do, each job runs once,
// alone with its worker, and the step is complete.
#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <memory>
#include <mutex>
#include <string>

#include "runtime/contact/islands/body_group.h"

namespace tremolo {

class WatchedJobs {
 public:
  explicit WatchedJobs(BodyGroup::Jobs given);
  WatchedJobs(const WatchedJobs&) = delete;
  WatchedJobs& operator=(const WatchedJobs&) = delete;

  // For BodyGroup::set_jobs(), whose group must not outlive this object. Calls of job() that break
  // the rules of BodyGroup::Jobs are not made; jobs that `run` has not run are run by its caller.
  // Allocates where a loop is longer than any before.
  BodyGroup::Jobs watched();

  // The first rule that was broken since forget_problem(), and what to do; empty: none.
  std::string problem() const;
  void forget_problem();

 private:
  using Job = void (*)(void*, std::size_t, unsigned);

  void run(std::size_t count, Job job, void* data);
  void call(std::size_t index, unsigned worker);
  bool may_begin(std::size_t index, unsigned worker);
  void note(const std::string& problem);

  BodyGroup::Jobs given_;
  // Of the present loop.
  Job job_ = nullptr;
  void* data_ = nullptr;
  std::size_t count_ = 0, room_ = 0;
  std::unique_ptr<std::atomic<bool>[]> begun_, busy_;  // of each job; of each worker
  std::atomic<bool> open_{false};
  std::atomic<std::size_t> running_{0};  // calls of job
  mutable std::mutex mutex_;
  std::string problem_;
  std::exception_ptr thrown_;  // by a job
};

}  // namespace tremolo
