#include "runtime/bodies/lanes/lane_force.h"

#include <algorithm>
#include <cmath>

#include "common/packed_index.h"
#include "runtime/math/kernels/lanes.h"

namespace tremolo {
namespace {

// Triples (j, k, l) with the same j and k are computed `width` at a time, for as many values of l:
// q_i and the gradient's row i are then loaded once for `width` coefficients. Six of them still fit
// in the registers of AVX-512; in a page the code's size counts.
#if defined(__wasm__)
constexpr std::size_t kMostTogether = 2;
#else
constexpr std::size_t kMostTogether = 6;
#endif
static_assert(kMostTogether == 2 || kMostTogether == 6, "add_wide() has these");

// The number of the `left` values of l in the next step: the fewest steps, of nearly equal width.
constexpr std::size_t next_width(std::size_t left) {
  const std::size_t steps = (left + kMostTogether - 1) / kMostTogether;
  return (left + steps - 1) / steps;
}

// The pass on the lanes that fit in one vector of kBytes. Rows are 64 bytes apart.
template <class Real, int kBytes>
struct Pass {
  typedef Real Vector __attribute__((vector_size(kBytes), may_alias));

  static constexpr std::size_t kStride = kBodiesPerBlock<Real>;

  const Real* coefficient;
  const Real* x;
  Real* gradient;
  Vector energy = Vector{};

  [[gnu::always_inline]] inline const Vector& in(std::size_t i) const {
    return *reinterpret_cast<const Vector*>(x + i * kStride);
  }
  [[gnu::always_inline]] inline Vector& out(std::size_t i) const {
    return *reinterpret_cast<Vector*>(gradient + i * kStride);
  }

  // All (j <= k, k, l) for l in [first, first + kWidth).
  template <std::size_t kWidth, bool kEnergy>
  [[gnu::always_inline]] inline void add_triples(std::size_t k, std::size_t first) {
    Vector pair[kWidth], pair_adjoint[kWidth];
    for (std::size_t m = 0; m < kWidth; ++m) {
      pair[m] = in(k)*in(first + m);
      pair_adjoint[m] = Vector{};
    }
    const Real* c = coefficient;
    for (std::size_t j = 0; j <= k; ++j) {
      Vector s[kWidth], t[kWidth];
      for (std::size_t m = 0; m < kWidth; ++m) {
        s[m] = Vector{} + c[m];
        t[m] = in(j)*pair[m];
      }
      c += kWidth;
      for (std::size_t i = 0; i <= j; ++i, c += kWidth) {
        const Vector x_i = in(i);
        // A separate sum, so that the chain through memory is one addition.
        Vector sum;
        for (std::size_t m = 0; m < kWidth; ++m) {
          const Vector c_m = c[m] - Vector{};  // minus zero: a broadcast and nothing else
          s[m] += c_m * x_i;
          if (m == 0)
            sum = c_m * t[m];
          else
            sum += c_m * t[m];
        }
        out(i) += sum;
      }
      const Vector x_j = in(j);
      Vector sum = s[0] * pair[0];
      for (std::size_t m = 0; m < kWidth; ++m) {
        if (m > 0) sum += s[m] * pair[m];
        pair_adjoint[m] += s[m] * x_j;
        if constexpr (kEnergy) energy += s[m] * t[m];
      }
      out(j) += sum;
    }
    coefficient = c;
    Vector sum = pair_adjoint[0] * in(first);
    for (std::size_t m = 1; m < kWidth; ++m) sum += pair_adjoint[m] * in(first + m);
    out(k) += sum;
    for (std::size_t m = 0; m < kWidth; ++m) out(first + m) += pair_adjoint[m] * in(k);
  }

  // add_triples() for a width that is known at run time, 1 to kMostTogether.
  template <bool kEnergy>
  [[gnu::always_inline]] inline void add_wide(std::size_t width, std::size_t k, std::size_t l) {
    if constexpr (kMostTogether == 2) {
      if (width == 1) return add_triples<1, kEnergy>(k, l);
      return add_triples<2, kEnergy>(k, l);
    } else {
      switch (width) {
        case 1:
          return add_triples<1, kEnergy>(k, l);
        case 2:
          return add_triples<2, kEnergy>(k, l);
        case 3:
          return add_triples<3, kEnergy>(k, l);
        case 4:
          return add_triples<4, kEnergy>(k, l);
        case 5:
          return add_triples<5, kEnergy>(k, l);
        default:
          return add_triples<6, kEnergy>(k, l);
      }
    }
  }

  template <bool kEnergy>
  [[gnu::always_inline]] inline void add_all(std::size_t r) {
    for (std::size_t i = 0; i < r; ++i) out(i) = Vector{};
    for (std::size_t k = 0; k < r; ++k)
      for (std::size_t l = k; l < r;) {
        const std::size_t width = next_width(r - l);
        add_wide<kEnergy>(width, k, l);
        l += width;
      }
  }
};

// All lanes of a block, kBytes at a time.
template <int kBytes, class Real>
[[gnu::always_inline]] inline void run(const Real* stream, std::size_t r, const Real* x,
                                       Real* gradient, Real* energy) {
  constexpr std::size_t kAtOnce = static_cast<std::size_t>(kBytes) / sizeof(Real);
  for (std::size_t lane = 0; lane < kBodiesPerBlock<Real>; lane += kAtOnce) {
    Pass<Real, kBytes> pass{stream, x + lane, gradient + lane};
    if (energy == nullptr) {
      pass.template add_all<false>(r);
    } else {
      pass.template add_all<true>(r);
      for (std::size_t i = 0; i < kAtOnce; ++i) energy[lane + i] = pass.energy[i];
    }
  }
}

}  // namespace
}  // namespace tremolo

// TREMOLO_CLONES is not used: each clone would divide the same 64-byte vectors into pieces, and the
// narrower machines have too few registers for that.
#define TREMOLO_KERNEL "runtime/bodies/lanes/lane_force.inc"
#include "runtime/math/kernels/every_instruction_set.inc"

namespace tremolo {
namespace {

// The power of two next to a positive number; 1 for a number that is not positive and finite.
double power_of_two(double value) {
  if (!(value > 0.0) || !std::isfinite(value)) return 1.0;
  return std::ldexp(1.0, static_cast<int>(std::lround(std::log2(value))));
}

double largest(std::span<const double> values) {
  double most = 0.0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

}  // namespace

template <class Real>
LaneCoefficients<Real> make_lane_coefficients(std::size_t modes, std::span<const double> cubic,
                                              std::span<const double> quartic) {
  LaneCoefficients<Real> lanes;
  lanes.modes = modes;
  if (cubic.empty() && quartic.empty()) {  // a linear solid
    lanes.stream.assign(triple_count(modes) + quad_count(modes), Real(0));
    return lanes;
  }
  cubic = cubic.first(triple_count(modes));
  quartic = quartic.first(quad_count(modes));
  lanes.coordinate_scale = power_of_two(largest(cubic) / largest(quartic));
  const double cube = lanes.coordinate_scale * lanes.coordinate_scale * lanes.coordinate_scale;
  lanes.energy_scale = power_of_two(
      std::max(largest(cubic) * cube, largest(quartic) * cube * lanes.coordinate_scale));
  const double cubic_factor = cube / lanes.energy_scale;
  const double quartic_factor = cubic_factor * lanes.coordinate_scale;
  lanes.stream.reserve(triple_count(modes) + quad_count(modes));
  for (std::size_t k = 0; k < modes; ++k)
    for (std::size_t first = k; first < modes;) {
      const std::size_t end = first + next_width(modes - first);
      for (std::size_t j = 0; j <= k; ++j) {
        for (std::size_t l = first; l < end; ++l)
          lanes.stream.push_back(
              static_cast<Real>(cubic_factor * orderings(j, k, l) * cubic[triple_index(j, k, l)]));
        for (std::size_t i = 0; i <= j; ++i)
          for (std::size_t l = first; l < end; ++l)
            lanes.stream.push_back(static_cast<Real>(quartic_factor * orderings(i, j, k, l) *
                                                     quartic[quad_index(i, j, k, l)]));
      }
      first = end;
    }
  return lanes;
}

template LaneCoefficients<float> make_lane_coefficients(std::size_t, std::span<const double>,
                                                        std::span<const double>);
template LaneCoefficients<double> make_lane_coefficients(std::size_t, std::span<const double>,
                                                         std::span<const double>);

void evaluate_lanes(const LaneCoefficients<float>& coefficients, const float* x, float* gradient,
                    float* energy, InstructionSet vectors) {
  TREMOLO_CALL_FOR(vectors, run_floats, coefficients.stream.data(), coefficients.modes, x, gradient,
                   energy);
}

void evaluate_lanes(const LaneCoefficients<double>& coefficients, const double* x, double* gradient,
                    double* energy, InstructionSet vectors) {
  TREMOLO_CALL_FOR(vectors, run_doubles, coefficients.stream.data(), coefficients.modes, x,
                   gradient, energy);
}

}  // namespace tremolo
