#include "runtime/bodies/tets/contact/tet_surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "common/processor.h"
#include "formats/surface/surface_writer.h"

namespace tremolo {
namespace {

// Three numbers and an unused one.
typedef double Place __attribute__((vector_size(32)));

// Input and output of the kernel. elements: one per vertex.
struct PlaceRows {
  std::size_t count;
  const double* x;
  const TetModelElement* all;
  const std::uint32_t* elements;
  const std::array<double, 3 * kMostNodes>* shares;
  double* vertices;
  float* normals;
};

TREMOLO_CLONES
void place_rows(const PlaceRows& g) {
  for (std::size_t v = 0; v < g.count; ++v) {
    const std::uint32_t* nodes = g.all[g.elements[v]].nodes.data();
    const double* shares = g.shares[v].data();
    Place at = {}, t = {}, s = {};
    for (std::size_t i = 0; i < kMostNodes; ++i) {
      const double* from = g.x + std::size_t{3} * nodes[i];
      const Place point = {from[0], from[1], from[2], 0.0};
      at += shares[i] * point;
      t += shares[kMostNodes + i] * point;
      s += shares[2 * kMostNodes + i] * point;
    }
    const double n[3] = {t[1] * s[2] - t[2] * s[1], t[2] * s[0] - t[0] * s[2],
                         t[0] * s[1] - t[1] * s[0]};
    const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    const double scale = length > 0.0 ? 1.0 / length : 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      g.vertices[3 * v + k] = at[k];
      g.normals[3 * v + k] = static_cast<float>(scale * n[k]);
    }
  }
}

// Two tangents with t x s = n; zero if the normal is zero.
std::pair<Eigen::Vector3d, Eigen::Vector3d> tangents_of(const Eigen::Vector3d& n) {
  if (!(n.squaredNorm() > 0.0)) return {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  const Eigen::Vector3d t = n.unitOrthogonal();
  return {t, n.cross(t)};
}

}  // namespace

TetSurface::TetSurface(TetModelPointer model, TetsSurface surface)
    : model_(std::move(model)), surface_(std::move(surface)) {
  shares_.resize(vertices());
  const std::vector<Eigen::Vector3d> normals =
      vertex_normals({surface_.vertices, surface_.triangles});
  for (std::size_t v = 0; v < vertices(); ++v) {
    const Eigen::Vector4d& w = surface_.weights[v];
    const auto values = polynomials_at(2, {w[0], w[1], w[2], w[3]});
    std::copy(values.begin(), values.end(), shares_[v].begin());
    const auto& gradients = model_->elements()[surface_.tetrahedra[v]].element.geometry.gradients;
    const auto [t, s] = tangents_of(normals[v]);
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) {
        const std::size_t node = kNodeAt[a][b];
        shares_[v][kMostNodes + node] += 2.0 * w[a] * gradients.col(b).dot(t);
        shares_[v][2 * kMostNodes + node] += 2.0 * w[a] * gradients.col(b).dot(s);
      }
  }
}

void TetSurface::place(const Eigen::VectorXd& x, std::vector<Eigen::Vector3d>& vertices,
                       std::vector<Eigen::Vector3f>& normals) const {
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
  if (surface_.vertices.empty()) return;
  place_rows({surface_.vertices.size(), x.data(), model_->elements().data(),
              surface_.tetrahedra.data(), shares_.data(), vertices.front().data(),
              normals.front().data()});
}

std::size_t TetSurface::bytes() const {
  return vertices() * (sizeof(Eigen::Vector3d) + sizeof(Eigen::Vector4d) + sizeof(shares_[0]) +
                       sizeof(std::uint32_t)) +
         surface_.triangles.size() * sizeof(Triangle);
}

}  // namespace tremolo
