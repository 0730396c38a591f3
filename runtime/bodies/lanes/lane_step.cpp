#include "runtime/bodies/lanes/lane_step.h"

#include "common/processor.h"

namespace tremolo {
namespace {

typedef float HalfVector __attribute__((vector_size(32), may_alias));

// p <- p + (h/2) (f - R_s), on a damped low row the kick of
// runtime/bodies/reduced/integrators/solve/damping.h.
[[gnu::always_inline]] inline void kick(const BlockArrays& b, std::size_t i, std::size_t at) {
  const LaneVector force = b.f != nullptr ? b.f[at] - b.R_s[at] : -b.R_s[at];
  if (b.decay != nullptr)
    b.p[at] = b.decay[i] * b.p[at] + b.reach[i] * force;
  else
    b.p[at] += (0.5 * b.h) * force;
}

// By reference: a caller may lack the registers to pass a vector as an argument.
[[gnu::always_inline]] inline void widen(const LaneVector& v, LaneVector& out) {
  out = v;
}
[[gnu::always_inline]] inline void widen(const HalfVector& v, LaneVector& out) {
  out = __builtin_convertvector(v, LaneVector);
}

// force = scale gradient, plus lambda q on the low rows.
template <class Part>
[[gnu::always_inline]] inline void gather(const BlockArrays& b, double scale,
                                          const Part* gradient) {
  for (std::size_t i = 0; i < b.modes; ++i) {
    const double lambda = i < b.low ? b.lambda[i] : 0.0;
    for (std::size_t at = i * b.width; at < (i + 1) * b.width; ++at) {
      LaneVector wide;
      widen(gradient[at], wide);
      b.R_s[at] = lambda * b.q[at] + scale * wide;
    }
  }
}
}  // namespace

TREMOLO_CLONES void kick_and_drift(const BlockArrays& b) {
  const double h = b.h;
  for (std::size_t i = 0; i < b.modes; ++i)
    for (std::size_t at = i * b.width; at < (i + 1) * b.width; ++at) {
      kick(b, i, at);
      if (i < b.low) {
        b.q[at] += h * b.p[at];
      } else {
        LaneVector d, dp;
        advance_linear_row(b.rows[i], h, b.q[at], b.p[at], d, dp);
      }
    }
}

TREMOLO_CLONES void kick_again(const BlockArrays& b) {
  for (std::size_t i = 0; i < b.modes; ++i)
    for (std::size_t at = i * b.width; at < (i + 1) * b.width; ++at) kick(b, i, at);
}

TREMOLO_CLONES void to_lanes(const LaneVector* q, std::size_t count, double scale, double* x) {
  LaneVector* out = reinterpret_cast<LaneVector*>(x);
  for (std::size_t at = 0; at < count; ++at) out[at] = scale * q[at];
}
TREMOLO_CLONES void to_lanes(const LaneVector* q, std::size_t count, double scale, float* x) {
  HalfVector* out = reinterpret_cast<HalfVector*>(x);
  for (std::size_t at = 0; at < count; ++at)
    out[at] = __builtin_convertvector(scale * q[at], HalfVector);
}

TREMOLO_CLONES void set_force(const BlockArrays& b, double scale, const double* gradient) {
  gather(b, scale, reinterpret_cast<const LaneVector*>(gradient));
}
TREMOLO_CLONES void set_force(const BlockArrays& b, double scale, const float* gradient) {
  gather(b, scale, reinterpret_cast<const HalfVector*>(gradient));
}

TREMOLO_CLONES void add_quadratic_energy(const BlockArrays& b, LaneVector* energy,
                                         LaneVector* harmonic) {
  for (std::size_t w = 0; w < b.width; ++w) {
    LaneVector sum = {};
    for (std::size_t i = 0; i < b.modes; ++i) {
      const std::size_t at = i * b.width + w;
      sum += 0.5 * (b.p[at] * b.p[at]) + (0.5 * b.lambda[i]) * (b.q[at] * b.q[at]);
    }
    energy[w] += sum;
    harmonic[w] = sum;
  }
}

TREMOLO_CLONES void sum_work(const BlockArrays& b, const LaneVector* q0, LaneVector* work,
                             LaneVector* kick) {
  for (std::size_t w = 0; w < b.width; ++w) {
    LaneVector done = {}, square = {};
    for (std::size_t at = w; at < b.modes * b.width; at += b.width) {
      done += b.f[at] * (b.q[at] - q0[at]);
      square += b.f[at] * b.f[at];
    }
    work[w] = done;
    kick[w] = (0.5 * b.h * b.h) * square;
  }
}

TREMOLO_CLONES std::uint32_t lanes_not_finite(const BlockArrays& b) {
  std::uint32_t bits = 0;
  for (std::size_t w = 0; w < b.width; ++w) {
    LaneVector zero = {};  // 0 x is 0 for a finite x alone
    for (std::size_t at = w; at < b.modes * b.width; at += b.width)
      zero += 0.0 * b.q[at] + 0.0 * b.p[at] + 0.0 * b.R_s[at];
    for (std::size_t lane = 0; lane < 8; ++lane)
      if (!(zero[lane] == 0.0)) bits |= 1u << (8 * w + lane);
  }
  return bits;
}

}  // namespace tremolo
