// C functions tremolo_body_*: rays, grabs at any point of the surface, pins.
#include <algorithm>
#include <optional>

#include "runtime/c_api/c_api.h"

namespace {

using Eigen::Vector3d;
using tremolo::ContactBody;
using tremolo::Result;
using tremolo::Status;
using tremolo::Success;
using tremolo::SurfaceKind;
using tremolo::SurfacePlace;
using tremolo::c_api::with;

Status keep(const Result<std::size_t>& number, uint64_t* hand) {
  if (!number) return number.error();
  *hand = *number;
  return Success{};
}

SurfacePlace place_of(uint32_t triangle, const double weights[3]) {
  return {SurfaceKind::kDrawn, triangle, Vector3d(weights)};
}

}  // namespace

tremolo_status tremolo_body_pick(const tremolo_body* body, const double origin[3],
                                 const double direction[3], tremolo_hit* hit) {
  return with(body, {{origin, "the origin"}, {direction, "the direction"}, {hit, "the hit"}},
              [&](const ContactBody& known) -> Status {
                const auto found = known.pick(Vector3d(origin), Vector3d(direction));
                if (!found) return found.error();
                *hit = {};
                if (!*found) return Success{};
                hit->found = 1;
                hit->triangle = static_cast<uint32_t>((*found)->place.triangle);
                hit->vertex = static_cast<uint32_t>((*found)->vertex);
                std::copy_n((*found)->place.weights.data(), 3, hit->weights);
                std::copy_n((*found)->point.data(), 3, hit->point);
                hit->distance = (*found)->distance;
                return Success{};
              });
}

tremolo_status tremolo_body_grab_at(tremolo_body* body, uint32_t triangle, const double weights[3],
                                    double stiffness, double damping, uint64_t* hand) {
  return with(body, {{weights, "the weights"}, {hand, "the place for the hand"}},
              [&](ContactBody& known) {
                return keep(known.grab(place_of(triangle, weights), stiffness, damping), hand);
              });
}

tremolo_status tremolo_body_pin(tremolo_body* body, uint32_t vertex, uint64_t* hand) {
  return with(body, {{hand, "the place for the hand"}}, [&](ContactBody& known) -> Status {
    const Result<tremolo::VertexId> id = tremolo::c_api::to_vertex(vertex);
    if (!id) return id.error();
    return keep(known.pin(*id), hand);
  });
}

tremolo_status tremolo_body_pin_at(tremolo_body* body, uint32_t triangle, const double weights[3],
                                   uint64_t* hand) {
  return with(
      body, {{weights, "the weights"}, {hand, "the place for the hand"}},
      [&](ContactBody& known) { return keep(known.pin(place_of(triangle, weights)), hand); });
}
