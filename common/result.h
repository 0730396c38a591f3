// A value or an error, and the exit codes that errors become.
#pragma once

#include <cerrno>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

namespace tremolo {

// Kinds of error, in the terms of the programs' exit codes (docs/reference.md).
enum class ErrorKind : int {
  kSystem = 1,     // I/O, memory, an output that cannot be written
  kUsage = 2,      // unknown flag or name
  kContent = 3,    // a value or a file's content is invalid
  kSolver = 4,     // a solver gave up
  kBound = 5,      // an orbit left its energy bound
  kCriterion = 6,  // a stated criterion was missed
};

// message: one sentence with the error and its position (file, line or byte offset, section).
struct Error {
  ErrorKind kind = ErrorKind::kSystem;
  std::string message;
};

inline Error usage_error(std::string message) {
  return {ErrorKind::kUsage, std::move(message)};
}
inline Error content_error(std::string message) {
  return {ErrorKind::kContent, std::move(message)};
}
inline Error system_error(std::string message) {
  return {ErrorKind::kSystem, std::move(message)};
}
// The error with the file it is about in front, unless its message begins with that already.
inline Error error_of_file(const std::string& path, Error error) {
  if (!error.message.starts_with(path + ":")) error.message = path + ": " + error.message;
  return error;
}
constexpr int exit_code(ErrorKind kind) {
  return static_cast<int>(kind);
}
inline int exit_code(const Error& error) {
  return exit_code(error.kind);
}

// Holds a T or an Error. `if (!result) return result.error();` is the usual way to pass one on.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  explicit operator bool() const { return state_.index() == 0; }
  T& value() { return std::get<0>(state_); }
  const T& value() const { return std::get<0>(state_); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  T& operator*() { return value(); }
  const T& operator*() const { return value(); }
  Error& error() { return std::get<1>(state_); }
  const Error& error() const { return std::get<1>(state_); }

 private:
  std::variant<T, Error> state_;
};

struct Success {};
using Status = Result<Success>;

// Moves the value of `result` to `target`, or element by element if `target` is a container of
// another type. Returns an error and leaves `target` unchanged then.
template <class Target, class Value>
Status take(Target& target, Result<Value> result) {
  if (!result) return std::move(result.error());
  if constexpr (std::is_assignable_v<Target&, Value&&>)
    target = std::move(*result);
  else
    target.assign(result->begin(), result->end());
  return Success{};
}

// The error of the last failed system call, from errno: "WHAT: why". ENOMEM has the message of
// every other lack of memory.
inline Error os_error(const std::string& what) {
  const int number = errno;
  return system_error(what + ": " + (number == ENOMEM ? "out of memory" : std::strerror(number)));
}

}  // namespace tremolo
