#include "precompute/reduction/encoding_error.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/energy.h"
#include "common/mesh/surface_mesh.h"
#include "formats/basis/basis_reader.h"
#include "formats/basis/basis_writer.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kReach = 0.1;  // largest displacement of the check, relative to the size

double size_of(const BasisData& data) {
  std::vector<Eigen::Vector3d> vertices = data.surface.rest;
  vertices.insert(vertices.end(), data.interior.rest.begin(), data.interior.rest.end());
  return bounding_box(vertices).diagonal();
}

double largest_move(const BasisRows& rows, const VectorXd& q) {
  double largest = 0.0;
  for (Index row = 0; row < rows.rows(); row += 3)
    largest = std::max(largest, (rows.middleRows(row, 3) * q).norm());
  return largest;
}

double largest_move(const BasisData& data, const VectorXd& q) {
  return std::max(largest_move(data.surface.rows, q), largest_move(data.interior.rows, q));
}

// Returns U^T f of the default load, or the first unit vector.
VectorXd reduced_load(const BasisData& data) {
  VectorXd load = VectorXd::Zero(data.lambda.size());
  for (std::size_t i = 0; i < data.load.vertices.size(); ++i)
    for (const VertexBlock* block : {&data.surface, &data.interior}) {
      const auto at = find_vertex(block->vertex_ids, data.load.vertices[i]);
      if (at) load += block->rows.middleRows(3 * *at, 3).transpose() * data.load.forces[i];
    }
  // A load on fixed vertices only has no effect.
  if (load.isZero(0.0)) load[0] = 1.0;
  return load;
}

// Returns for each coordinate the value at which it alone moves some vertex by `reach`.
VectorXd amplitudes(const BasisData& data, double reach) {
  VectorXd largest = VectorXd::Zero(data.lambda.size());
  for (const BasisRows* rows : {&data.surface.rows, &data.interior.rows})
    for (Index row = 0; row < rows->rows(); row += 3)
      largest = largest.cwiseMax(rows->middleRows(row, 3).colwise().norm().transpose());
  return (largest.array() > 0.0).select(reach / largest.array(), 0.0);
}

// Returns the largest length, over the vertices, of the vector with components sum_i |a_i| |U_c,i -
// U_i|.
double largest_sum(const BasisRows& a, const BasisRows& b, const VectorXd& amplitude) {
  double largest = 0.0;
  for (Index row = 0; row < a.rows(); row += 3)
    largest = std::max(
        largest, ((a.middleRows(row, 3) - b.middleRows(row, 3)).cwiseAbs() * amplitude).norm());
  return largest;
}

}  // namespace

EncodingError encoding_error(const BasisData& full, const BasisData& kept) {
  const double size = size_of(full);
  const double reach = kReach * size;
  VectorXd q = reduced_load(full).cwiseQuotient(full.lambda);
  q *= reach / largest_move(full, q);
  const VectorXd amplitude = amplitudes(full, reach);
  EncodingError error;
  std::vector<std::pair<const BasisRows*, const BasisRows*>> pairs = {
      {&kept.surface.rows, &full.surface.rows}, {&kept.interior.rows, &full.interior.rows}};
  if (full.render) pairs.emplace_back(&kept.render->rows, &full.render->rows);
  for (const auto& [a, b] : pairs) {
    const BasisRows difference = *a - *b;
    error.displacement = std::max(error.displacement, largest_move(difference, q) / size);
    error.displacement_bound =
        std::max(error.displacement_bound, largest_sum(*a, *b, amplitude) / size);
  }
  if (!full.quartic.empty())
    error.force = (reduced_energy(kept.lambda, kept.cubic, kept.quartic, q).force -
                   reduced_energy(full.lambda, full.cubic, full.quartic, q).force)
                      .norm() /
                  full.lambda.cwiseProduct(q).norm();
  return error;
}

Result<EncodingError> compact_error(const BasisData& full) {
  const Result<std::vector<std::byte>> bytes = encode_basis(full, BasisEncoding::kCompact);
  if (!bytes) return bytes.error();
  Result<BasisReader> reader = BasisReader::from_memory(*bytes);
  if (!reader) return reader.error();
  const Result<BasisData> kept = read_basis(*reader);
  if (!kept) return kept.error();
  return encoding_error(full, *kept);
}

}  // namespace tremolo
