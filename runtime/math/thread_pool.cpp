#include "runtime/math/thread_pool.h"

namespace tremolo {
namespace {

constexpr int kLooks = 1000;

inline void pause_briefly() {
#if defined(__x86_64__) && defined(__GNUC__)
  __builtin_ia32_pause();
#endif
}

}  // namespace

ThreadPool::ThreadPool(unsigned threads)
    : looks_(threads <= std::thread::hardware_concurrency() ? kLooks : 0) {
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

template <class Number>
void ThreadPool::wait_while(const std::atomic<Number>& number, Number value) const {
  for (int look = 0; look < looks_; ++look) {
    if (number.load(std::memory_order_acquire) != value) return;
    pause_briefly();
  }
  number.wait(value, std::memory_order_acquire);
}

void ThreadPool::run_erased(std::size_t count, Call call, void* body) {
  // One index only: waking the others would cost more than the work.
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
    wait_while(done_, done);
}

void ThreadPool::work(unsigned thread) {
  for (;;) {
    const std::int64_t ticket = left_.fetch_sub(1, std::memory_order_acq_rel);
    if (ticket <= 0) return;
    // The loop cannot end before this index is done, so that its description is valid until then.
    const std::int64_t count = count_;
    call_(body_, static_cast<std::size_t>(count - ticket), thread);
    if (done_.fetch_add(1, std::memory_order_acq_rel) + 1 == count) done_.notify_one();
  }
}

void ThreadPool::help(unsigned thread) {
  std::uint32_t seen = 0;
  while (!ended_.load(std::memory_order_acquire)) {
    wait_while(round_, seen);
    seen = round_.load(std::memory_order_acquire);
    work(thread);
  }
}

}  // namespace tremolo
