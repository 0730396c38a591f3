// tremolo_body_*: saving, putting back, other damping, from C.
#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "runtime/c_api/c_api.h"

namespace {

using tremolo::ContactBody;
using tremolo::Status;
using tremolo::Success;
using tremolo::c_api::with;

}  // namespace

tremolo_status tremolo_body_save(const tremolo_body* body, void* bytes, size_t capacity,
                                 size_t* size) {
  return with(body, {{size, "the place for the size"}}, [&](const ContactBody& known) -> Status {
    const std::vector<std::byte> saved = known.save();
    if (bytes != nullptr) {
      if (capacity < saved.size())
        return tremolo::usage_error("the buffer holds " + std::to_string(capacity) +
                                    " bytes, the state takes " + std::to_string(saved.size()));
      std::copy(saved.begin(), saved.end(), static_cast<std::byte*>(bytes));
    }
    *size = saved.size();
    return Success{};
  });
}

tremolo_status tremolo_body_restore(tremolo_body* body, const void* bytes, size_t size) {
  return with(body, {{bytes, "the bytes"}}, [&](ContactBody& known) {
    return known.restore(std::span(static_cast<const std::byte*>(bytes), size));
  });
}

tremolo_status tremolo_body_set_damping(tremolo_body* body, double alpha, double beta) {
  return with(body, [&](ContactBody& known) { return known.set_damping(alpha, beta); });
}
