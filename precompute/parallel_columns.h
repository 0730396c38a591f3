// Blocks of columns on several threads.
#pragma once

#include <algorithm>
#include <exception>
#include <vector>

#include <Eigen/Core>

#include "common/parallel.h"

namespace tremolo {

// Calls body(first, count) for blocks of `width` columns (the last may be narrower). The division
// does not depend on the number of threads. Unlike parallel_for's, the body may throw: the first
// block's exception is passed on once all have ended.
template <class Body>
void parallel_columns(Eigen::Index columns, Eigen::Index width, unsigned threads,
                      const Body& body) {
  const auto count = static_cast<std::size_t>((columns + width - 1) / width);
  std::vector<std::exception_ptr> thrown(count);
  parallel_for(count, threads, [&](std::size_t part) {
    const Eigen::Index first = static_cast<Eigen::Index>(part) * width;
    try {
      body(first, std::min(width, columns - first));
    } catch (...) {
      thrown[part] = std::current_exception();
    }
  });
  for (const std::exception_ptr& exception : thrown)
    if (exception) std::rethrow_exception(exception);
}

}  // namespace tremolo
