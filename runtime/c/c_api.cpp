#include "runtime/c/c_api.h"

namespace tremolo::c_api {
namespace {

thread_local std::string last_error;
tremolo_log log_to = nullptr;
void* log_user = nullptr;

}  // namespace

tremolo_status fail(tremolo_status status, const char* message) noexcept {
  try {
    last_error = message;
  } catch (...) {
    last_error.clear();  // no memory even for the message
  }
  log(TREMOLO_LOG_ERROR, message);
  return status;
}

void log(tremolo_log_level level, const char* message) noexcept {
  if (log_to == nullptr) return;
  try {
    log_to(log_user, level, message);
  } catch (...) {
    // The log has no message for a log that throws; the call goes on.
  }
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

Status need(std::initializer_list<Argument> arguments) {
  for (const auto& [pointer, name] : arguments)
    if (pointer == nullptr) return usage_error(std::string(name) + " is NULL");
  return Success{};
}

Status need_buffer(const void* buffer, std::size_t length, std::size_t needed) {
  if (Status s = need({{buffer, "the buffer"}}); !s) return s;
  if (length != needed)
    return usage_error("the buffer's length is " + std::to_string(length) + ", must be " +
                       std::to_string(needed));
  return Success{};
}

Status fill_buffer(std::span<const Triangle> triangles, std::uint32_t* out, std::size_t length) {
  if (Status s = need_buffer(out, length, 3 * triangles.size()); !s) return s;
  for (const Triangle& triangle : triangles)
    for (const VertexId corner : triangle) *out++ = static_cast<std::uint32_t>(corner);
  return Success{};
}

Status copy_state(const State& state, double* q, double* p, std::size_t length) {
  if (Status s = fill_buffer(state.q, q, length); !s) return s;
  put(state.p, p);
  return Success{};
}

void copy_energy(const Energy& energy, double* kinetic, double* potential, double* high_band) {
  put(energy.kinetic, kinetic);
  put(energy.potential, potential);
  put(energy.high_band, high_band);
}

Result<VertexId> to_vertex(std::uint32_t vertex) {
  if (!std::in_range<VertexId>(vertex))
    return usage_error("the model has no vertex " + std::to_string(vertex));
  return static_cast<VertexId>(vertex);
}

}  // namespace tremolo::c_api

const char* tremolo_last_error(void) {
  return tremolo::c_api::last_error.c_str();
}

void tremolo_set_log(tremolo_log log, void* user) {
  tremolo::c_api::log_to = log;
  tremolo::c_api::log_user = user;
}

const char* tremolo_version(void) {
  return TREMOLO_VERSION;
}
