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

// Geometry of a group of elements. rows: offsets of the four corners in `out`; -1 if there is none.
struct Corners {
  Lanes gradients[3][3];  // [axis][corner 1..3], times -volume; corner 0 is minus their sum
  int rows[4][kLanes];
};

[[gnu::always_inline]] inline void load_corners(const Solid& solid, const int* elements,
                                                std::size_t count,
                                                const std::vector<int>& row_of_vertex,
                                                Corners& corners) {
  corners = {};
  for (std::size_t lane = 0; lane < count; ++lane) {
    const std::size_t e = elements[lane];
    const StrainSample& sample = solid.samples[e];
    for (int d = 0; d < 3; ++d)
      for (int a = 0; a < 3; ++a)
        corners.gradients[d][a][lane] = -sample.weight * sample.gradients(d, a + 1);
    for (int a = 0; a < 4; ++a) corners.rows[a][lane] = row_of_vertex[solid.mesh.tetrahedra[e][a]];
  }
  for (std::size_t lane = count; lane < kLanes; ++lane)
    for (int a = 0; a < 4; ++a) corners.rows[a][lane] = -1;
}

}  // namespace

TREMOLO_CLONES void load_gradients(const Solid& solid, const BasisRows& fields, const int* elements,
                                   std::size_t count, std::vector<LaneGradient>& out) {
  const std::size_t fields_count = fields.cols();
  if (count < kLanes)
    for (LaneGradient& gradient : out) gradient = {};
  auto* entries = reinterpret_cast<double*>(out.data());
  for (std::size_t lane = 0; lane < count; ++lane) {
    const std::size_t e = elements[lane];
    const StrainSample& sample = solid.samples[e];
    const Tetrahedron& tet = solid.mesh.tetrahedra[e];
    for (std::size_t x = 0; x < 3; ++x) {
      const double* rows[4];
      for (std::size_t a = 0; a < 4; ++a)
        rows[a] = fields.data() + (3 * static_cast<std::size_t>(tet[a]) + x) * fields_count;
      for (std::size_t d = 0; d < 3; ++d) {
        const double* n = sample.gradients.data() + d;  // column-major, 3 x 4
        double* entry = entries + (3 * x + d) * kLanes + lane;
        for (std::size_t i = 0; i < fields_count; ++i)
          entry[i * 9 * kLanes] =
              rows[0][i] * n[0] + rows[1][i] * n[3] + rows[2][i] * n[6] + rows[3][i] * n[9];
      }
    }
  }
}

namespace {

// Forces on the corners 1..3 of eight elements: [corner][axis][lane]; corner 0 has minus their sum.
struct alignas(8 * kLanes) CornerForces {
  double at[3][3][kLanes];
};

// S(sym(A^T B)) + A S(sym B) + B S(sym A), contracted with the corners' gradients. a, b:
// displacement gradients; sa, sb: the stresses of their symmetric parts.
template <class Law>
[[gnu::always_inline]] inline void pair_forces(const Law& law, const Lanes* a, const Lanes* b,
                                               const Lanes* sa, const Lanes* sb,
                                               const Corners& corners, CornerForces& forces) {
  const LaneStress s = law.stress(
      a[0] * b[0] + a[3] * b[3] + a[6] * b[6], a[1] * b[1] + a[4] * b[4] + a[7] * b[7],
      a[2] * b[2] + a[5] * b[5] + a[8] * b[8],
      0.5 * (a[1] * b[2] + a[4] * b[5] + a[7] * b[8] + a[2] * b[1] + a[5] * b[4] + a[8] * b[7]),
      0.5 * (a[0] * b[2] + a[3] * b[5] + a[6] * b[8] + a[2] * b[0] + a[5] * b[3] + a[8] * b[6]),
      0.5 * (a[0] * b[1] + a[3] * b[4] + a[6] * b[7] + a[1] * b[0] + a[4] * b[3] + a[7] * b[6]));
  // Index of entry (row, column) of a symmetric matrix in the order xx yy zz yz xz xy.
  constexpr int kAt[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};
  for (int x = 0; x < 3; ++x) {
    Lanes piola[3];
    for (int d = 0; d < 3; ++d) {
      piola[d] = s.at[kAt[x][d]];
      for (int c = 0; c < 3; ++c)
        piola[d] += a[3 * x + c] * sb[kAt[c][d]] + b[3 * x + c] * sa[kAt[c][d]];
    }
    for (int corner = 0; corner < 3; ++corner)
      *reinterpret_cast<Lanes*>(forces.at[corner][x]) = piola[0] * corners.gradients[0][corner] +
                                                        piola[1] * corners.gradients[1][corner] +
                                                        piola[2] * corners.gradients[2][corner];
  }
}

// Subtracts the forces of all four corners from `column`, the right-hand side of one pair.
[[gnu::always_inline]] inline void subtract_forces(const CornerForces& forces,
                                                   const Corners& corners, double* column) {
  for (std::size_t lane = 0; lane < kLanes; ++lane)
    for (int x = 0; x < 3; ++x) {
      const double f[3] = {forces.at[0][x][lane], forces.at[1][x][lane], forces.at[2][x][lane]};
      if (corners.rows[0][lane] >= 0) column[corners.rows[0][lane] + x] -= f[0] + f[1] + f[2];
      for (int corner = 0; corner < 3; ++corner)
        if (corners.rows[corner + 1][lane] >= 0)
          column[corners.rows[corner + 1][lane] + x] += f[corner];
    }
}

template <class Law>
[[gnu::always_inline]] inline void subtract_with(const Solid& solid,
                                                 const std::vector<int>& elements,
                                                 const BasisRows& fields,
                                                 const std::vector<ColumnPair>& pairs,
                                                 const std::vector<int>& row_of_vertex, double* out,
                                                 std::size_t stride) {
  Law law(solid);
  const std::size_t count = fields.cols();
  std::vector<LaneGradient> gradients(count);
  struct alignas(8 * kLanes) Stress : LaneStress {};
  std::vector<Stress> stresses(count);
  Corners corners;
  for (std::size_t first = 0; first < elements.size(); first += kLanes) {
    const std::size_t width = std::min(kLanes, elements.size() - first);
    load_gradients(solid, fields, elements.data() + first, width, gradients);
    load_corners(solid, elements.data() + first, width, row_of_vertex, corners);
    law.load(solid, elements.data() + first, width);
    for (std::size_t i = 0; i < count; ++i) {
      const Lanes* g = gradients[i].at;
      static_cast<LaneStress&>(stresses[i]) = law.stress(g[0], g[4], g[8], 0.5 * (g[5] + g[7]),
                                                         0.5 * (g[2] + g[6]), 0.5 * (g[1] + g[3]));
    }
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      const Lanes* a = gradients[pairs[p].i].at;
      const Lanes* b = gradients[pairs[p].j].at;
      const Lanes* sa = stresses[pairs[p].i].at;
      const Lanes* sb = stresses[pairs[p].j].at;
      CornerForces forces;
      pair_forces(law, a, b, sa, sb, corners, forces);
      subtract_forces(forces, corners, out + p * stride);
    }
  }
}

TREMOLO_CLONES void subtract_uniform(const Solid& solid, const std::vector<int>& elements,
                                     const BasisRows& fields, const std::vector<ColumnPair>& pairs,
                                     const std::vector<int>& row_of_vertex, double* out,
                                     std::size_t stride) {
  subtract_with<UniformLaw>(solid, elements, fields, pairs, row_of_vertex, out, stride);
}

TREMOLO_CLONES void subtract_general(const Solid& solid, const std::vector<int>& elements,
                                     const BasisRows& fields, const std::vector<ColumnPair>& pairs,
                                     const std::vector<int>& row_of_vertex, double* out,
                                     std::size_t stride) {
  subtract_with<GeneralLaw>(solid, elements, fields, pairs, row_of_vertex, out, stride);
}

}  // namespace

void subtract_second_derivatives(const Solid& solid, const std::vector<int>& elements,
                                 const BasisRows& fields, const std::vector<ColumnPair>& pairs,
                                 const std::vector<int>& row_of_vertex, double* out,
                                 std::size_t stride) {
  const auto subtract = solid.uniform() ? subtract_uniform : subtract_general;
  subtract(solid, elements, fields, pairs, row_of_vertex, out, stride);
}

}  // namespace tremolo
