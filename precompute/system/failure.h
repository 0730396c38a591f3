// Exception of the precompute's stages; main turns a Failure into a message and an exit code.
#pragma once

#include <exception>
#include <utility>

#include "common/result.h"

namespace tremolo {

class Failure : public std::exception {
 public:
  explicit Failure(Error error) : error_(std::move(error)) {}
  const Error& error() const { return error_; }
  const char* what() const noexcept override { return error_.message.c_str(); }

 private:
  Error error_;
};

// Returns the value; throws its error as a Failure.
template <class T>
T unwrap(Result<T> result) {
  if (!result) throw Failure(result.error());
  return std::move(*result);
}

}  // namespace tremolo
