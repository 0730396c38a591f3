// Joints and welds of a scene that hold bodies of tetrahedra or cloths.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/mixed/mixed_guests.h"
#include "runtime/scene/scene.h"
#include "runtime/scene/welds.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

// Makes the joints of a world with guests.
class GuestJointMaker {
 public:
  // numbers: of the guests, by their names. All stay in memory.
  GuestJointMaker(const SceneWorld& world, const MixedGuests& guests,
                  const std::map<std::string, std::size_t>& numbers)
      : world_(world), guests_(guests), numbers_(numbers) {}

  // The joint i of the scene, between points, or those of a weld, at least one. turned: the joint's
  // guest is `to`.
  // Errors (kContent): as for HeldJoint::create().
  Result<std::vector<GuestJoint>> make(std::size_t i, bool& turned) const;

 private:
  // One of the two ends of a joint: a guest's point, or a place of a body, which is a body of the
  // world or stands for the world itself. number: its own in the group.
  struct End {
    std::optional<std::size_t> guest;
    std::size_t point = 0;
    const ContactBody* body = nullptr;
    std::size_t number = 0;
    JointPlace place;
  };
  // A joint of a weld: its first point is a guest's, the second one between points of another
  // guest, or a body's.
  struct Tie {
    std::size_t point = 0;
    WeldPlace place;
    JointPlace rows;
    double lightness = 0.0;  // of the points, 1/kg
  };

  End end_of(const std::string& name) const;
  End world_end(std::size_t joint) const;
  Status find_place(End& end, const std::string& text, const char* key) const;
  void find_nearest(End& end, const Eigen::Vector3d& place, double length) const;
  Eigen::Vector3d where(const End& end) const;
  double mass_at(const End& end) const;
  double margin(const End& end) const;
  Status check_apart(const SceneJoint& wanted, const End& first, const End& second) const;
  Result<GuestJoint> join(const SceneJoint& wanted, const End& held, const End& other) const;
  GuestJoint between(const End& held, const End& other) const;

  Result<std::vector<GuestJoint>> weld(const SceneJoint& wanted, const End& first,
                                       const End& second, bool& turned) const;
  Result<std::vector<Tie>> tie_guests(const SceneJoint& wanted, std::size_t first,
                                      std::size_t second, double gap) const;
  Result<std::vector<Tie>> tie_to_body(const std::vector<std::size_t>& points, std::size_t guest,
                                       const WeldVertices& onto, const ContactBody& body,
                                       double gap) const;
  Result<std::vector<Tie>> tie_pair(const SceneJoint& wanted, const End& first, const End& second,
                                    double gap) const;

  const SceneWorld& world_;
  const MixedGuests& guests_;
  const std::map<std::string, std::size_t>& numbers_;
};

}  // namespace tremolo
