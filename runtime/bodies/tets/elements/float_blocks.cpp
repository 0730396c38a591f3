#include "runtime/bodies/tets/elements/float_blocks.h"

#include "common/processor.h"
#include "runtime/bodies/tets/elements/quads.h"

namespace tremolo {
namespace {

using std::size_t;

typedef float Sixteen __attribute__((vector_size(64), may_alias));

// Weights of the mass, one per block, zero after the last.
struct MassShares {
  alignas(64) float quadratic[kQuadraticPlaces] = {};
  alignas(64) float linear[kLinearPlaces] = {};

  MassShares() {
    for (int i = 0; i < kMostNodes; ++i)
      for (int j = 0; j <= i; ++j) {
        const size_t k = node_block(static_cast<size_t>(i), static_cast<size_t>(j));
        quadratic[k] = static_cast<float>(mass_share(2, i, j));
        if (i < 4) linear[k] = static_cast<float>(mass_share(1, i, j));
      }
  }
};
const MassShares& mass_shares() {
  static const MassShares shares;
  return shares;
}

// Blocks of an element are not grouped.
constexpr size_t kLocalBlock = 12;

[[gnu::always_inline]] inline QuadBlock& block_at(float* blocks, size_t place) {
  return *reinterpret_cast<QuadBlock*>(blocks + kLocalBlock * place);
}

[[gnu::always_inline]] inline QuadBlock scaled(const QuadBlock& block, float factor) {
  return {{factor * block.column[0], factor * block.column[1], factor * block.column[2]}};
}

[[gnu::always_inline]] inline void add_quads(const QuadBlock& block, QuadBlock& to) {
  for (size_t j = 0; j < 3; ++j) to.column[j] += block.column[j];
}

// Adds a block of row r and column c.
[[gnu::always_inline]] inline void add_local(float* local, size_t r, size_t c,
                                             const QuadBlock& block) {
  if (r >= c)
    add_quads(block, block_at(local, node_block(r, c)));
  else
    add_quads(transposed(block), block_at(local, node_block(c, r)));
}

// B <- E^T B E: rows and columns of linear edges are added half and half to their ends.
[[gnu::always_inline]] inline void fold_local(unsigned linear, float* local) {
  for (size_t e = 0; e < 6; ++e) {
    if ((linear >> e & 1U) == 0) continue;
    const size_t i = 4 + e;
    const size_t ends[2] = {static_cast<size_t>(kTetEdges[e][0]),
                            static_cast<size_t>(kTetEdges[e][1])};
    for (size_t j = 0; j < kMostNodes; ++j) {
      if (j == i || (j >= 4 && j < i && (linear >> (j - 4) & 1U) != 0)) continue;
      const QuadBlock own =
          j < i ? block_at(local, node_block(i, j)) : transposed(block_at(local, node_block(j, i)));
      const QuadBlock half = scaled(own, 0.5F);
      for (const size_t end : ends) {
        add_local(local, end, j, half);
        if (j == end) add_quads(transposed(half), block_at(local, node_block(end, end)));
      }
    }
    const QuadBlock quarter = scaled(block_at(local, node_block(i, i)), 0.25F);
    for (const size_t end : ends) add_quads(quarter, block_at(local, node_block(end, end)));
    add_local(local, ends[0], ends[1], quarter);
  }
}

[[gnu::always_inline]] inline void add_to_group(const QuadBlock& block, float* at) {
  for (size_t j = 0; j < 3; ++j)
    *reinterpret_cast<Quad*>(at + kColumnStride * j) += block.column[j];
}

// Adds an element's blocks to the matrix.
[[gnu::always_inline]] inline void scatter_local(const FloatElement& element, float* local,
                                                 const FloatTarget& target) {
  const unsigned folded = element.straight() ? 0U : element.linear << 4U;
  const size_t nodes = element.straight() ? 4 : kMostNodes;
  if (folded != 0) fold_local(element.linear, local);
  for (size_t i = 0; i < nodes; ++i)
    for (size_t j = 0; j <= i; ++j) {
      if (((folded >> i | folded >> j) & 1U) != 0) continue;
      const size_t k = node_block(i, j);
      const BlockPlace place = element.places[k];
      const std::uint32_t at = target.at[place.place];
      if (at == kNowhere) continue;
      const QuadBlock own = block_at(local, k);
      add_to_group(place.turned ? transposed(own) : own, target.blocks + first_float(at));
    }
}

// Sixteen blocks R K R^T plus weights times the mass; the entries are `stride` apart.
[[gnu::always_inline]] inline void turn_sixteen(const float* k, size_t stride, const float* r,
                                                float factor, float mass, const float* shares,
                                                float* out) {
  const auto entry = [&](size_t i, size_t j) {
    return *reinterpret_cast<const Sixteen*>(k + stride * (3 * j + i));
  };
  Sixteen half[9];  // K R^T
  for (size_t j = 0; j < 3; ++j)
    for (size_t i = 0; i < 3; ++i)
      half[3 * j + i] = entry(i, 0) * r[j] + entry(i, 1) * r[3 + j] + entry(i, 2) * r[6 + j];
  alignas(64) float columns[3][16];
  for (size_t j = 0; j < 3; ++j) {
    for (size_t i = 0; i < 3; ++i) {
      Sixteen sum = half[3 * j] * r[i] + half[3 * j + 1] * r[3 + i] + half[3 * j + 2] * r[6 + i];
      sum *= factor;
      if (i == j) sum += mass * *reinterpret_cast<const Sixteen*>(shares);
      *reinterpret_cast<Sixteen*>(columns[i]) = sum;
    }
    for (size_t four = 0; four < 4; ++four) {
      Quad turned[4];
      turn_quads(*reinterpret_cast<const Quad*>(columns[0] + 4 * four),
                 *reinterpret_cast<const Quad*>(columns[1] + 4 * four),
                 *reinterpret_cast<const Quad*>(columns[2] + 4 * four), turned);
      for (size_t b = 0; b < 4; ++b)
        *reinterpret_cast<Quad*>(out + kLocalBlock * (4 * four + b) + 4 * j) = turned[b];
    }
  }
}

// r: R by columns. factors: of the stiffness and of the mass.
struct TurnedBlocks {
  const float* stiffness;
  float r[9];
  float factor, mass;
  const MassShares* shares;
};

[[gnu::always_inline]] inline void turn_all(const FloatElement& element, const TurnedBlocks& g,
                                            float* local) {
  if (element.straight()) {
    turn_sixteen(g.stiffness + 9 * kQuadraticPlaces, kLinearPlaces, g.r, g.factor, g.mass,
                 g.shares->linear, local);
    return;
  }
  for (size_t first = 0; first < kQuadraticPlaces; first += 16)
    turn_sixteen(g.stiffness + first, kQuadraticPlaces, g.r, g.factor, g.mass,
                 g.shares->quadratic + first, local + kLocalBlock * first);
}

TREMOLO_CLONES
void add_turned_blocks(const FloatElement& element, const TurnedBlocks& g,
                       const FloatTarget& target) {
  alignas(64) float local[kLocalBlock * kQuadraticPlaces];
  turn_all(element, g, local);
  scatter_local(element, local, target);
}

// A_IJ -= right_I left_J^T + couple (g_J g_I^T - g_I.g_J).
template <size_t rank>
[[gnu::always_inline]] inline void subtract_parts(const FloatParts& parts, size_t nodes,
                                                  float* local) {
  for (size_t i = 0; i < nodes; ++i) {
    Quad right[rank];
    for (size_t m = 0; m < rank; ++m)
      right[m] = *reinterpret_cast<const Quad*>(parts.right + 4 * (kRanks * i + m));
    const float* own = parts.gradient + 4 * i;
    for (size_t j = 0; j <= i; ++j) {
      QuadBlock& block = block_at(local, node_block(i, j));
      const float* left = parts.left + 4 * kRanks * j;
      const Quad pull = parts.couple * *reinterpret_cast<const Quad*>(parts.gradient + 4 * j);
      const float both = pull[0] * own[0] + pull[1] * own[1] + pull[2] * own[2];
      Quad x = block.column[0] - pull * own[0] + Quad{both, 0.0F, 0.0F, 0.0F};
      Quad y = block.column[1] - pull * own[1] + Quad{0.0F, both, 0.0F, 0.0F};
      Quad z = block.column[2] - pull * own[2] + Quad{0.0F, 0.0F, both, 0.0F};
#pragma GCC unroll 6
      for (size_t m = 0; m < rank; ++m) {
        x -= right[m] * left[4 * m];
        y -= right[m] * left[4 * m + 1];
        z -= right[m] * left[4 * m + 2];
      }
      block.column[0] = x;
      block.column[1] = y;
      block.column[2] = z;
    }
  }
}

TREMOLO_CLONES
void add_exact_blocks(const FloatElement& element, const TurnedBlocks& g, const FloatParts& parts,
                      const FloatTarget& target) {
  alignas(64) float local[kLocalBlock * kQuadraticPlaces];
  turn_all(element, g, local);
  const size_t nodes = element.straight() ? 4 : kMostNodes;
  if (parts.damped)
    subtract_parts<kRanks>(parts, nodes, local);
  else
    subtract_parts<kRanks / 2>(parts, nodes, local);
  scatter_local(element, local, target);
}

TurnedBlocks turned_blocks(const float* stiffness, const Eigen::Matrix3d& rotation, double factor,
                           double mass) {
  TurnedBlocks g;
  g.stiffness = stiffness;
  for (int k = 0; k < 9; ++k) g.r[k] = static_cast<float>(rotation.data()[k]);
  g.factor = static_cast<float>(factor);
  g.mass = static_cast<float>(mass);
  g.shares = &mass_shares();
  return g;
}

}  // namespace

void pack_floats(std::span<const Eigen::Matrix3d> quadratic,
                 std::span<const Eigen::Matrix3d> linear, float* out) {
  for (size_t c = 0; c < 9; ++c) {
    for (size_t k = 0; k < kQuadraticPlaces; ++k)
      out[kQuadraticPlaces * c + k] =
          k < quadratic.size() ? static_cast<float>(quadratic[k].data()[c]) : 0.0F;
    for (size_t k = 0; k < kLinearPlaces; ++k)
      out[9 * kQuadraticPlaces + kLinearPlaces * c + k] =
          k < linear.size() ? static_cast<float>(linear[k].data()[c]) : 0.0F;
  }
}

void add_turned(const FloatElement& element, const float* stiffness,
                const Eigen::Matrix3d& rotation, double factor, double mass,
                const FloatTarget& target) {
  add_turned_blocks(element, turned_blocks(stiffness, rotation, factor, mass), target);
}

void add_exact(const FloatElement& element, const float* stiffness, const Eigen::Matrix3d& rotation,
               double factor, double mass, const FloatParts& parts, const FloatTarget& target) {
  add_exact_blocks(element, turned_blocks(stiffness, rotation, factor, mass), parts, target);
}

}  // namespace tremolo
