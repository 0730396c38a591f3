#include "runtime/c_api/c_api.h"

namespace tremolo::c_api {
namespace {

thread_local std::string last_error;

}  // namespace

tremolo_status fail(tremolo_status status, const char* message) noexcept {
  try {
    last_error = message;
  } catch (...) {
    last_error.clear();  // no memory even for the message
  }
  return status;
}

tremolo_status to_status(ErrorKind kind) noexcept {
  switch (kind) {
    case ErrorKind::kUsage:
      return TREMOLO_USAGE;
    case ErrorKind::kContent:
      return TREMOLO_CONTENT;
    case ErrorKind::kSolver:
      return TREMOLO_SOLVER;
    case ErrorKind::kBound:
      return TREMOLO_BOUND;
    default:
      return TREMOLO_SYSTEM;
  }
}

Status need(const void* pointer, const char* name) {
  if (pointer == nullptr) return usage_error(std::string(name) + " is NULL");
  return Success{};
}

Status need_buffer(const void* buffer, std::size_t length, std::size_t needed) {
  if (Status s = need(buffer, "the buffer"); !s) return s;
  if (length != needed)
    return usage_error("the buffer's length is " + std::to_string(length) + ", must be " +
                       std::to_string(needed));
  return Success{};
}

}  // namespace tremolo::c_api

const char* tremolo_last_error(void) {
  return tremolo::c_api::last_error.c_str();
}

const char* tremolo_version(void) {
  return TREMOLO_VERSION;
}
