#include "runtime/tets/contact/tet_surface.h"

#include <utility>

#include <Eigen/Geometry>

#include "formats/surface/surface_writer.h"

namespace tremolo {
namespace {

// cof(F) = [f_y x f_z, f_z x f_x, f_x x f_y] of F's columns.
Eigen::Vector3d turned_normal(const Eigen::Matrix3d& f, const Eigen::Vector3d& n) {
  const Eigen::Vector3d x = f.col(0), y = f.col(1), z = f.col(2);
  const Eigen::Vector3d turned = n.x() * y.cross(z) + n.y() * z.cross(x) + n.z() * x.cross(y);
  const double length = turned.norm();
  return length > 0.0 ? Eigen::Vector3d(turned / length) : Eigen::Vector3d::Zero();
}

}  // namespace

TetSurface::TetSurface(TetModelPointer model, TetsSurface surface)
    : model_(std::move(model)), surface_(std::move(surface)) {
  values_.reserve(vertices());
  for (const Eigen::Vector4d& w : surface_.weights)
    values_.push_back(polynomials_at(2, {w[0], w[1], w[2], w[3]}));
  for (const Eigen::Vector3d& n : vertex_normals({surface_.vertices, surface_.triangles}))
    normals_.push_back(n.cast<float>());
}

void TetSurface::place(const Eigen::VectorXd& x, std::vector<Eigen::Vector3d>& vertices,
                       std::vector<Eigen::Vector3f>& normals) const {
  for (std::size_t v = 0; v < surface_.vertices.size(); ++v) {
    const TetModelElement& element = model_->elements()[surface_.tetrahedra[v]];
    const Eigen::Vector4d& w = surface_.weights[v];
    const auto at = [&](int node) {
      return x.segment<3>(3 * Eigen::Index{element.nodes[static_cast<std::size_t>(node)]});
    };
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    for (int node = 0; node < kMostNodes; ++node)
      place += values_[v][static_cast<std::size_t>(node)] * at(node);
    Eigen::Matrix3d f = Eigen::Matrix3d::Zero();
    for (int b = 0; b < 4; ++b) {
      Eigen::Vector3d slope = Eigen::Vector3d::Zero();
      for (int a = 0; a < 4; ++a) slope += 2.0 * w[a] * at(kNodeAt[a][b]);
      f += slope * element.element.geometry.gradients.col(b).transpose();
    }
    vertices[v] = place;
    normals[v] = turned_normal(f, normals_[v].cast<double>()).cast<float>();
  }
}

std::size_t TetSurface::bytes() const {
  return vertices() * (sizeof(Eigen::Vector3d) + sizeof(Eigen::Vector4d) + sizeof(values_[0]) +
                       sizeof(Eigen::Vector3f) + sizeof(std::uint32_t)) +
         surface_.triangles.size() * sizeof(Triangle);
}

}  // namespace tremolo
