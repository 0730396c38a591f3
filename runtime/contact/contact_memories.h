// The contacts of a body that are remembered between steps, sorted by obstacle and point.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "common/state_stream.h"
#include "runtime/contact/contact_law.h"

namespace tremolo {

// The deepest of the points past the middle of that obstacle, m, not below 0.
inline double deepest_past(std::span<const ContactMemory> memories, std::size_t obstacle) {
  double deepest = 0.0;
  for (const ContactMemory& memory : memories)
    if (memory.obstacle == obstacle) deepest = std::max(deepest, -memory.depth);
  return deepest;
}

class ContactMemories {
 public:
  // Null: the point has no memory of that obstacle.
  const ContactMemory* find(std::size_t obstacle, std::size_t point) const {
    const ContactMemory key{.obstacle = obstacle, .point = point};
    const auto found = std::lower_bound(list_.begin(), list_.end(), key, is_before);
    return found != list_.end() && !is_before(key, *found) ? &*found : nullptr;
  }

  // deepest_past() of these.
  double deepest(std::size_t obstacle) const { return deepest_past(list_, obstacle); }

  void reserve(std::size_t count) { list_.reserve(count); }
  void clear() { list_.clear(); }
  // Adds memories in any order; call sort() before the next find().
  void add(const ContactMemory& memory) { list_.push_back(memory); }
  void sort() { std::sort(list_.begin(), list_.end(), is_before); }

  void carry(StateStream& stream) { stream.sized(list_); }

 private:
  static bool is_before(const ContactMemory& x, const ContactMemory& y) {
    return x.obstacle < y.obstacle || (x.obstacle == y.obstacle && x.point < y.point);
  }

  std::vector<ContactMemory> list_;
};

}  // namespace tremolo
