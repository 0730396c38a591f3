// The contacts of a body that are remembered between steps, sorted by obstacle and point.
#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "common/state_stream.h"
#include "runtime/contact/contact_law.h"

namespace tremolo {

// A point that is held by a side may be so far from the surface of that obstacle, m.
inline double reach_of_sides(std::span<const ContactMemory> memories, std::size_t obstacle) {
  double reach = 0.0;
  for (const ContactMemory& memory : memories)
    if (memory.obstacle == obstacle)
      reach = std::max(reach, memory.side.beyond + std::max(0.0, -memory.depth));
  return reach;
}

// B of a point that has no memory, before ContactLevel sets it.
inline constexpr double kNoLevel = -std::numeric_limits<double>::infinity();

// Where the contact of all points of a body with one obstacle begins. B of a point follows its
// distance outwards only as far as those of all others do, and a point without a memory begins no
// farther out than they: a body that was put down on its floor would else stand in a dent of its
// own shape, as deep as the margin. No energy appears: B rises only where the point is beyond it.
// Distances are those at the start of the step, m; add() all points of the pair first.
class ContactLevel {
 public:
  void add(double begins, double distance, double margin) {
    least_ = std::min(least_, std::max(begins, std::min(distance, margin)));
  }
  // B in this step. It is not below 0 for a point without a memory that is outside.
  double of(double begins, double distance, double margin) const {
    if (begins > kNoLevel) return std::max(begins, least_);
    return std::min({margin, distance, std::max(0.0, least_)});
  }

 private:
  double least_ = std::numeric_limits<double>::infinity();
};

class ContactMemories {
 public:
  // Null: the point has no memory of that obstacle.
  const ContactMemory* find(std::size_t obstacle, std::size_t point) const {
    const ContactMemory key{.obstacle = obstacle, .point = point};
    const auto found = std::lower_bound(list_.begin(), list_.end(), key, is_before);
    return found != list_.end() && !is_before(key, *found) ? &*found : nullptr;
  }

  // reach_of_sides() of these.
  double reach_of_sides(std::size_t obstacle) const {
    return tremolo::reach_of_sides(list_, obstacle);
  }

  void reserve(std::size_t count) { list_.reserve(count); }
  void clear() {
    list_.clear();
    farthest_ = 0.0;
  }
  // Adds memories in any order; call sort() before the next find().
  void add(const ContactMemory& memory) {
    list_.push_back(memory);
    farthest_ = std::max(farthest_, memory.side.beyond);
  }
  // The largest distance beyond an edge at which a point may be held, m.
  double farthest() const { return farthest_; }
  void sort() { std::sort(list_.begin(), list_.end(), is_before); }

  void carry(StateStream& stream) {
    stream.sized(list_);
    farthest_ = 0.0;
    for (const ContactMemory& memory : list_) farthest_ = std::max(farthest_, memory.side.beyond);
  }

 private:
  static bool is_before(const ContactMemory& x, const ContactMemory& y) {
    return x.obstacle < y.obstacle || (x.obstacle == y.obstacle && x.point < y.point);
  }

  std::vector<ContactMemory> list_;
  double farthest_ = 0.0;
};

}  // namespace tremolo
