#include "runtime/world/watched_jobs.h"

#include <thread>
#include <utility>

namespace tremolo {
namespace {

std::string of(std::size_t number, std::size_t count) {
  return std::to_string(number) + ", and there are " + std::to_string(count);
}

}  // namespace

WatchedJobs::WatchedJobs(BodyGroup::Jobs given)
    : given_(std::move(given)), busy_(new std::atomic<bool>[given_.workers]) {
  for (unsigned w = 0; w < given_.workers; ++w) busy_[w] = false;
}

BodyGroup::Jobs WatchedJobs::watched() {
  return {given_.workers,
          [this](std::size_t count, Job job, void* data) { run(count, job, data); }};
}

std::string WatchedJobs::problem() const {
  const std::lock_guard hold(mutex_);
  return problem_;
}

void WatchedJobs::forget_problem() {
  const std::lock_guard hold(mutex_);
  problem_.clear();
}

void WatchedJobs::note(const std::string& problem) {
  const std::lock_guard hold(mutex_);
  if (problem_.empty()) problem_ = "set_jobs: " + problem;
}

void WatchedJobs::run(std::size_t count, Job job, void* data) {
  if (count == 0) return;
  if (count > room_) {
    begun_.reset(new std::atomic<bool>[count]);
    room_ = count;
  }
  for (std::size_t i = 0; i < count; ++i) begun_[i] = false;
  job_ = job;
  data_ = data;
  count_ = count;
  thrown_ = nullptr;
  open_ = true;
  try {
    const auto call = [](void* at, std::size_t index, unsigned worker) {
      static_cast<WatchedJobs*>(at)->call(index, worker);
    };
    given_.run(count, call, this);
  } catch (const std::exception& exception) {
    note(std::string("run threw an exception, and must not: ") + exception.what());
  } catch (...) {
    note("run threw an exception, and must not");
  }
  // A call that begins now sees that the loop is closed, or is seen here.
  open_ = false;
  if (running_ != 0) note("run returned while jobs were running: let it wait until all are done");
  while (running_ != 0) std::this_thread::yield();
  std::size_t left = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (begun_[i]) continue;
    ++left;
    job(data, i, 0);
  }
  if (left != 0)
    note("run returned without " + std::to_string(left) + " of " + std::to_string(count) +
         " jobs: let it call job once for each index below count");
  if (thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
}

// False: the call breaks a rule. True: the job is begun, and the worker is busy.
bool WatchedJobs::may_begin(std::size_t index, unsigned worker) {
  if (!open_) {
    note("job was called after run had returned: let run wait until all are done");
    return false;
  }
  if (index >= count_) {
    note("job was called with index " + of(index, count_) +
         " jobs: call it once for each index below count");
    return false;
  }
  if (worker >= given_.workers) {
    note("job was called with worker " + of(worker, given_.workers) +
         ": give each call at a time a number below that");
    return false;
  }
  if (busy_[worker].exchange(true)) {
    note("two calls of job had worker " + std::to_string(worker) +
         " at a time: give each of them another one");
    return false;
  }
  if (!begun_[index].exchange(true)) return true;
  busy_[worker] = false;
  note("job was called again with index " + std::to_string(index) +
       ": call it once for each index below count");
  return false;
}

void WatchedJobs::call(std::size_t index, unsigned worker) {
  ++running_;
  if (may_begin(index, worker)) {
    try {
      job_(data_, index, worker);
    } catch (...) {
      const std::lock_guard hold(mutex_);
      if (!thrown_) thrown_ = std::current_exception();
    }
    busy_[worker] = false;
  }
  --running_;
}

}  // namespace tremolo
