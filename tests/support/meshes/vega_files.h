// VegaFEM's binary files, written by hand, and reduced forces whose values are known in closed
// form.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"
#include "tests/support/meshes/small_mesh.h"
#include "tests/support/sample_basis.h"

namespace tremolo::testing {

inline void put_name(ByteWriter& bytes, const std::string& name) {
  bytes.put(static_cast<std::int32_t>(name.size())).text(name);
}

// A mesh with a material of each kind, the set `first` of element 0, and two regions.
inline std::string vegb_bytes(const TetMesh& mesh) {
  ByteWriter bytes(false);
  const auto i32 = [&bytes](std::size_t value) { bytes.put(static_cast<std::int32_t>(value)); };
  bytes.put(1.0);
  i32(1);
  i32(mesh.vertices.size());
  for (const Eigen::Vector3d& x : mesh.vertices) bytes.put(x);
  i32(mesh.tetrahedra.size());
  i32(4);
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (VertexId v : tet) bytes.put(v);
  const std::vector<std::vector<double>> properties{
      {1000.0, 1e6, 0.45},
      {1100.0, 1e6, 2e6, 3e6, 0.1, 0.2, 0.3, 4e5, 5e5, 6e5, 1, 0, 0, 0, 1, 0, 0, 0, 1},
      {900.0, 1e4, 2e4, 3e4}};
  i32(properties.size());
  for (std::size_t kind = 0; kind < properties.size(); ++kind) {
    put_name(bytes, "material " + std::to_string(kind));
    i32(kind + 1);
    for (double value : properties[kind]) bytes.put(value);
  }
  i32(2);  // of which the first, all elements, is not stored
  put_name(bytes, "first");
  i32(1);
  i32(0);
  i32(2);
  for (std::size_t value : {0u, 0u, 2u, 1u}) i32(value);
  return bytes.str();
}

inline std::string basis_file(const Eigen::MatrixXd& basis) {
  ByteWriter bytes(false);
  bytes.put(static_cast<std::int32_t>(basis.rows())).put(static_cast<std::int32_t>(basis.cols()));
  for (double value : basis.reshaped()) bytes.put(value);
  return bytes.str();
}

// The index of every monomial of order d over r coordinates in lexicographic order, by counting.
inline std::map<std::vector<int>, std::size_t> monomials(int r, std::size_t order) {
  std::map<std::vector<int>, std::size_t> places;
  std::vector<int> index(order, 0);
  while (true) {
    if (std::is_sorted(index.begin(), index.end())) places.emplace(index, 0);
    std::size_t at = order;
    while (at > 0 && index[at - 1] == r - 1) --at;
    if (at == 0) break;
    ++index[at - 1];
    std::fill(index.begin() + static_cast<std::ptrdiff_t>(at), index.end(), 0);
  }
  std::size_t place = 0;
  for (auto& [monomial, number] : places) number = place++;
  return places;
}

// Rows of force components over the monomials of orders 1, 2, 3, as a .cub has them.
struct ForceRows {
  Eigen::MatrixXd rows[3];
};

// The force of sample_basis.h's strain model over coordinates y, q = turn y. Written out term by
// term: with w_e = omega_e times row e of the turn and b_e = turn^T B_e turn,
//   f_i = sum_e (w_e y + y^T b_e y) (w_ei + 2 (b_e y)_i).
inline ForceRows turned_forces(const StrainModel& model, const Eigen::MatrixXd& turn) {
  const int r = static_cast<int>(model.omega.size());
  ForceRows forces;
  const std::map<std::vector<int>, std::size_t> place[3] = {monomials(r, 1), monomials(r, 2),
                                                            monomials(r, 3)};
  for (int order = 0; order < 3; ++order) forces.rows[order].setZero(r, place[order].size());
  const auto at = [&](int i, std::vector<int> monomial) -> double& {
    std::sort(monomial.begin(), monomial.end());
    const std::size_t order = monomial.size() - 1;
    return forces.rows[order](i, static_cast<Eigen::Index>(place[order].at(monomial)));
  };
  for (int e = 0; e < r; ++e) {
    const Eigen::VectorXd w = model.omega[e] * turn.row(e).transpose();
    const Eigen::MatrixXd b = turn.transpose() * model.b[e] * turn;
    for (int i = 0; i < r; ++i)
      for (int j = 0; j < r; ++j) {
        at(i, {j}) += w[i] * w[j];
        for (int k = 0; k < r; ++k) {
          at(i, {j, k}) += w[i] * b(j, k) + 2.0 * w[j] * b(i, k);
          for (int l = 0; l < r; ++l) at(i, {j, k, l}) += 2.0 * b(j, k) * b(i, l);
        }
      }
  }
  return forces;
}

// Forces at y, monomial by monomial.
inline Eigen::VectorXd evaluate_rows(const ForceRows& forces, const Eigen::VectorXd& y) {
  const int r = static_cast<int>(y.size());
  Eigen::VectorXd result = Eigen::VectorXd::Zero(r);
  for (std::size_t order = 0; order < 3; ++order)
    for (const auto& [monomial, place] : monomials(r, order + 1)) {
      double product = 1.0;
      for (int index : monomial) product *= y[index];
      result += product * forces.rows[order].col(place);
    }
  return result;
}

inline std::string cub_file(const ForceRows& forces) {
  ByteWriter bytes(false);
  bytes.put(static_cast<std::int32_t>(forces.rows[0].rows()));
  for (const Eigen::MatrixXd& rows : forces.rows) bytes.put(static_cast<std::int32_t>(rows.cols()));
  for (const Eigen::MatrixXd& rows : forces.rows)
    for (double value : rows.reshaped<Eigen::RowMajor>()) bytes.put(value);
  return bytes.str();
}

// A .cub's numbers again, without the product's reader.
inline ForceRows parse_cub(const std::string& bytes) {
  std::int32_t counts[4];
  std::memcpy(counts, bytes.data(), sizeof(counts));
  ForceRows forces;
  std::size_t at = sizeof(counts);
  for (int order = 0; order < 3; ++order) {
    forces.rows[order].resize(counts[0], counts[order + 1]);
    for (double& value : forces.rows[order].reshaped<Eigen::RowMajor>()) {
      std::memcpy(&value, bytes.data() + at, sizeof(value));
      at += sizeof(value);
    }
  }
  return forces;
}

// Orthogonal, full.
inline Eigen::MatrixXd random_turn(Eigen::Index r, unsigned seed) {
  Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(r, r);
  for (unsigned n = 0; n < 3; ++n) {
    const Eigen::VectorXd v = random_vector(r, 1.0, seed + n).normalized();
    turn -= 2.0 * v * (v.transpose() * turn);
  }
  return turn;
}

}  // namespace tremolo::testing
