// What the C header's sources share: the objects behind the handles, and guarded(), through which
// every entry point passes: whatever happens inside becomes a status and a message.
#pragma once

#include <cstddef>
#include <exception>
#include <new>
#include <string>
#include <utility>

#include "common/result.h"
#include "runtime/body.h"
#include "runtime/model.h"
#include "runtime/tremolo.h"
#include "runtime/world.h"

// NOLINTBEGIN(readability-identifier-naming): the names of the C header
struct tremolo_model {
  tremolo::Model::Pointer pointer;
};
struct tremolo_body {
  tremolo::Body body;
};
struct tremolo_world {
  tremolo::World world;
};
// NOLINTEND(readability-identifier-naming)

namespace tremolo::c_api {

// Keeps the message for this thread and returns the status.
tremolo_status fail(tremolo_status status, const char* message) noexcept;
tremolo_status to_status(ErrorKind kind) noexcept;

// Runs action() -> Status.
template <class Action>
tremolo_status guarded(Action&& action) noexcept {
  try {
    const Status status = action();
    if (status) return TREMOLO_OK;
    return fail(to_status(status.error().kind), status.error().message.c_str());
  } catch (const std::bad_alloc&) {
    return fail(TREMOLO_SYSTEM, "out of memory");
  } catch (const std::exception& exception) {
    return fail(TREMOLO_SYSTEM, exception.what());
  } catch (...) {
    return fail(TREMOLO_SYSTEM, "an unknown exception");
  }
}

inline Error usage_error(std::string message) {
  return {ErrorKind::kUsage, std::move(message)};
}

Status need(const void* pointer, const char* name);

// The buffer is there and has the length that is needed.
Status need_buffer(const void* buffer, std::size_t length, std::size_t needed);

// The caller's options over the defaults; fields beyond the caller's size keep theirs. NULL: the
// defaults.
Result<tremolo_body_options> complete_options(const tremolo_body_options* given);
Result<IntegratorOptions> to_integrator_options(const tremolo_body_options& options);

}  // namespace tremolo::c_api
