// Common parts of the C interface's sources: the objects behind the handles, and guarded(), which
// wraps every entry point: it converts every error inside to a status and a message.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <initializer_list>
#include <new>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/result.h"
#include "runtime/contact/contact_law.h"
#include "runtime/contact_body.h"
#include "runtime/crowd.h"
#include "runtime/model.h"
#include "runtime/tremolo.h"

// NOLINTBEGIN(readability-identifier-naming): the names of the C header
struct tremolo_model {
  tremolo::Model::Pointer pointer;
};
struct tremolo_body {
  tremolo::ContactBody body;
  std::vector<tremolo::PlacedCollider> around = {};  // those of the step, kept for their room
};
struct tremolo_collider {
  tremolo::Collider shape;
};
struct tremolo_crowd {
  tremolo::Crowd crowd;
};
// NOLINTEND(readability-identifier-naming)

namespace tremolo::c_api {

// Keeps the message for this thread and returns the status.
tremolo_status fail(tremolo_status status, const char* message) noexcept;
tremolo_status to_status(ErrorKind kind) noexcept;
// Tells the log of tremolo_set_log().
void log(tremolo_log_level level, const char* message) noexcept;

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

// A pointer that the caller must pass, and its name in the error.
struct Argument {
  const void* pointer;
  const char* name;
};

// kUsage for the first that is NULL.
Status need(std::initializer_list<Argument> arguments);

// kUsage unless the buffer is there and has the length that is needed.
Status need_buffer(const void* buffer, std::size_t length, std::size_t needed);

// Stores a number, or the numbers of a vector, unless `out` is NULL.
template <class Value, class Out>
void put(const Value& value, Out* out) {
  if (out == nullptr) return;
  if constexpr (std::is_arithmetic_v<Value>)
    *out = static_cast<Out>(value);
  else
    std::copy(value.begin(), value.end(), out);
}

// Fills the caller's buffer with numbers, or with the three corners of each triangle. Errors of
// need_buffer().
template <class Numbers>
Status fill_buffer(const Numbers& numbers, double* out, std::size_t length) {
  if (Status s = need_buffer(out, length, static_cast<std::size_t>(numbers.size())); !s) return s;
  std::copy(numbers.begin(), numbers.end(), out);
  return Success{};
}
Status fill_buffer(std::span<const Triangle> triangles, std::uint32_t* out, std::size_t length);

// The object behind a handle, and its name in messages.
inline const Model& behind(const tremolo_model& handle) {
  return *handle.pointer;
}
inline ContactBody& behind(tremolo_body& handle) {
  return handle.body;
}
inline const ContactBody& behind(const tremolo_body& handle) {
  return handle.body;
}
inline Crowd& behind(tremolo_crowd& handle) {
  return handle.crowd;
}
inline const Crowd& behind(const tremolo_crowd& handle) {
  return handle.crowd;
}
// Used by c_api_contacts.cpp.
inline tremolo_contacts& behind(tremolo_contacts& handle) {
  return handle;
}
inline const tremolo_contacts& behind(const tremolo_contacts& handle) {
  return handle;
}
inline const char* name_of(const tremolo_contacts*) {
  return "the contacts";
}
inline const char* name_of(const tremolo_model*) {
  return "the model";
}
inline const Collider& behind(const tremolo_collider& handle) {
  return handle.shape;
}
inline const char* name_of(const tremolo_collider*) {
  return "the collider";
}
inline const char* name_of(const tremolo_body*) {
  return "the body";
}
inline const char* name_of(const tremolo_crowd*) {
  return "the crowd";
}

// Runs action(object behind the handle) -> Status; kUsage for NULL, also of a further argument.
template <class Handle, class Action>
tremolo_status with(Handle* handle, std::initializer_list<Argument> further,
                    Action&& action) noexcept {
  return guarded([&]() -> Status {
    if (Status s = need({{handle, name_of(handle)}}); !s) return s;
    if (Status s = need(further); !s) return s;
    return action(behind(*handle));
  });
}
template <class Handle, class Action>
tremolo_status with(Handle* handle, Action&& action) noexcept {
  return with(handle, {}, std::forward<Action>(action));
}

// Runs action() -> Status where the pointers are there; kUsage for the first that is NULL.
template <class Action>
tremolo_status with_all(std::initializer_list<Argument> arguments, const Action& action) noexcept {
  return guarded([&]() -> Status {
    if (Status s = need(arguments); !s) return s;
    return action();
  });
}

// Copies the state or energy of a body or a crowd's body. p and the parts of the energy may be
// NULL. length: of q and p.
Status copy_state(const State& state, double* q, double* p, std::size_t length);
void copy_energy(const Energy& energy, double* kinetic, double* potential, double* high_band);

// kUsage where the number is beyond every vertex id.
Result<VertexId> to_vertex(std::uint32_t vertex);

// Completes the caller's options with the defaults of init(), for fields beyond the caller's size.
// given: NULL for the defaults. init_name: init's, for the message.
template <class Options>
Result<Options> complete(const Options* given, void (*init)(Options*), const char* init_name) {
  Options options;
  init(&options);
  if (given == nullptr) return options;
  std::uint32_t size = 0;
  std::memcpy(&size, given, sizeof(size));
  if (size < sizeof(size))
    return usage_error("the options' size is " + std::to_string(size) + "; call " + init_name +
                       " first");
  std::memcpy(&options, given, std::min<std::size_t>(size, sizeof(options)));
  return options;
}

// The colliders of a step, checked.
Status place_colliders(const tremolo_placed_collider* given, std::size_t count,
                       std::vector<PlacedCollider>& placed);

Result<tremolo_body_options> complete_body_options(const tremolo_body_options* given);
Result<IntegratorOptions> to_integrator_options(const tremolo_body_options& options);
// kUsage for a value that is not a tremolo_frame.
Result<FrameKind> to_frame(std::int32_t frame);

}  // namespace tremolo::c_api
