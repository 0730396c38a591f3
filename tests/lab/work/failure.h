// Errors of the laboratory: a part that cannot continue throws a Failure; main prints its message
// and returns its exit code.
#pragma once

#include <stdexcept>
#include <utility>

#include "common/result.h"

namespace tremolo {

struct Failure : std::runtime_error {
  explicit Failure(Error what_happened)
      : std::runtime_error(what_happened.message), error(std::move(what_happened)) {}
  Error error;
};

// The value of a result; throws its error as a Failure.
template <class T>
T or_fail(Result<T> result) {
  if (!result) throw Failure(std::move(result.error()));
  return std::move(*result);
}
inline void or_fail(Status status) {
  if (!status) throw Failure(std::move(status.error()));
}

}  // namespace tremolo
