// Saving and restoring a body as the bytes of a file (formats/saved/saved_file.h).
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "common/state_stream.h"
#include "formats/saved/saved_file.h"

namespace tremolo {

// AnyBody: Body or ContactBody, of which content_hash() and carry() are used.
template <class AnyBody>
SavedState identity_of(const AnyBody& body) {
  return {"a body",
          TREMOLO_VERSION,
          {{"model", body.model().content_hash()}, {"method or frame", body.content_hash()}},
          {}};
}

template <class AnyBody>
std::vector<std::byte> save_body(const AnyBody& body) {
  SavedState saved = identity_of(body);
  saved.state = state_bytes(body);
  return encode_saved(saved);
}

// Error kContent, with the body unchanged: the bytes are damaged or belong to another body.
template <class AnyBody>
Status restore_body(AnyBody& body, std::span<const std::byte> bytes) {
  const std::string name = "the saved body";
  const Result<SavedState> saved = read_saved(bytes, name);
  if (!saved) return saved.error();
  if (Status s = check_belongs(*saved, identity_of(body)); !s)
    return error_of_file(name, s.error());
  if (!restore_state(body, saved->state))
    return content_error(name + ": it does not fit this body: other loads, or made by hand");
  return Success{};
}

}  // namespace tremolo
