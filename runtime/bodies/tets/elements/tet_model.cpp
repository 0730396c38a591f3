#include "runtime/bodies/tets/elements/tet_model.h"

#include <string>
#include <utility>

#include "runtime/bodies/tets/elements/smooth_modes.h"

namespace tremolo {
namespace {

std::array<Eigen::Vector3d, 4> tet_corners(const TetMesh& mesh, const Tetrahedron& tet) {
  std::array<Eigen::Vector3d, 4> corners;
  for (std::size_t a = 0; a < 4; ++a) corners[a] = mesh.vertices[tet[a]];
  return corners;
}

// The mean of the ends, regardless of the file: elements are straight at rest.
Status make_quadratic(TetMesh& mesh) {
  if (mesh.edge_points.empty())
    if (Status status = add_edge_points(mesh); !status) return status;
  for (const MeshEdge& edge : mesh.edges)
    mesh.vertices[edge.point] = 0.5 * (mesh.vertices[edge.a] + mesh.vertices[edge.b]);
  return Success{};
}

}  // namespace

Result<TetModelPointer> TetModel::create(TetMesh mesh, const MaterialTable& materials,
                                         std::span<const VertexId> held) {
  if (mesh.tetrahedra.empty()) return content_error("the mesh has no tetrahedra");
  if (materials.materials.empty()) return content_error("no material");
  if (!mesh.edges.empty()) remove_edge_points(mesh);
  auto model = std::make_shared<TetModel>();
  model->vertices_ = mesh.vertices.size();
  model->held_.assign(model->vertices_, 0);
  for (const VertexId v : held) {
    if (v < 0 || static_cast<std::size_t>(v) >= model->vertices_)
      return content_error("held vertex " + std::to_string(v) + " is not one of the mesh's " +
                           std::to_string(model->vertices_));
    model->held_[v] = 1;
  }
  model->box_ = bounding_box(mesh.vertices);
  model->mesh_ = std::move(mesh);
  if (Status status = make_quadratic(model->mesh_); !status) return status.error();
  for (const MeshEdge& edge : model->mesh_.edges) {
    model->held_.push_back(model->held_[edge.a] != 0 && model->held_[edge.b] != 0 ? 1 : 0);
    model->lengths_.push_back(
        (model->mesh_.vertices[edge.a] - model->mesh_.vertices[edge.b]).norm());
  }
  if (Status status = model->make_elements(materials); !status) return status.error();
  if (Status status = model->make_pattern(); !status) return status.error();
  model->rest_.resize(3 * model->nodes());
  for (std::size_t i = 0; i < model->nodes(); ++i)
    model->rest_.segment<3>(3 * i) = model->mesh_.vertices[i];
  model->smooth_ = std::make_shared<const SmoothSpace>(smooth_space(*model));
  return TetModelPointer(std::move(model));
}

Status TetModel::make_elements(const MaterialTable& materials) {
  for (const NamedMaterial& named : materials.materials) {
    if (Status status = check_material(named.material); !status)
      return content_error("material '" + named.name + "': " + status.error().message);
    elasticities_.push_back(make_elasticity(named.material));
  }
  elements_.reserve(mesh_.tetrahedra.size());
  float_stiffness_.reserve(kFloatStiffness * mesh_.tetrahedra.size());
  for (std::size_t e = 0; e < mesh_.tetrahedra.size(); ++e) {
    TetModelElement made;
    made.material = materials.of_tet.empty() ? 0 : static_cast<std::uint32_t>(materials.of_tet[e]);
    if (made.material >= elasticities_.size())
      return content_error("tetrahedron " + std::to_string(e) + " has no material");
    const Elasticity& elasticity = elasticities_[made.material];
    made.element = make_tet_element(tet_corners(mesh_, mesh_.tetrahedra[e]), elasticity,
                                    materials.materials[made.material].material.density);
    const ElementGeometry& geometry = made.element.geometry;
    if (!(geometry.volume > 0.0) || !geometry.gradients.allFinite())
      return content_error("tetrahedron " + std::to_string(e) + " has a volume of " +
                           std::to_string(geometry.volume) + " m^3");
    mass_ += made.element.mass;
    const ElementNodes nodes = element_nodes(mesh_, e);
    for (std::size_t i = 0; i < kMostNodes; ++i)
      made.nodes[i] = static_cast<std::uint32_t>(nodes[i]);
    pack_stiffness(rest_stiffness(geometry, elasticity, 2), made.stiffness);
    pack_stiffness(rest_stiffness(geometry, elasticity, 1), made.linear_stiffness);
    float_stiffness_.resize(float_stiffness_.size() + kFloatStiffness);
    pack_floats(made.stiffness, made.linear_stiffness,
                float_stiffness_.data() + float_stiffness_.size() - kFloatStiffness);
    elements_.push_back(made);
  }
  return Success{};
}

Status TetModel::make_pattern() {
  std::vector<NodePair> pairs;
  pairs.reserve(elements_.size() * kMostBlocks);
  for (const TetModelElement& element : elements_)
    for (std::size_t i = 0; i < kMostNodes; ++i)
      for (std::size_t j = 0; j < i; ++j) pairs.emplace_back(element.nodes[i], element.nodes[j]);
  if (Status status = take(pattern_, BlockPattern::create(nodes(), pairs)); !status) return status;
  masses_.assign(pattern_->blocks(), 0.0);
  for (TetModelElement& element : elements_) {
    for (std::size_t i = 0; i < kMostNodes; ++i)
      for (std::size_t j = 0; j <= i; ++j)
        element.places[node_block(i, j)] = {
            static_cast<std::uint32_t>(pattern_->find(element.nodes[i], element.nodes[j])),
            element.nodes[i] < element.nodes[j]};
    add_masses(element);
  }
  // A vertex without a tetrahedron has no mass, and does not move.
  for (std::size_t i = 0; i < nodes(); ++i)
    if (masses_[pattern_->diagonal(i)] == 0.0) held_[i] = 1;
  return Success{};
}

void TetModel::add_masses(const TetModelElement& element) {
  for (int i = 0; i < kMostNodes; ++i)
    for (int j = 0; j <= i; ++j)
      masses_[element.places[node_block(i, j)].place] += element.element.mass * mass_share(2, i, j);
}

std::size_t TetModel::bytes() const {
  return elements_.size() * bytes_per_element() + masses_.size() * sizeof(double) +
         pattern_->blocks() * sizeof(std::uint32_t) + nodes() * 6 * sizeof(double);
}

void TetModel::mass_times(const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
  const auto first = pattern_->first();
  const auto columns = pattern_->columns();
  for (std::size_t i = 0; i < nodes(); ++i) {
    const Eigen::Index at = 3 * i;
    const Eigen::Vector3d own = x.segment<3>(at);
    Eigen::Vector3d sum = masses_[first[i + 1] - 1] * own;
    for (std::size_t p = first[i]; p + 1 < first[i + 1]; ++p) {
      const Eigen::Index column = 3 * static_cast<std::size_t>(columns[p]);
      sum += masses_[p] * x.segment<3>(column);
      y.segment<3>(column) += masses_[p] * own;
    }
    y.segment<3>(at) = sum;
  }
}

}  // namespace tremolo
