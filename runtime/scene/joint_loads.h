// The masses that joints may have to carry.
//
// Without a joint, the bodies that hang together by the other joints of the scene fall into those
// at its one end and those at its other. The lighter side is what it carries; the whole of the
// bodies that move if both sides are the same, as in a ring, or both are supported.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "runtime/scene/scene.h"

namespace tremolo {

// A body as something that joints carry.
struct CarriedBody {
  double mass = 0.0;       // kg; of a body that moves freely
  bool moves = false;      // false: it is fixed or driven, or not a body of the scene
  bool supported = false;  // a hand holds it
};

class JointLoads {
 public:
  // body: returns the body of that name; called once for each. The joints must outlive this.
  JointLoads(std::span<const SceneJoint> joints,
             const std::function<CarriedBody(const std::string&)>& body);

  // Of joint i, kg; 0 if nothing moves.
  double of(std::size_t i) const;

 private:
  struct Joined {
    CarriedBody body;
    std::vector<std::size_t> joints;  // their numbers
  };
  struct Side {
    double mass = 0.0;       // kg, of the bodies that move
    bool supported = false;  // something holds them
    bool reaches = false;    // the joint's other end is among them
  };
  Side side(std::size_t i, const std::string& from, const std::string& to) const;

  std::span<const SceneJoint> joints_;
  std::map<std::string, Joined> joined_;  // by name; the world has none
};

}  // namespace tremolo
