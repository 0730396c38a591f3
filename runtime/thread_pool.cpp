#include "runtime/thread_pool.h"

namespace tremolo {

ThreadPool::ThreadPool(unsigned threads) {
  try {
    for (unsigned t = 1; t < threads; ++t) helpers_.emplace_back([this, t] { help(t); });
  } catch (...) {
    end();
    throw;
  }
}

ThreadPool::~ThreadPool() {
  end();
}

void ThreadPool::end() {
  ended_ = true;
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (std::thread& helper : helpers_) helper.join();
  helpers_.clear();
}

void ThreadPool::run_erased(std::size_t count, Call call, void* body) {
  call_ = call;
  body_ = body;
  count_ = count;
  next_.store(0, std::memory_order_relaxed);
  // Nothing to share: waking the others would cost more than the work.
  if (helpers_.empty() || count < 2) {
    work(0);
    return;
  }
  helping_.store(static_cast<std::uint32_t>(helpers_.size()), std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  work(0);
  for (std::uint32_t left; (left = helping_.load(std::memory_order_acquire)) != 0;)
    helping_.wait(left, std::memory_order_acquire);
}

void ThreadPool::work(unsigned thread) {
  for (std::size_t index = next_++; index < count_; index = next_++) call_(body_, index, thread);
}

void ThreadPool::help(unsigned thread) {
  std::uint32_t seen = 0;
  for (;;) {
    round_.wait(seen, std::memory_order_acquire);
    seen = round_.load(std::memory_order_acquire);
    if (ended_) return;
    work(thread);
    if (helping_.fetch_sub(1, std::memory_order_acq_rel) == 1) helping_.notify_one();
  }
}

}  // namespace tremolo
