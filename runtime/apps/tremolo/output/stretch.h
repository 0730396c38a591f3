// Measures the stretch and compression of a body's boundary, for a warning about amplitudes beyond
// the validity of the material model.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "runtime/body.h"
#include "runtime/model.h"

namespace tremolo {

// St. Venant-Kirchhoff's stress along a compressed fibre is E/2 (s^3 - s), s the stretch: it
// softens below s = 1/sqrt(3), and nothing prevents an element from inverting.
inline constexpr double kSofteningStretch = 0.57735;

// Smallest and largest principal stretch over the boundary's triangles, dimensionless, 1 at rest.
struct StretchRange {
  double smallest = 1.0;
  double largest = 1.0;
};

// The distance of a vertex of the boundary from its rest position, m, and its id in the source
// mesh.
struct Excursion {
  double distance = 0.0;
  VertexId vertex = 0;
};

// For each coordinate the largest gradient, over all triangles of the boundary, of the displacement
// by a unit of it, by Frobenius's norm, kg^-1/2/m, r: at q no stretch is farther from 1 than
// sum_i |q_i| of that. Zero without triangles.
Eigen::VectorXd largest_gradients(const Model& model);

// The largest extent of the boundary's box at rest, m.
double surface_size(const Model& model);

class SurfaceStretch {
 public:
  explicit SurfaceStretch(const Model& model);

  // Measures the body's present shape; body is one of the model. {1, 1} without triangles.
  StretchRange measure(const Body& body);

  // The farthest vertex of the shape that was measured last.
  Excursion farthest() const;

 private:
  const Model& model_;
  std::vector<Triangle> triangles_;
  std::vector<Eigen::Matrix2d> rest_inverse_;  // of the edges in the triangle's plane, 1/m
  std::vector<double> positions_;
};

// Selects the steps after which a run measures the shape of a body. A measurement costs as much as
// hundreds of steps; for a sound with its hundred thousand steps, measuring always would dominate.
class ShapeLooks {
 public:
  // Every `least` steps, or kLooks times in `steps` steps where that is rarer. Then the body is
  // also seen where, every `least` steps, a bound of its displacement, sum_i |q_i| max |U_i|, is
  // larger by a twentieth than ever before: the largest motion does not pass unseen.
  static constexpr std::int64_t kLooks = 1000;
  ShapeLooks(const Model& model, std::int64_t least, std::int64_t steps);

  // q: after the step of that number; call it once for every step.
  bool due(std::int64_t step, const Eigen::VectorXd& q);

  // False if at q no vertex of the boundary can be farther than `displacement`, m, and no triangle
  // stretched beyond the range: the measurement can be skipped.
  bool can_exceed(const Eigen::VectorXd& q, double displacement, const StretchRange& range) const;

 private:
  std::int64_t least_, every_;
  double record_ = 0.0;     // m, the largest bound so far
  Eigen::VectorXd reach_;   // the farthest that a unit of each coordinate moves any vertex, r
  Eigen::VectorXd strain_;  // the largest gradient of it over any triangle, 1/m times m, r
};

}  // namespace tremolo
