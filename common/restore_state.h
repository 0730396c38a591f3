// Puts a state back whole or not at all.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "common/state_stream.h"

namespace tremolo {

// The state of `thing`, which this does not change.
template <class Thing>
std::string state_bytes(const Thing& thing) {
  std::string bytes;
  StateStream stream = StateStream::writing(bytes);
  // One function saves and restores; a stream that writes changes nothing.
  const_cast<Thing&>(thing).carry(stream);  // NOLINT(cppcoreguidelines-pro-type-const-cast)
  return bytes;
}

// False, and `thing` is as it was, if the bytes are not a state of it.
template <class Thing>
bool restore_state(Thing& thing, std::string_view bytes) {
  const std::string before = state_bytes(thing);
  const auto read = [&thing](std::string_view from) {
    StateStream stream = StateStream::reading(std::as_bytes(std::span(from.data(), from.size())));
    thing.carry(stream);
    return stream.good() && stream.left() == 0;
  };
  if (read(bytes)) return true;
  (void)read(before);
  return false;
}

}  // namespace tremolo
