// Loops over all cores with plain threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

namespace tremolo {

// Calls body(index) once for each index below count, on up to `threads` threads; indices are
// assigned one by one. An exception of the body is rethrown when all threads are done, the first
// one if there are several. Results that do not depend on which thread runs an index do not depend
// on the number of threads.
template <class Body>
void parallel_for(std::size_t count, unsigned threads, const Body& body) {
  std::atomic<std::size_t> next{0};
  std::atomic_flag failed;
  std::exception_ptr thrown;
  const auto work = [&]() noexcept {
    try {
      for (std::size_t index = next++; index < count; index = next++) body(index);
    } catch (...) {
      if (!failed.test_and_set()) thrown = std::current_exception();
      next = count;
    }
  };
  std::vector<std::thread> helpers;
  // If the system gives no more threads, the existing ones do the work.
  try {
    for (unsigned t = 1; t < threads && t < count; ++t) helpers.emplace_back(work);
  } catch (const std::system_error&) {
  } catch (const std::bad_alloc&) {
  }
  work();
  for (std::thread& helper : helpers) helper.join();
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace tremolo
