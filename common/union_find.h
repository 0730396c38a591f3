// Disjoint sets of numbers: each number is its own root, or points towards it.
#pragma once

#include <algorithm>
#include <vector>

namespace tremolo {

// The smallest number of the set, if sets are joined by join_sets() only; halves the path to it.
template <class Id>
Id root_of(std::vector<Id>& parent, Id id) {
  while (parent[id] != id) {
    parent[id] = parent[parent[id]];
    id = parent[id];
  }
  return id;
}

template <class Id>
void join_sets(std::vector<Id>& parent, Id a, Id b) {
  a = root_of(parent, a);
  b = root_of(parent, b);
  parent[std::max(a, b)] = std::min(a, b);
}

}  // namespace tremolo
