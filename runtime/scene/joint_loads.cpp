#include "runtime/scene/joint_loads.h"

#include <algorithm>
#include <set>
#include <utility>

namespace tremolo {

JointLoads::JointLoads(std::span<const SceneJoint> joints,
                       const std::function<CarriedBody(const std::string&)>& body)
    : joints_(joints) {
  for (std::size_t i = 0; i < joints.size(); ++i)
    for (const std::string* end : {&joints[i].body, &joints[i].to})
      if (!end->empty()) joined_[*end].joints.push_back(i);
  for (auto& [name, joined] : joined_) joined.body = body(name);
}

// The bodies that are joined to `from`, it included, without joint i. An empty name is the world.
JointLoads::Side JointLoads::side(std::size_t i, const std::string& from,
                                  const std::string& to) const {
  Side side;
  std::set<std::string> seen = {from};
  std::vector<std::string> waiting = {from};
  while (!waiting.empty()) {
    const std::string name = std::move(waiting.back());
    waiting.pop_back();
    const auto found = joined_.find(name);
    const CarriedBody body = found == joined_.end() ? CarriedBody{} : found->second.body;
    side.supported = side.supported || !body.moves || body.supported;
    if (!body.moves) continue;
    side.mass += body.mass;
    side.reaches = side.reaches || name == to;
    for (const std::size_t k : found->second.joints) {
      const SceneJoint& joint = joints_[k];
      const std::string& other = joint.body == name ? joint.to : joint.body;
      if (k != i && seen.insert(other).second) waiting.push_back(other);
    }
  }
  return side;
}

double JointLoads::of(std::size_t i) const {
  const SceneJoint& joint = joints_[i];
  const Side one = side(i, joint.body, joint.to), other = side(i, joint.to, joint.body);
  if (one.reaches) return one.mass;
  if (one.supported == other.supported)
    return one.supported ? std::max(one.mass, other.mass) : std::min(one.mass, other.mass);
  return one.supported ? other.mass : one.mass;
}

}  // namespace tremolo
