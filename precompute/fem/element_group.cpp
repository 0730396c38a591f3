#include "precompute/fem/element_group.h"

#include <numbers>

namespace tremolo {
namespace {

// Stress of sym(G), entries xx yy zz yz xz xy.
struct LaneStress {
  Lanes at[6];
};

// The law of one isotropic material for all elements.
struct UniformLaw {
  double lambda, mu;

  explicit UniformLaw(const Solid& solid)
      : lambda(solid.elasticities.front().lambda), mu(solid.elasticities.front().mu) {}
  void load(const Solid&, const int*, std::size_t) {}
  [[gnu::always_inline]] inline LaneStress stress(const Lanes& xx, const Lanes& yy, const Lanes& zz,
                                                  const Lanes& yz, const Lanes& xz,
                                                  const Lanes& xy) const {
    const Lanes mean = lambda * (xx + yy + zz);
    return {{mean + 2.0 * mu * xx, mean + 2.0 * mu * yy, mean + 2.0 * mu * zz, 2.0 * mu * yz,
             2.0 * mu * xz, 2.0 * mu * xy}};
  }
};

// A law in which each of the eight elements has its own tensor. It acts on plain entries of strains
// and stresses, without Mandel's factors, and is therefore not symmetric.
struct alignas(8 * kLanes) GeneralLaw {
  Lanes tensor[6][6] = {};

  explicit GeneralLaw(const Solid&) {}
  void load(const Solid& solid, const int* elements, std::size_t count) {
    for (std::size_t lane = 0; lane < count; ++lane) {
      const Matrix6& c = solid.elasticity(elements[lane]).tensor;
      for (int k = 0; k < 6; ++k)
        for (int l = 0; l < 6; ++l)
          tensor[k][l][lane] =
              c(k, l) * (l < 3 ? 1.0 : std::numbers::sqrt2) / (k < 3 ? 1.0 : std::numbers::sqrt2);
    }
  }
  [[gnu::always_inline]] inline LaneStress stress(const Lanes& xx, const Lanes& yy, const Lanes& zz,
                                                  const Lanes& yz, const Lanes& xz,
                                                  const Lanes& xy) const {
    LaneStress s;
    for (int k = 0; k < 6; ++k)
      s.at[k] = tensor[k][0] * xx + tensor[k][1] * yy + tensor[k][2] * zz + tensor[k][3] * yz +
                tensor[k][4] * xz + tensor[k][5] * xy;
    return s;
  }
};

// Geometry of a group of elements. gradients: of the barycentric coordinates 1..3, times the order
// and minus the volume; that of coordinate 0 is minus their sum. rows: offsets of the nodes in
// `out`; -1 if there is none.
struct Corners {
  Lanes gradients[3][3];  // [axis][coordinate]
  int rows[kMostNodes][kLanes];
};

[[gnu::always_inline]] inline void load_corners(const Solid& solid, const int* elements,
                                                std::size_t count,
                                                const std::vector<int>& row_of_vertex,
                                                Corners& corners) {
  corners = {};
  const int order = solid.order(), nodes_count = nodes_of_order(order);
  for (std::size_t lane = 0; lane < count; ++lane) {
    const std::size_t e = elements[lane];
    const ElementGeometry& element = solid.elements[e];
    const ElementNodes nodes = element_nodes(solid.mesh, e);
    for (int d = 0; d < 3; ++d)
      for (int a = 0; a < 3; ++a)
        corners.gradients[d][a][lane] = -order * element.volume * element.gradients(d, a + 1);
    for (int i = 0; i < nodes_count; ++i) corners.rows[i][lane] = row_of_vertex[nodes[i]];
  }
  for (std::size_t lane = count; lane < kLanes; ++lane)
    for (int i = 0; i < nodes_count; ++i) corners.rows[i][lane] = -1;
}

}  // namespace

TREMOLO_CLONES void load_gradients(const Solid& solid, const BasisRows& fields, const int* elements,
                                   std::size_t count, std::vector<LaneGradient>& out) {
  const std::size_t fields_count = fields.cols();
  const std::size_t each = gradients_of_order(solid.order());
  if (count < kLanes)
    for (LaneGradient& gradient : out) gradient = {};
  auto* entries = reinterpret_cast<double*>(out.data());
  for (std::size_t lane = 0; lane < count; ++lane) {
    const std::size_t e = elements[lane];
    Eigen::Matrix<double, 3, 4> gradients = solid.elements[e].gradients;
    if (each > 1) gradients *= 2.0;
    const ElementNodes nodes = element_nodes(solid.mesh, e);
    for (std::size_t a = 0; a < each; ++a)
      for (std::size_t x = 0; x < 3; ++x) {
        const double* rows[4];
        for (std::size_t b = 0; b < 4; ++b) {
          const VertexId node = nodes[each == 1 ? b : kNodeAt[a][b]];
          rows[b] = fields.data() + (3 * static_cast<std::size_t>(node) + x) * fields_count;
        }
        for (std::size_t d = 0; d < 3; ++d) {
          const double* n = gradients.data() + d;  // column-major, 3 x 4
          double* entry = entries + (9 * a + 3 * x + d) * kLanes + lane;
          for (std::size_t i = 0; i < fields_count; ++i)
            entry[i * each * 9 * kLanes] =
                rows[0][i] * n[0] + rows[1][i] * n[3] + rows[2][i] * n[6] + rows[3][i] * n[9];
        }
      }
  }
}

namespace {

// Forces on the nodes of eight elements but the first corner, which has minus their sum:
// [node - 1][axis][lane].
template <int kOrder>
struct alignas(8 * kLanes) LaneForces {
  double at[nodes_of_order(kOrder) - 1][3][kLanes];
};

// P = S(sym(A^T B)) + A S(sym B) + B S(sym A), one row of it. a, b: displacement gradients; sa, sb:
// the stresses of their symmetric parts; s: that of the product.
[[gnu::always_inline]] inline void piola_row(const Lanes* a, const Lanes* b, const LaneStress& s,
                                             const Lanes* sa, const Lanes* sb, int x,
                                             Lanes* piola) {
  // Index of entry (row, column) of a symmetric matrix in the order xx yy zz yz xz xy.
  constexpr int kAt[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};
  for (int d = 0; d < 3; ++d) {
    piola[d] = s.at[kAt[x][d]];
    for (int c = 0; c < 3; ++c)
      piola[d] += a[3 * x + c] * sb[kAt[c][d]] + b[3 * x + c] * sa[kAt[c][d]];
  }
}

template <class Law>
[[gnu::always_inline]] inline LaneStress product_stress(const Law& law, const Lanes* a,
                                                        const Lanes* b) {
  return law.stress(
      a[0] * b[0] + a[3] * b[3] + a[6] * b[6], a[1] * b[1] + a[4] * b[4] + a[7] * b[7],
      a[2] * b[2] + a[5] * b[5] + a[8] * b[8],
      0.5 * (a[1] * b[2] + a[4] * b[5] + a[7] * b[8] + a[2] * b[1] + a[5] * b[4] + a[8] * b[7]),
      0.5 * (a[0] * b[2] + a[3] * b[5] + a[6] * b[8] + a[2] * b[0] + a[5] * b[3] + a[8] * b[6]),
      0.5 * (a[0] * b[1] + a[3] * b[4] + a[6] * b[7] + a[1] * b[0] + a[4] * b[3] + a[7] * b[6]));
}

// Gradient and stress of one field in one sample point of eight elements.
struct alignas(8 * kLanes) LaneSample {
  Lanes gradient[9];
  LaneStress stress;
};

// p . grad l_j for each coordinate j but 0, times minus the volume and the order.
[[gnu::always_inline]] inline void along_gradients(const Lanes* p, const Corners& corners,
                                                   Lanes* out) {
  for (int j = 0; j < 3; ++j)
    out[j] = p[0] * corners.gradients[0][j] + p[1] * corners.gradients[1][j] +
             p[2] * corners.gradients[2][j];
}

// a, b: samples of the two fields, one a point.
template <class Law>
[[gnu::always_inline]] inline void pair_forces(const Law& law, const LaneSample* a,
                                               const LaneSample* b, const Corners& corners,
                                               LaneForces<1>& forces) {
  const LaneStress s = product_stress(law, a->gradient, b->gradient);
  for (int x = 0; x < 3; ++x) {
    Lanes piola[3], force[3];
    piola_row(a->gradient, b->gradient, s, a->stress.at, b->stress.at, x, piola);
    along_gradients(piola, corners, force);
    for (int j = 0; j < 3; ++j) *reinterpret_cast<Lanes*>(forces.at[j][x]) = force[j];
  }
}

template <class Law>
[[gnu::always_inline]] inline void pair_forces(const Law& law, const LaneSample* a,
                                               const LaneSample* b, const Corners& corners,
                                               LaneForces<2>& forces) {
  const std::span<const SamplePoint> points = sample_points(2, 3);
  LaneStress s[5];
  for (int p = 0; p < 5; ++p) s[p] = product_stress(law, a[p].gradient, b[p].gradient);
  for (int x = 0; x < 3; ++x) {
    // Sum over the points of share times lambda_c times piola, conjugate to G_c.
    Lanes conjugate[4][3] = {};
    for (int p = 0; p < 5; ++p) {
      Lanes piola[3];
      piola_row(a[p].gradient, b[p].gradient, s[p], a[p].stress.at, b[p].stress.at, x, piola);
      for (int c = 0; c < 4; ++c) {
        const double weight = points[p].share * points[p].lambda[c];
        for (int d = 0; d < 3; ++d) conjugate[c][d] += weight * piola[d];
      }
    }
    // along[c][j]: conjugate[c] . grad l_j, of which l_0 has minus the sum.
    Lanes along[4][4];
    for (int c = 0; c < 4; ++c) {
      along_gradients(conjugate[c], corners, along[c] + 1);
      along[c][0] = -(along[c][1] + along[c][2] + along[c][3]);
    }
    for (int c = 0; c < 4; ++c) {
      if (c > 0) *reinterpret_cast<Lanes*>(forces.at[c - 1][x]) = along[c][c];
      for (int j = c + 1; j < 4; ++j)
        *reinterpret_cast<Lanes*>(forces.at[kNodeAt[c][j] - 1][x]) = along[c][j] + along[j][c];
    }
  }
}

// Subtracts the forces of all nodes from `column`, the right-hand side of one pair.
template <int kOrder>
[[gnu::always_inline]] inline void subtract_forces(const LaneForces<kOrder>& forces,
                                                   const Corners& corners, double* column) {
  constexpr int kOthers = nodes_of_order(kOrder) - 1;
  for (std::size_t lane = 0; lane < kLanes; ++lane)
    for (int x = 0; x < 3; ++x) {
      double sum = forces.at[0][x][lane];
      for (int i = 1; i < kOthers; ++i) sum += forces.at[i][x][lane];
      if (corners.rows[0][lane] >= 0) column[corners.rows[0][lane] + x] -= sum;
      for (int i = 0; i < kOthers; ++i)
        if (corners.rows[i + 1][lane] >= 0)
          column[corners.rows[i + 1][lane] + x] += forces.at[i][x][lane];
    }
}

template <int kOrder, class Law>
[[gnu::always_inline]] inline void subtract_with(const Solid& solid,
                                                 const std::vector<int>& elements,
                                                 const BasisRows& fields,
                                                 const std::vector<ColumnPair>& pairs,
                                                 const std::vector<int>& row_of_vertex, double* out,
                                                 std::size_t stride) {
  Law law(solid);
  const std::span<const SamplePoint> points = sample_points(kOrder, 3);
  const std::size_t count = fields.cols(), each = gradients_of_order(kOrder);
  std::vector<LaneGradient> gradients(count * each);
  std::vector<LaneSample> samples(count * points.size());
  Corners corners;
  for (std::size_t first = 0; first < elements.size(); first += kLanes) {
    const std::size_t width = std::min(kLanes, elements.size() - first);
    load_gradients(solid, fields, elements.data() + first, width, gradients);
    load_corners(solid, elements.data() + first, width, row_of_vertex, corners);
    law.load(solid, elements.data() + first, width);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t p = 0; p < points.size(); ++p) {
        LaneSample& sample = samples[i * points.size() + p];
        gradient_at<kOrder>(gradients.data() + i * each, points[p], sample.gradient);
        const Lanes* g = sample.gradient;
        sample.stress = law.stress(g[0], g[4], g[8], 0.5 * (g[5] + g[7]), 0.5 * (g[2] + g[6]),
                                   0.5 * (g[1] + g[3]));
      }
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      LaneForces<kOrder> forces;
      pair_forces(law, samples.data() + pairs[p].i * points.size(),
                  samples.data() + pairs[p].j * points.size(), corners, forces);
      subtract_forces(forces, corners, out + p * stride);
    }
  }
}

TREMOLO_CLONES void subtract_uniform_linear(const Solid& solid, const std::vector<int>& elements,
                                            const BasisRows& fields,
                                            const std::vector<ColumnPair>& pairs,
                                            const std::vector<int>& row_of_vertex, double* out,
                                            std::size_t stride) {
  subtract_with<1, UniformLaw>(solid, elements, fields, pairs, row_of_vertex, out, stride);
}

TREMOLO_CLONES void subtract_general_linear(const Solid& solid, const std::vector<int>& elements,
                                            const BasisRows& fields,
                                            const std::vector<ColumnPair>& pairs,
                                            const std::vector<int>& row_of_vertex, double* out,
                                            std::size_t stride) {
  subtract_with<1, GeneralLaw>(solid, elements, fields, pairs, row_of_vertex, out, stride);
}

TREMOLO_CLONES void subtract_uniform_quadratic(const Solid& solid, const std::vector<int>& elements,
                                               const BasisRows& fields,
                                               const std::vector<ColumnPair>& pairs,
                                               const std::vector<int>& row_of_vertex, double* out,
                                               std::size_t stride) {
  subtract_with<2, UniformLaw>(solid, elements, fields, pairs, row_of_vertex, out, stride);
}

TREMOLO_CLONES void subtract_general_quadratic(const Solid& solid, const std::vector<int>& elements,
                                               const BasisRows& fields,
                                               const std::vector<ColumnPair>& pairs,
                                               const std::vector<int>& row_of_vertex, double* out,
                                               std::size_t stride) {
  subtract_with<2, GeneralLaw>(solid, elements, fields, pairs, row_of_vertex, out, stride);
}

}  // namespace

void subtract_second_derivatives(const Solid& solid, const std::vector<int>& elements,
                                 const BasisRows& fields, const std::vector<ColumnPair>& pairs,
                                 const std::vector<int>& row_of_vertex, double* out,
                                 std::size_t stride) {
  const auto linear = solid.uniform() ? subtract_uniform_linear : subtract_general_linear;
  const auto quadratic = solid.uniform() ? subtract_uniform_quadratic : subtract_general_quadratic;
  (solid.order() == 1 ? linear : quadratic)(solid, elements, fields, pairs, row_of_vertex, out,
                                            stride);
}

}  // namespace tremolo
