#include "runtime/world/guest_joints.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/text.h"
#include "runtime/contact/islands/body_group.h"
#include "runtime/contact/weld.h"
#include "runtime/scene/scene_links.h"
#include "runtime/scene/welds.h"
#include "runtime/scene/world_anchor.h"
#include "runtime/world/guest_points.h"

namespace tremolo {

using Eigen::Vector3d;

Result<std::vector<GuestJoint>> GuestJointMaker::make(std::size_t i, bool& turned) const {
  const SceneJoint& wanted = world_.scene().joints[i];
  End first = end_of(wanted.body);
  End second = wanted.to.empty() ? world_end(i) : end_of(wanted.to);
  for (const End& end : {first, second})
    if (!end.guest)
      if (Status s = check_joinable(*end.body); !s) return content_error(s.error().message);
  if (wanted.weld) return weld(wanted, first, second, turned);
  if (Status s = find_place(first, wanted.at, "at"); !s) return s.error();
  if (wanted.to.empty())
    second.place = world_place(wanted.point.value_or(where(first)), *second.body);
  else if (wanted.to_at.empty())
    find_nearest(second, where(first), wanted.options.length);
  else if (Status s = find_place(second, wanted.to_at, "to-at"); !s)
    return s.error();
  if (Status s = check_apart(wanted, first, second); !s) return s.error();
  turned = !first.guest;
  Result<GuestJoint> made = join(wanted, turned ? second : first, turned ? first : second);
  if (!made) return made.error();
  return std::vector<GuestJoint>{std::move(*made)};
}

GuestJointMaker::End GuestJointMaker::end_of(const std::string& name) const {
  End end;
  if (const auto found = numbers_.find(name); found != numbers_.end()) {
    end.guest = found->second;
    return end;
  }
  const std::size_t body = *world_.find(name);
  end.body = &world_.body(body);
  end.number = world_.group_number(body);
  return end;
}

GuestJointMaker::End GuestJointMaker::world_end(std::size_t joint) const {
  End end;
  end.body = &world_.anchor(joint);
  end.number = world_.anchor_number(joint);
  return end;
}

Status GuestJointMaker::find_place(End& end, const std::string& text, const char* key) const {
  if (end.guest) return take(end.point, guest_point(guests_, *end.guest, text, key, "joint"));
  const ContactBody& body = *end.body;
  const Result<VertexId> vertex = joint_vertex(key, text, body);
  if (!vertex) return vertex.error();
  if (Status s = take(end.place, vertex_place(body, *vertex)); !s)
    return content_error(std::string(key) + " = \"" + text + "\": " + s.error().message);
  return Success{};
}

// Of a guest, which has no rotation, the nearest point; of a body the point that is there now, or
// the nearest vertex if the joint has a length.
void GuestJointMaker::find_nearest(End& end, const Vector3d& place, double length) const {
  if (end.guest) {
    end.point = guests_.point_near(*end.guest, place);
    return;
  }
  end.place = length == 0.0 ? place_at(*end.body, place) : vertex_near(*end.body, place);
}

Vector3d GuestJointMaker::where(const End& end) const {
  return end.guest ? guests_.point_at(*end.guest, end.point) : place_now(*end.body, end.place);
}

double GuestJointMaker::mass_at(const End& end) const {
  return end.guest ? guests_.mass_at(*end.guest, end.point) : end.body->mass_at(end.place);
}

double GuestJointMaker::margin(const End& end) const {
  if (end.guest) return guests_.margin(*end.guest);
  return end.body->contact() != nullptr ? end.body->contact()->surface().law.margin : INFINITY;
}

Status GuestJointMaker::check_apart(const SceneJoint& wanted, const End& first,
                                    const End& second) const {
  const double apart = (where(first) - where(second)).norm(), length = wanted.options.length;
  const double limit = std::min(margin(first), margin(second));
  if (wanted.options.stiffness || std::abs(apart - length) <= limit) return Success{};
  return content_error("its places are " + number_text(apart) + " m apart at the start, not " +
                       number_text(length) +
                       " m: say `length`, a `stiffness`, or put a body "
                       "elsewhere");
}

GuestJoint GuestJointMaker::between(const End& held, const End& other) const {
  GuestJoint made;
  made.guest = *held.guest;
  made.point = held.point;
  made.to_guest = other.guest.has_value();
  made.other = made.to_guest ? *other.guest : other.number;
  made.other_point = other.point;
  made.joint.second = other.place;
  return made;
}

Result<GuestJoint> GuestJointMaker::join(const SceneJoint& wanted, const End& held,
                                         const End& other) const {
  const double lightness = 1.0 / mass_at(held) + 1.0 / mass_at(other);
  if (!(lightness > 0.0)) return content_error("neither place moves: there is nothing to join");
  GuestJoint made = between(held, other);
  made.along = wanted.options.stiffness.has_value();
  Joint& joint = made.joint;
  joint.length = wanted.options.length;
  joint.touch = wanted.options.touch;
  const HandSpring most = stiffest_spring(1.0 / lightness, world_.step_size());
  joint.stiffness = wanted.options.stiffness.value_or(most.stiffness);
  joint.damping = made.along ? wanted.options.damping : most.damping;
  limit_spring(most, world_.step_size(), joint.stiffness, joint.damping);
  return made;
}

// The guest's points are tied to places of the body; they are all points of a selection, or those
// nearest to the body's vertices.
Result<std::vector<GuestJointMaker::Tie>> GuestJointMaker::tie_pair(const SceneJoint& wanted,
                                                                    const End& first,
                                                                    const End& second,
                                                                    double gap) const {
  if (first.guest && second.guest) return tie_guests(wanted, *first.guest, *second.guest, gap);
  const bool turned = !first.guest;
  const std::size_t guest = *(turned ? second : first).guest;
  const ContactBody& body = *(turned ? first : second).body;
  const std::string& of_body = turned ? wanted.at : wanted.to_at;
  std::vector<VertexId> vertices;
  if (!of_body.empty())
    if (Status s = take(vertices, weld_vertices(turned ? "at" : "to-at", of_body, body)); !s)
      return s.error();
  const Result<WeldVertices> onto = WeldVertices::create(body, vertices);
  if (!onto) return content_error(onto.error().message);
  std::vector<std::size_t> points;
  if (turned && wanted.to_at.empty()) {
    for (const Vector3d& position : onto->positions())
      points.push_back(guests_.point_near(guest, position));
    std::sort(points.begin(), points.end());
    points.erase(std::unique(points.begin(), points.end()), points.end());
  } else {
    Result<std::vector<std::size_t>> chosen =
        guest_points(guests_, guest, turned ? wanted.to_at : wanted.at, turned ? "to-at" : "at");
    if (!chosen) return chosen.error();
    points = std::move(*chosen);
  }
  return tie_to_body(points, guest, *onto, body, gap);
}

Result<std::vector<GuestJointMaker::Tie>> GuestJointMaker::tie_to_body(
    const std::vector<std::size_t>& points, std::size_t guest, const WeldVertices& onto,
    const ContactBody& body, double gap) const {
  std::vector<Tie> ties;
  double farthest = 0.0;
  for (const std::size_t point : points) {
    Tie tie{point, {}, {}, 0.0};
    double offset = 0.0;
    tie.rows = onto.at(guests_.point_at(guest, point), offset);
    farthest = std::max(farthest, offset);
    tie.lightness = 1.0 / guests_.mass_at(guest, point) +
                    static_cast<double>(points.size()) / body.mass_at(tie.rows);
    ties.push_back(std::move(tie));
  }
  if (farthest > gap) return content_error(too_far_to_weld(farthest, gap).message);
  return ties;
}

// Each point of the first guest is tied to a place between points of the second one. A place has no
// axes of its own that could keep an offset.
Result<std::vector<GuestJointMaker::Tie>> GuestJointMaker::tie_guests(const SceneJoint& wanted,
                                                                      std::size_t first,
                                                                      std::size_t second,
                                                                      double gap) const {
  const Result<std::vector<std::size_t>> points = guest_points(guests_, first, wanted.at, "at");
  if (!points) return points.error();
  std::vector<std::size_t> others;
  if (wanted.to_at.empty()) {
    for (std::size_t k = 0; k < guests_.points(second); ++k) others.push_back(k);
  } else {
    Result<std::vector<std::size_t>> chosen = guest_points(guests_, second, wanted.to_at, "to-at");
    if (!chosen) return chosen.error();
    others = std::move(*chosen);
  }
  std::vector<Vector3d> positions;
  for (const std::size_t other : others) positions.push_back(guests_.point_at(second, other));
  std::vector<Tie> ties;
  std::vector<double> used(others.size(), 0.0);  // sum of the weights of each
  double farthest = 0.0;
  for (const std::size_t point : *points) {
    ties.push_back({point, weld_place(positions, guests_.point_at(first, point)), {}, 0.0});
    const WeldPlace& place = ties.back().place;
    farthest = std::max(farthest, place.offset.norm());
    for (const WeldPlace::Point& one : place.used()) used[one.number] += std::abs(one.weight);
  }
  if (gap = std::min(gap, guests_.margin(first)); farthest > gap)
    return content_error(too_far_to_weld(farthest, gap).message);
  for (Tie& tie : ties) {
    tie.lightness = 1.0 / guests_.mass_at(first, tie.point);
    for (std::size_t k = 0; k < tie.place.count; ++k) {
      WeldPlace::Point& one = tie.place.points[k];
      tie.lightness +=
          std::abs(one.weight) * used[one.number] / guests_.mass_at(second, others[one.number]);
      one.number = others[one.number];
    }
  }
  return ties;
}

Result<std::vector<GuestJoint>> GuestJointMaker::weld(const SceneJoint& wanted, const End& first,
                                                      const End& second, bool& turned) const {
  turned = !first.guest;
  // The world has no surface.
  const double gap = wanted.to.empty() ? std::numeric_limits<double>::infinity()
                                       : wanted.gap.value_or(margin(first));
  Result<std::vector<Tie>> ties = tie_pair(wanted, first, second, gap);
  if (!ties) return ties.error();
  std::erase_if(*ties, [](const Tie& tie) { return !(tie.lightness > 0.0); });
  if (ties->empty()) return content_error("neither place moves: there is nothing to join");
  std::vector<GuestJoint> joints;
  for (const Tie& tie : *ties) {
    GuestJoint& made =
        joints.emplace_back(between(turned ? second : first, turned ? first : second));
    made.point = tie.point;
    made.place = tie.place;
    made.joint.second = tie.rows;
    made.along = made.to_guest && wanted.options.stiffness.has_value();
    made.further = joints.size() > 1;
    set_weld_spring(made.joint, wanted.options, ties->size(), tie.lightness, world_.step_size());
  }
  return joints;
}

}  // namespace tremolo
