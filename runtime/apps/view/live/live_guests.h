// The guests of a world, bodies of tetrahedra and cloths, as surfaces that the viewer shows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/material.h"
#include "common/mesh/tet_mesh.h"
#include "common/result.h"
#include "runtime/apps/view/camera/camera.h"
#include "runtime/apps/view/live/world_moment.h"
#include "runtime/bodies/cloth/cloth_parts.h"
#include "runtime/world/world_guests.h"

namespace tremolo {

// The fraction of an element's six edges that are quadratic. degrees: of all edges of the body.
float quadratic_share(const TetModel& model, const TetModelElement& element,
                      std::span<const std::uint8_t> degrees);

// Of each triangle of the drawn surface: the isotropic material of the tetrahedron that carries its
// first corner; none if that is orthotropic.
std::vector<std::optional<Material>> materials_of(const TetsKind& kind);

class LiveGuests {
 public:
  LiveGuests() = default;  // none
  // The world owns the guests and outlives this object.
  explicit LiveGuests(WorldGuests guests);

  std::size_t size() const { return guests_.guests == nullptr ? 0 : guests_.guests->size(); }
  const std::string& name(std::size_t i) const { return guests_.guests->name(i); }
  bool is_cloth(std::size_t i) const { return guests_.guests->cloth(i) != nullptr; }
  // "implicit-euler", ...
  std::string method(std::size_t i) const;
  bool failed(std::size_t i) const { return guests_.guests->failed(i); }
  // True if some of its vertices are fixed or moved by pins.
  bool is_held(std::size_t i) const;

  // The surface: of a cloth as in look_of(), of tetrahedra the drawn surface of their file.
  std::span<const Triangle> triangles(std::size_t i) const;
  // At rest, m: of a cloth as it is cut, of tetrahedra in their file's frame.
  std::vector<Eigen::Vector3d> rest(std::size_t i) const;
  // Texture coordinates of the surface's vertices; empty: there are none.
  std::span<const Eigen::Vector2f> uvs(std::size_t i) const;
  // Of each triangle; empty for a cloth.
  std::vector<std::optional<Material>> materials(std::size_t i) const;
  // Overwrites positions and normals of the surface, in the world, and of tetrahedra the degrees.
  void look(std::size_t i, BodyMoment& moment) const;

  // The nearest guest that the ray meets. vertex: of its surface, the nearest one. distance: from
  // the ray's origin, m.
  struct Hit {
    std::size_t guest = 0, vertex = 0;
    double distance = 0.0;
  };
  std::optional<Hit> pick(const CameraRay& ray) const;
  // A stiffness and damping that suit a hand there. A cloth swings about the hand with 2 Hz, as a
  // free body of tetrahedra does; a body of tetrahedra with fixed vertices follows four fifths of
  // the hand's displacement. Error kUsage: the point is fixed.
  Result<HandSpring> suitable_springs(const Hit& hit) const;
  // The place of a vertex of a guest's surface, m.
  Eigen::Vector3d vertex_at(std::size_t i, std::size_t vertex) const;
  MixedGuests& all() const { return *guests_.guests; }

  // Sums over all guests: kinetic and elastic energy, work of hands, J; contacts that began; points
  // in contact.
  double kinetic_energy() const;
  double elastic_energy() const;
  double hand_work() const;
  std::int64_t contacts() const;
  int active_contacts() const;

 private:
  const ClothBody& cloth(std::size_t i) const { return guests_.guests->cloth(i)->body(); }
  TetBody& tets(std::size_t i) const { return guests_.guests->tets(i)->body(); }

  WorldGuests guests_;
  std::vector<ClothLook> looks_;  // of each guest; empty of tetrahedra
  // Room of look().
  mutable std::vector<Eigen::Vector3d> places_;
  mutable std::vector<Eigen::Vector3f> normals_;
  mutable std::vector<float> particles_, particle_normals_;
};

}  // namespace tremolo
