// The identity of what a saved state belongs to: a hash of all values that its motion depends on.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/hash.h"
#include "common/state_stream.h"
#include "runtime/math/motion.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// A sequence of values, and the hash of all.
class Identity {
 public:
  template <class... Values>
  Identity& add(Values... values) {
    (put(values), ...);
    return *this;
  }
  std::uint64_t hash() const { return hash_bytes(std::as_bytes(std::span(bytes_))); }

 private:
  template <class Value>
  void put(Value& value) {
    StateStream stream = StateStream::writing(bytes_);
    stream(value);
  }
  void put(std::string& text) { put_sized(text); }
  void put(std::vector<double>& values) { put_sized(values); }
  void put(std::vector<Eigen::Vector3d>& values) { put_sized(values); }
  template <class Value>
  void put_sized(Value& value) {
    StateStream stream = StateStream::writing(bytes_);
    stream.sized(value);
  }

  std::string bytes_;
};

void add(Identity& identity, const Motion& motion);

// The identity of a body that has one more load.
std::uint64_t with_load(std::uint64_t body, const SceneLoad& load);

}  // namespace tremolo
