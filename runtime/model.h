// The model: one precomputed solid, immutable, shared by any number of bodies.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "formats/basis/basis_data.h"
#include "runtime/bodies/reduced/surface/surface_tree.h"
#include "runtime/contact/collider.h"
#include "runtime/math/kernels/potential.h"
#include "runtime/math/state.h"

namespace tremolo {

class InteriorRows;
class StrainMatrix;
struct OpenBasis;
struct SurfaceBasis;
struct FrameInertia;

// Options for loading a model.
struct ModelOptions {
  int modes = 0;  // level of detail: number of leading coordinates that are kept; 0 keeps all
  // V = 1/2 q^T Lambda q; the cubic and quartic terms are neither read nor kept.
  bool linear = false;
  bool hull = false;  // a render surface is neither read nor kept; the solid's boundary is drawn
};

// The drawn surface: the render surface if the model has one, else the solid's boundary. All
// members refer to the model. It has s vertices.
struct DrawnSurface {
  const std::vector<Eigen::Vector3d>& rest;  // s, m
  const BasisRows& rows;                     // 3s x r
  // 3s x 3p: displacement by forces at the p places with a response; may have no columns.
  const BasisRows& response;
  const std::vector<Triangle>& triangles;  // into rest
  // s: the mesh's vertex at the point (boundary) or the one with the largest weight in it: the
  // vertex that a force at this point acts on.
  const std::vector<VertexId>& mesh_vertices;
};

class Model : public std::enable_shared_from_this<Model> {
 public:
  using Pointer = std::shared_ptr<const Model>;

  // Errors: kContent if a shape does not fit, lambda is not positive and ascending, ids do not
  // ascend or a value is not finite; kUsage if options.modes is negative or above r.
  // solid: what the data is a rigid body of; solid() returns it.
  static Result<Pointer> from_data(const BasisData& data, ModelOptions options = {},
                                   std::optional<Collider> solid = std::nullopt);

  // Loads a basis file. Interior rows stay in the file, which is kept mapped, until a vertex inside
  // is requested. Errors as in formats/basis/basis_reader.h and from_data.
  static Result<Pointer> load(const std::string& path, ModelOptions options = {});

  // Loads a basis file in memory. The bytes are not needed after the call: the interior is copied
  // too.
  static Result<Pointer> load_from_memory(std::span<const std::byte> bytes,
                                          ModelOptions options = {});

  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;
  ~Model();

  Eigen::Index modes() const { return potential_.size(); }  // r; 0: rigid (rigid/rigid_solid.h)
  const Eigen::VectorXd& lambda() const { return potential_.lambda(); }  // r, (rad/s)^2, ascending
  const Potential& potential() const { return potential_; }
  // Unique entries of C and Q over the r coordinates, packed as in common/packed_index.h.
  std::span<const double> cubic() const { return potential_.cubic(); }
  std::span<const double> quartic() const { return potential_.quartic(); }
  // Stiffness damping by strain rates needs the Gram matrix of the strains. False: the file has
  // none (an imported model, or one made before 1.4), or the model is linear.
  bool has_strain_gram() const;
  // Reads the matrix at the first call; null if there is none. Errors of reading the file.
  // Thread-safe; may throw bad_alloc.
  Result<std::shared_ptr<const StrainMatrix>> strain_matrix() const;
  // The matrix if it has been read, else null.
  std::shared_ptr<const StrainMatrix> known_strain_matrix() const;
  // The solid's boundary, also where a render surface is drawn. rows has r columns.
  const VertexBlock& surface() const { return surface_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }  // into surface()
  // rows has r columns. nullptr: the file has none, or options.hull.
  const RenderBlock* render() const { return render_ ? &*render_ : nullptr; }
  DrawnSurface drawn() const {
    if (!render_)
      return {surface_.rest, surface_.rows, response_.surface, triangles_, surface_.vertex_ids};
    return {render_->surface.vertices, render_->rows, response_.render, render_->surface.triangles,
            render_->anchors};
  }
  // The exact shape of a rigid body that was made of one, else nullptr. Pictures and exports show
  // it by finer triangles than those of drawn(), whose vertices are the body's points.
  const Collider* solid() const { return solid_ ? &*solid_ : nullptr; }
  // Integrals of the r coordinates. nullptr: the file has none (an imported model, or one of an
  // older version).
  const InertiaIntegrals* inertia() const { return inertia_ ? &*inertia_ : nullptr; }
  // The same about the mesh's origin, or about the centre of mass, made at the first call; the
  // model must have inertia(). Thread-safe; may throw bad_alloc.
  std::shared_ptr<const FrameInertia> inertia_about_origin() const;
  std::shared_ptr<const FrameInertia> inertia_about_centre() const;
  // Tetrahedra with the mass, and the edges whose midpoints are vertices; empty unless the file has
  // the tetrahedra.
  const MassElements& elements() const { return elements_; }
  const std::vector<MeshEdge>& edges() const { return edges_; }
  // Free parts times six: 6 for a body without support.
  std::size_t rigid_mode_count() const { return rigid_mode_count_; }
  const DefaultLoad& default_load() const { return default_load_; }  // may be empty
  std::size_t vertex_count() const { return vertex_count_; }         // of the source mesh
  std::size_t tetrahedron_count() const { return tetrahedron_count_; }

  // The hash covers all values that affect motion: energy, boundary, inertia, default load. It is
  // made at the first call. Thread-safe.
  std::uint64_t content_hash() const;

  Eigen::VectorXd frequencies_hz() const;  // sqrt(lambda) / 2 pi, r
  // 2 / omega_max, s: explicit methods are linearly stable below.
  double explicit_step_limit() const;

  // A vertex by its id in the source mesh, on the surface or inside. Errors: kUsage if there is no
  // such vertex; errors of reading the file if the interior is read here. Thread-safe.
  Result<VertexRows> vertex(VertexId id) const;

  // The vertices for which the file has the part of the response to forces that the basis lacks; p
  // of them, kAtDefaultLoad first if it is one of them.
  std::span<const VertexId> response_places() const { return response_.at; }
  const BasisRows& boundary_response() const { return response_.surface; }  // 3s x 3p
  // The index of the vertex among them.
  std::optional<Eigen::Index> response_place(VertexId id) const;
  // Displacement of a vertex by forces (N) there, in addition to U q: 3 x 3p, m/N. Errors as
  // vertex().
  Result<VertexRows> response(VertexId id) const;

  // A point of a surface: its position at rest and its rows of U, those of the corners by weights.
  // Errors: kUsage if there is no such triangle, or the weights are not finite, below -1e-9 or do
  // not sum to one to 1e-6.
  Result<VertexRows> place(const SurfacePlace& place) const;
  // The mesh's vertex at (on a render surface: near) the corner with the largest weight. The point
  // must be valid for place().
  VertexId vertex_near(const SurfacePlace& place) const;
  // The tree for rays (runtime/bodies/reduced/surface/surface_tree.h), made at the first call.
  // Thread-safe; may throw bad_alloc.
  const SurfaceTree& surface_tree(SurfaceKind surface) const;
  // The vertices inside, read from the file at the first call. Errors of reading it. Thread-safe;
  // rows has r columns.
  Result<const VertexBlock*> interior() const;

  // The drawn surface's rows in the form for display (runtime/bodies/reduced/surface/surface.h),
  // made at the first call: a model that is never shown does not need them. Thread-safe; may throw
  // bad_alloc.
  const SurfaceBasis& surface_basis() const;

 private:
  Model(Potential potential, VertexBlock surface);
  DrawnSurface surface_of(SurfaceKind surface) const;
  static Result<std::shared_ptr<Model>> assemble(const BasisData& data, Eigen::Index modes,
                                                 const ModelOptions& options);

  Potential potential_;
  VertexBlock surface_;
  std::vector<Triangle> triangles_;
  std::optional<RenderBlock> render_;
  std::optional<Collider> solid_;
  std::optional<InertiaIntegrals> inertia_;
  MassElements elements_;
  LocalResponse response_;  // without the vertices inside
  std::vector<MeshEdge> edges_;
  mutable std::once_flag origin_once_, centre_once_, hash_once_;
  mutable std::uint64_t content_hash_ = 0;
  mutable std::shared_ptr<const FrameInertia> about_origin_, about_centre_;
  std::size_t rigid_mode_count_ = 0;
  DefaultLoad default_load_;
  std::size_t vertex_count_ = 0;
  std::size_t tetrahedron_count_ = 0;
  std::unique_ptr<InteriorRows> interior_;
  mutable std::mutex strains_mutex_;
  mutable std::vector<double> strain_gram_;         // of data in memory, until the matrix is made
  mutable std::shared_ptr<OpenBasis> strain_file_;  // of a file, until the matrix is read
  mutable std::shared_ptr<const StrainMatrix> strains_;
  mutable std::once_flag surface_basis_once_;
  mutable std::unique_ptr<SurfaceBasis> surface_basis_;
  mutable std::once_flag drawn_tree_once_, boundary_tree_once_;
  mutable std::unique_ptr<SurfaceTree> drawn_tree_, boundary_tree_;
};

}  // namespace tremolo
