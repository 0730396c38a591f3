#include "common/processor.h"
#include "runtime/bodies/tets/elements/element_turn.h"
#include "runtime/bodies/tets/elements/float_blocks.h"
#include "runtime/bodies/tets/elements/quads.h"

namespace tremolo {
namespace {

using std::size_t;

// An element in its own frame. weighted: a sample's volume times its stress less its couple, the
// force that rotates with the shape. of_p: a sample's weight of [p_j] m for each axis. lambda, mu:
// times a sample's volume. shares: weights of the samples in the corners' sums, by samples.
struct FloatShape {
  size_t nodes, samples;
  QuadBlock seen[4], weighted[4], of_p[3];
  QuadBlock rotation, of_slopes, of_turned;
  Quad gradients[4];
  float lambda, mu;
  float shares[4][4];
};

Quad quad_from(const Eigen::Vector3d& x) {
  const Quad quad = {static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2]),
                     0.0F};
  return quad;
}
QuadBlock block_from(const Eigen::Matrix3d& a) {
  return {{quad_from(a.col(0)), quad_from(a.col(1)), quad_from(a.col(2))}};
}

// e_j x v.
template <int j>
[[gnu::always_inline]] inline Quad unit_cross(Quad v) {
  constexpr int k = (j + 1) % 3, l = (j + 2) % 3;
  Quad out = {};
  out[k] = -v[l];
  out[l] = v[k];
  return out;
}

// Forces on the nodes from corners' sums (element.h), rotated into space.
[[gnu::always_inline]] inline void put_forces(const FloatShape& g, const QuadBlock* at,
                                              size_t column, float* left) {
  const auto put = [&](size_t node, Quad force) {
    *reinterpret_cast<Quad*>(left + 4 * (kRanks * node + column)) = times(g.rotation, force);
  };
  if (g.nodes == 4) {
    for (size_t a = 0; a < 4; ++a) put(a, times(at[0], g.gradients[a]));
    return;
  }
  for (size_t a = 0; a < 4; ++a) {
    put(a, 2.0F * times(at[a], g.gradients[a]));
    for (size_t b = a + 1; b < 4; ++b)
      put(static_cast<size_t>(kNodeAt[a][b]),
          2.0F * (times(at[a], g.gradients[b]) + times(at[b], g.gradients[a])));
  }
}

// turned_j = K' Y_j and slopes_j = e_j x f - K' Y_j of one axis.
template <int j>
[[gnu::always_inline]] inline void find_axis(const FloatShape& g, float* left) {
  QuadBlock turned[4] = {}, slope[4] = {};
  for (size_t s = 0; s < g.samples; ++s) {
    QuadBlock moved, answer, force;
    for (size_t c = 0; c < 3; ++c) {
      moved.column[c] = unit_cross<j>(g.seen[s].column[c]);
      force.column[c] = unit_cross<j>(g.weighted[s].column[c]);
    }
    const QuadBlock back = transposed(moved);
    const float pressed = g.lambda * (moved.column[0][0] + moved.column[1][1] + moved.column[2][2]);
    const Quad on_diagonal[3] = {
        {pressed, 0.0F, 0.0F, 0.0F}, {0.0F, pressed, 0.0F, 0.0F}, {0.0F, 0.0F, pressed, 0.0F}};
    for (size_t c = 0; c < 3; ++c) {
      answer.column[c] =
          g.mu * (moved.column[c] + back.column[c]) + on_diagonal[c] + g.of_p[j].column[c];
      force.column[c] -= answer.column[c];
    }
    for (size_t a = 0; a < (g.nodes == 4 ? 1 : 4); ++a)
      for (size_t c = 0; c < 3; ++c) {
        turned[a].column[c] += g.shares[s][a] * answer.column[c];
        slope[a].column[c] += g.shares[s][a] * force.column[c];
      }
  }
  put_forces(g, slope, j, left);
  put_forces(g, turned, 3 + j, left);
}

TREMOLO_CLONES
void find_columns(const FloatShape& g, FloatParts& parts) {
  find_axis<0>(g, parts.left);
  find_axis<1>(g, parts.left);
  find_axis<2>(g, parts.left);
  for (size_t i = 0; i < g.nodes; ++i) {
    const Quad* left = reinterpret_cast<const Quad*>(parts.left + 4 * kRanks * i);
    Quad* right = reinterpret_cast<Quad*>(parts.right + 4 * kRanks * i);
    for (size_t m = 0; m < 3; ++m) {
      const Quad a = g.of_slopes.column[m], b = g.of_turned.column[m];
      right[m] = left[0] * a[0] + left[1] * a[1] + left[2] * a[2];
      right[3 + m] = left[3] * b[0] + left[4] * b[1] + left[5] * b[2];
    }
  }
}

FloatShape float_shape(const TetElement& element, const Elasticity& elasticity,
                       const TetShape& shape) {
  FloatShape g;
  g.nodes = static_cast<size_t>(nodes_of_order(shape.order));
  g.samples = static_cast<size_t>(shape.samples);
  const double share = 1.0 / shape.samples, weight = share * element.geometry.volume;
  const Eigen::Matrix3d couple = share * cross_matrix(shape.couple);
  const Eigen::Matrix3d p = trace_minus(shape.mean);
  const auto points = sample_points(shape.order, 2);
  for (size_t s = 0; s < g.samples; ++s) {
    g.seen[s] = block_from(shape.seen[s]);
    g.weighted[s] = block_from(weight * shape.stress[s] - couple);
    for (size_t a = 0; a < 4; ++a)
      g.shares[s][a] = shape.order == 1 ? 1.0F : static_cast<float>(points[s].lambda[a]);
  }
  for (Eigen::Index j = 0; j < 3; ++j)
    g.of_p[j] = block_from(share * element.couple * cross_matrix(p.col(j)));
  for (Eigen::Index a = 0; a < 4; ++a)
    g.gradients[a] = quad_from(element.geometry.gradients.col(a));
  g.rotation = block_from(shape.rotation);
  g.lambda = static_cast<float>(weight * elasticity.lambda);
  g.mu = static_cast<float>(weight * elasticity.mu);
  return g;
}

// For any material: the parts in double precision, rotated and rounded.
void convert_parts(const TangentParts& from, const Eigen::Matrix3d& rotation, FloatParts& parts) {
  for (Eigen::Index i = 0; i < from.gradients.cols(); ++i)
    for (size_t first = 0; first < kRanks; first += 3) {
      const auto& columns = first == 0 ? from.slopes : from.turned;
      Eigen::Matrix3d left;
      for (size_t m = 0; m < 3; ++m) left.col(m) = columns[m].col(i);
      left = rotation * left;
      const Eigen::Matrix3d right = left * (first == 0 ? from.of_slopes : from.of_turned);
      for (size_t m = 0; m < 3; ++m) {
        const size_t at = 4 * (kRanks * static_cast<size_t>(i) + first + m);
        *reinterpret_cast<Quad*>(parts.left + at) = quad_from(left.col(m));
        *reinterpret_cast<Quad*>(parts.right + at) = quad_from(right.col(m));
      }
    }
}

}  // namespace

void find_float_parts(const TetElement& element, const Elasticity& elasticity,
                      const TetShape& shape, const TangentFactors& factors, FloatParts& parts) {
  const NodeGradients gradients = node_gradients(element.geometry, shape.order, SamplePoint{});
  for (Eigen::Index i = 0; i < gradients.cols(); ++i)
    *reinterpret_cast<Quad*>(parts.gradient + 4 * i) = quad_from(shape.rotation * gradients.col(i));
  parts.couple = static_cast<float>((factors.position + factors.velocity) * element.couple);
  parts.damped = factors.velocity != 0.0;
  if (!elasticity.isotropic) {
    convert_parts(tangent_parts(element, elasticity, shape, factors), shape.rotation, parts);
    return;
  }
  FloatShape g = float_shape(element, elasticity, shape);
  const TurnMatrices d = turn_matrices(element, elasticity, shape);
  g.of_slopes = block_from(factors.position * bounded_inverse(d.hessian));
  g.of_turned = {};
  if (parts.damped) g.of_turned = block_from(factors.velocity * bounded_inverse(d.turned));
  find_columns(g, parts);
}

}  // namespace tremolo
