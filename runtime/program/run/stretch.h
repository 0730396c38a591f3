// Measures the stretch and compression of a body's boundary, for a warning about amplitudes beyond
// the validity of the material model.
#pragma once

#include <vector>

#include "runtime/body.h"

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

class SurfaceStretch {
 public:
  explicit SurfaceStretch(const Model& model);

  // Measures the body's present shape; body is one of the model. {1, 1} without triangles.
  StretchRange measure(const Body& body);

  // The farthest vertex of the shape that was measured last.
  Excursion farthest() const;
  // The largest extent of the boundary's box at rest, m.
  double size() const;

 private:
  const Model& model_;
  std::vector<Triangle> triangles_;
  std::vector<Eigen::Matrix2d> rest_inverse_;  // of the edges in the triangle's plane, 1/m
  std::vector<double> positions_;
};

}  // namespace tremolo
