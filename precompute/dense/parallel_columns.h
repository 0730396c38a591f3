// Parallel loop over blocks of columns.
#pragma once

#include <algorithm>

#include <Eigen/Core>

#include "common/parallel.h"

namespace tremolo {

// Calls body(first, count) for blocks of `width` columns (the last may be narrower). The division
// does not depend on the number of threads.
template <class Body>
void parallel_columns(Eigen::Index columns, Eigen::Index width, unsigned threads,
                      const Body& body) {
  const std::size_t count = (columns + width - 1) / width;
  parallel_for(count, threads, [&](std::size_t part) {
    const Eigen::Index first = static_cast<Eigen::Index>(part) * width;
    body(first, std::min(width, columns - first));
  });
}

}  // namespace tremolo
