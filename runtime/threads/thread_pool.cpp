#include "runtime/threads/thread_pool.h"

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
  ended_.store(true, std::memory_order_release);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (std::thread& helper : helpers_) helper.join();
  helpers_.clear();
}

void ThreadPool::run_erased(std::size_t count, Call call, void* body) {
  // Nothing to share: waking the others would cost more than the work.
  if (helpers_.empty() || count < 2) {
    for (std::size_t index = 0; index < count; ++index) call(body, index, 0);
    return;
  }
  call_ = call;
  body_ = body;
  count_ = static_cast<std::int64_t>(count);
  done_.store(0, std::memory_order_relaxed);
  left_.store(count_, std::memory_order_release);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  work(0);
  for (std::int64_t done; (done = done_.load(std::memory_order_acquire)) != count_;)
    done_.wait(done, std::memory_order_acquire);
}

void ThreadPool::work(unsigned thread) {
  for (;;) {
    const std::int64_t ticket = left_.fetch_sub(1, std::memory_order_acq_rel);
    if (ticket <= 0) return;
    // The loop cannot end before this index is done: what describes it stands until then.
    const std::int64_t count = count_;
    call_(body_, static_cast<std::size_t>(count - ticket), thread);
    if (done_.fetch_add(1, std::memory_order_acq_rel) + 1 == count) done_.notify_one();
  }
}

void ThreadPool::help(unsigned thread) {
  std::uint32_t seen = 0;
  while (!ended_.load(std::memory_order_acquire)) {
    round_.wait(seen, std::memory_order_acquire);
    seen = round_.load(std::memory_order_acquire);
    work(thread);
  }
}

}  // namespace tremolo
