#include "formats/basis/compact_values.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <tuple>

#include "common/packed_index.h"

namespace tremolo {
namespace {

constexpr double kLargest = 32767.0;

Error not_finite(const char* name) {
  return content_error(std::string("basis data: a value of '") + name + "' is not finite");
}

// Adds the scale to `scales`.
Status round_coefficients(const std::vector<double>& values, const char* name,
                          std::vector<double>& scales, std::vector<float>& rounded) {
  double largest = 0.0;
  for (const double value : values) {
    if (!std::isfinite(value)) return not_finite(name);
    largest = std::max(largest, std::abs(value));
  }
  // Coefficients carry kg^-3/2 and kg^-2: those of a crumb would not fit the range of f32.
  const double scale =
      largest > 0.0 ? std::ldexp(1.0, std::clamp(std::ilogb(largest), -1000, 1000)) : 1.0;
  scales.push_back(scale);
  rounded.reserve(values.size());
  for (const double value : values) rounded.push_back(static_cast<float>(value / scale));
  return Success{};
}

// Rounding changes an entry G_ab by at most 2^-24 (G_aa G_bb)^1/2, so that the matrix loses at most
// c 2^-24 times its diagonal.
void round_strain_gram(const std::vector<double>& gram, CompactValues& compact) {
  const std::vector<double>& scale = compact.strain_scale;
  std::size_t terms = 0;
  while (pair_count(terms) < gram.size()) ++terms;
  const double grown = 1.0 + static_cast<double>(terms + 1) * std::ldexp(1.0, -24);
  for (std::size_t a = 0; a < terms; ++a) {
    const std::size_t i = pair_index(a, a);
    compact.strain_gram[i] = static_cast<float>(grown * gram[i] / scale.front());
  }
}

// The rows of a basis, their name in messages, and the target of their integers.
struct Block {
  const BasisRows* rows;
  const char* name;
  std::vector<std::int16_t>* integers;
};

Status find_scales(std::span<const Block> blocks, std::vector<double>& scales) {
  for (const Block& block : blocks)
    if (!block.rows->allFinite()) return not_finite(block.name);
  Eigen::RowVectorXd largest = Eigen::RowVectorXd::Zero(scales.size());
  for (const Block& block : blocks)
    for (const auto& row : block.rows->rowwise()) largest = largest.cwiseMax(row.cwiseAbs());
  for (std::size_t i = 0; i < scales.size(); ++i) {
    scales[i] = largest[i] / kLargest > 0.0 ? largest[i] / kLargest : 1.0;
    if (!is_scale(scales[i])) return content_error("basis data: a basis row is too large");
  }
  return Success{};
}

void round_rows(const Block& block, std::span<const double> scales) {
  block.integers->reserve(block.rows->size());
  for (Eigen::Index row = 0; row < block.rows->rows(); ++row)
    for (Eigen::Index i = 0; i < block.rows->cols(); ++i) {
      const double rounded = std::nearbyint((*block.rows)(row, i) / scales[i]);
      block.integers->push_back(
          static_cast<std::int16_t>(std::clamp(rounded, -kLargest, kLargest)));
    }
}

}  // namespace

Result<CompactValues> compact_values(const BasisData& data) {
  CompactValues compact;
  for (const auto& [values, name, rounded] :
       {std::tuple{&data.cubic, "cubic", &compact.cubic},
        std::tuple{&data.quartic, "quartic", &compact.quartic}})
    if (Status s = round_coefficients(*values, name, compact.coefficient_scales, *rounded); !s)
      return s.error();
  if (!data.strain_gram.empty()) {
    if (Status s = round_coefficients(data.strain_gram, "strain_gram", compact.strain_scale,
                                      compact.strain_gram);
        !s)
      return s.error();
    round_strain_gram(data.strain_gram, compact);
  }
  std::vector<Block> blocks = {{&data.surface.rows, "surface", &compact.surface},
                               {&data.interior.rows, "interior", &compact.interior}};
  if (data.render) blocks.push_back({&data.render->rows, "render", &compact.render});
  compact.basis_scales.resize(data.lambda.size());
  if (Status s = find_scales(blocks, compact.basis_scales); !s) return s.error();
  for (const Block& block : blocks) round_rows(block, compact.basis_scales);
  return compact;
}

bool is_scale(double scale) {
  return scale > 0.0 && std::isfinite(32768.0 * scale);
}

}  // namespace tremolo
