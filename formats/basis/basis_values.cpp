// Sections of a basis file -> numbers.
#include <cmath>

#include "common/packed_index.h"
#include "formats/basis/basis_reader.h"
#include "formats/basis/compact_values.h"

namespace tremolo {

using namespace basis_layout;

Result<std::span<const double>> BasisReader::doubles(std::string_view name) {
  return file_.finite<double>(name);
}

Result<std::span<const float>> BasisReader::floats(std::string_view name) {
  return file_.finite<float>(name);
}

Result<std::span<const std::uint8_t>> BasisReader::bytes(std::string_view name) {
  return file_.elements<std::uint8_t>(name);
}

Result<std::string_view> BasisReader::text(std::string_view name) {
  return file_.text(name);
}

Result<std::span<const std::uint32_t>> BasisReader::indices(std::string_view name,
                                                            std::uint64_t bound) {
  Result<std::span<const std::uint32_t>> values = file_.elements<std::uint32_t>(name);
  if (!values) return values;
  for (std::size_t i = 0; i < values->size(); ++i)
    if (const std::uint32_t value = (*values)[i]; value >= bound)
      return file_.error_at(
          name, file_.find(name)->offset + i * sizeof(value),
          "index " + std::to_string(value) + " is not below " + std::to_string(bound));
  return values;
}

Result<std::vector<Eigen::Vector3d>> BasisReader::points(std::string_view name) {
  const Result<std::span<const double>> values = doubles(name);
  if (!values) return values.error();
  std::vector<Eigen::Vector3d> points(values->size() / 3);
  for (std::size_t v = 0; v < points.size(); ++v)
    points[v] = Eigen::Map<const Eigen::Vector3d>(values->data() + 3 * v);
  return points;
}

Result<std::vector<Triangle>> BasisReader::triangles(std::string_view name, std::uint64_t bound) {
  const Result<std::span<const std::uint32_t>> ids = indices(name, bound);
  if (!ids) return ids.error();
  std::vector<Triangle> triangles(ids->size() / 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    std::copy_n(ids->data() + 3 * t, 3, triangles[t].begin());
  return triangles;
}

Result<std::span<const double>> BasisReader::scales(std::string_view name) {
  Result<std::span<const double>> values = doubles(name);
  if (!values) return values;
  for (std::size_t i = 0; i < values->size(); ++i)
    if (!is_scale((*values)[i]))
      return file_.error_at(name, file_.find(name)->offset + i * sizeof(double),
                            "a scale is not positive or too large");
  return values;
}

Result<std::vector<double>> BasisReader::coefficients(std::string_view name) {
  std::vector<double> values;
  if (!compact()) {
    if (Status status = take(values, doubles(name)); !status) return status.error();
    return values;
  }
  const Result<std::span<const double>> both = scales(kCoefficientScales);
  if (!both) return both.error();
  const double scale =
      (*both)[name == kCubic ? coefficient_scale::kCubic : coefficient_scale::kQuartic];
  const Result<std::span<const float>> rounded = file_.elements<float>(name);
  if (!rounded) return rounded.error();
  values.reserve(rounded->size());
  for (std::size_t i = 0; i < rounded->size(); ++i) {
    values.push_back(scale * (*rounded)[i]);
    if (!std::isfinite(values[i]))
      return file_.error_at(name, file_.find(name)->offset + i * sizeof(float),
                            "a value is not finite");
  }
  return values;
}

Result<std::vector<double>> BasisReader::strain_gram() {
  std::vector<double> values;
  if (!has(kStrainGram)) return values;
  if (!compact()) {
    if (Status status = take(values, doubles(kStrainGram)); !status) return status.error();
  } else {
    const Result<std::span<const double>> scale = scales(kStrainScale);
    if (!scale) return scale.error();
    const Result<std::span<const float>> rounded = floats(kStrainGram);
    if (!rounded) return rounded.error();
    for (const float value : *rounded) values.push_back(scale->front() * value);
  }
  const std::size_t size = compact() ? sizeof(float) : sizeof(double);
  for (std::size_t a = 0; pair_index(a, a) < values.size(); ++a)
    if (const std::size_t i = pair_index(a, a); !(values[i] >= 0.0) || !std::isfinite(values[i]))
      return file_.error_at(kStrainGram, file_.find(kStrainGram)->offset + i * size,
                            "an entry of the diagonal is negative or too large");
  return values;
}

Result<BasisRows> BasisReader::basis_rows(std::string_view name) {
  const Eigen::Index columns = dimensions_.modes;
  if (!compact()) {
    const Result<std::span<const double>> values = doubles(name);
    if (!values) return values.error();
    return BasisRows(
        Eigen::Map<const BasisRows>(values->data(), std::ssize(*values) / columns, columns));
  }
  const Result<std::span<const double>> column_scale = scales(kBasisScales);
  if (!column_scale) return column_scale.error();
  const Result<std::span<const std::int16_t>> integers = file_.elements<std::int16_t>(name);
  if (!integers) return integers.error();
  BasisRows rows(std::ssize(*integers) / columns, columns);
  const std::int16_t* next = integers->data();
  for (Eigen::Index row = 0; row < rows.rows(); ++row)
    for (Eigen::Index i = 0; i < columns; ++i) rows(row, i) = (*column_scale)[i] * *next++;
  return rows;
}

Result<Eigen::VectorXd> BasisReader::column_scales() {
  if (!compact()) return Eigen::VectorXd();
  const Result<std::span<const double>> columns = scales(kBasisScales);
  if (!columns) return columns.error();
  return Eigen::VectorXd(Eigen::VectorXd::Map(columns->data(), std::ssize(*columns)));
}

Result<VertexBlock> BasisReader::vertex_block(std::string_view ids, std::string_view rest,
                                              std::string_view basis) {
  VertexBlock block;
  if (Status s = take(block.vertex_ids, indices(ids, dimensions_.vertices)); !s) return s.error();
  for (std::size_t i = 1; i < block.vertex_ids.size(); ++i)
    if (block.vertex_ids[i - 1] >= block.vertex_ids[i])
      return file_.error_at(ids, file_.find(ids)->offset + sizeof(VertexId) * i,
                            "the ids do not ascend");
  if (Status s = take(block.rest, points(rest)); !s) return s.error();
  if (Status s = take(block.rows, basis_rows(basis)); !s) return s.error();
  if (Status s = take(block.column_scales, column_scales()); !s) return s.error();
  return block;
}

}  // namespace tremolo
