#include <cstring>

#include "common/processor.h"
#include "runtime/bodies/tets/elements/tet_element.h"

namespace tremolo {
namespace {

using std::size_t;

typedef double Lane __attribute__((vector_size(8 * kElementLanes)));
typedef decltype(Lane{} < Lane{}) LaneMask;

constexpr int kMostLaneSteps = 10;
// Newton's error squares: it is below rounding after a step of this size.
constexpr double kLastLaneStep = 2e-8;
constexpr double kLongestLaneStep = 0.5;
constexpr double kMostLaneStrain = 0.5;

#define LANE_INLINE [[gnu::always_inline]] inline

// Three by three, by columns.
struct LaneMatrix {
  Lane a[9];
  LANE_INLINE Lane& operator()(int i, int j) { return a[3 * j + i]; }
  LANE_INLINE const Lane& operator()(int i, int j) const { return a[3 * j + i]; }
};

// Input and output of the kernel. x: by control points. gradients: by corners. good: all bits set
// if the shape was found.
struct LaneGroup {
  Lane x[3 * kMostNodes];
  Lane gradients[12];
  Lane volume, couple, lambda, mu;
  LaneMatrix rotation;
  LaneMatrix seen[4], stress[4], mean;
  Lane b[3];
  LaneMatrix hessian, turned;  // by a rotation of the found shape; lower triangles
  LaneMask good;
};

LANE_INLINE LaneMatrix transposed_times(const LaneMatrix& r, const LaneMatrix& f) {
  LaneMatrix s;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) s(i, j) = r(0, i) * f(0, j) + r(1, i) * f(1, j) + r(2, i) * f(2, j);
  return s;
}

LANE_INLINE LaneMatrix product(const LaneMatrix& a, const LaneMatrix& b) {
  LaneMatrix s;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) s(i, j) = a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j);
  return s;
}

LANE_INLINE void axial_of(const LaneMatrix& a, Lane* out) {
  out[0] = a(1, 2) - a(2, 1);
  out[1] = a(2, 0) - a(0, 2);
  out[2] = a(0, 1) - a(1, 0);
}

// lambda tr(e) + 2 mu e with e = sym S - 1.
LANE_INLINE void set_stress(const LaneGroup& g, const LaneMatrix& s, LaneMatrix& out) {
  const Lane trace = g.lambda * (s(0, 0) + s(1, 1) + s(2, 2) - 3.0);
  for (int j = 0; j < 3; ++j) {
    out(j, j) = trace + 2.0 * g.mu * (s(j, j) - 1.0);
    for (int i = 0; i < j; ++i) out(i, j) = out(j, i) = g.mu * (s(i, j) + s(j, i));
  }
}

// The deformation gradients at the samples and their mean (element.h).
LANE_INLINE void find_gradients(const LaneGroup& g, LaneMatrix* at, LaneMatrix& mean) {
  LaneMatrix corner[4];
  for (int a = 0; a < 4; ++a)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) {
        Lane sum = {};
        for (int b = 0; b < 4; ++b)
          sum += (g.x[3 * kNodeAt[a][b] + i] - g.x[i]) * g.gradients[3 * b + j];
        corner[a](i, j) = 2.0 * sum;
      }
  const auto points = sample_points(2, 2);
  for (int k = 0; k < 9; ++k) {
    mean.a[k] = 0.25 * (corner[0].a[k] + corner[1].a[k] + corner[2].a[k] + corner[3].a[k]);
    for (size_t s = 0; s < 4; ++s)
      at[s].a[k] = points[s].lambda[0] * corner[0].a[k] + points[s].lambda[1] * corner[1].a[k] +
                   points[s].lambda[2] * corner[2].a[k] + points[s].lambda[3] * corner[3].a[k];
  }
}

// Adds weight sym([e_i] S) : C sym([e_j] S) to the lower triangle of `turned`.
LANE_INLINE void add_turned(const LaneGroup& g, Lane weight, const LaneMatrix& s,
                            LaneMatrix& turned) {
  Lane strain[3][3][3];  // upper triangle of each
  Lane trace[3];
  axial_of(s, trace);
  for (int j = 0; j < 3; ++j) {
    const int k = (j + 1) % 3, l = (j + 2) % 3;
    const auto set = [&](int p, int q, Lane value) {
      strain[j][p < q ? p : q][p < q ? q : p] = value;
    };
    set(j, j, Lane{});
    set(k, k, -s(l, k));
    set(l, l, s(k, l));
    set(k, l, 0.5 * (s(k, k) - s(l, l)));
    set(j, k, -0.5 * s(l, j));
    set(j, l, 0.5 * s(k, j));
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j) {
      Lane diagonal = {}, beside = {};
      for (int p = 0; p < 3; ++p) {
        diagonal += strain[i][p][p] * strain[j][p][p];
        for (int q = p + 1; q < 3; ++q) beside += strain[i][p][q] * strain[j][p][q];
      }
      turned(i, j) +=
          weight * (g.lambda * trace[i] * trace[j] + 2.0 * g.mu * (diagonal + 2.0 * beside));
    }
}

// Gradient and lower triangles of the Hessian of the energy by a rotation, and of `of_turned`, its
// positive part (element_turn.h).
LANE_INLINE void find_turn(const LaneGroup& g, Lane* gradient, LaneMatrix& h,
                           LaneMatrix& of_turned) {
  const Lane weight = 0.25 * g.volume;
  for (int k = 0; k < 9; ++k) h.a[k] = of_turned.a[k] = Lane{};
  gradient[0] = gradient[1] = gradient[2] = Lane{};
  for (int s = 0; s < 4; ++s) {
    const LaneMatrix both = product(g.seen[s], g.stress[s]);
    Lane around[3];
    axial_of(both, around);
    const Lane trace = both(0, 0) + both(1, 1) + both(2, 2);
    for (int i = 0; i < 3; ++i) {
      gradient[i] -= weight * around[i];
      h(i, i) -= weight * (trace - both(i, i));
      for (int j = 0; j < i; ++j) h(i, j) += 0.5 * weight * (both(i, j) + both(j, i));
    }
    add_turned(g, weight, g.seen[s], of_turned);
  }
  const Lane trace = g.mean(0, 0) + g.mean(1, 1) + g.mean(2, 2);
  LaneMatrix p;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) p(i, j) = (i == j ? trace : Lane{}) - g.mean(i, j);
  LaneMatrix turned;  // [b] mean
  for (int j = 0; j < 3; ++j) {
    turned(0, j) = g.b[1] * g.mean(2, j) - g.b[2] * g.mean(1, j);
    turned(1, j) = g.b[2] * g.mean(0, j) - g.b[0] * g.mean(2, j);
    turned(2, j) = g.b[0] * g.mean(1, j) - g.b[1] * g.mean(0, j);
  }
  for (int i = 0; i < 3; ++i) {
    gradient[i] += g.couple * (p(0, i) * g.b[0] + p(1, i) * g.b[1] + p(2, i) * g.b[2]);
    for (int j = 0; j <= i; ++j) {
      of_turned(i, j) += g.couple * (p(0, i) * p(0, j) + p(1, i) * p(1, j) + p(2, i) * p(2, j));
      h(i, j) +=
          of_turned(i, j) - g.couple * (g.b[i] * g.b[j] + 0.5 * (turned(i, j) + turned(j, i)));
    }
  }
}

// w = -H^-1 gradient; clears `good` where H is not positive (downhill() of element_turn.cpp).
LANE_INLINE void find_step(const LaneMatrix& h, const Lane* gradient, Lane* w, LaneMask& good) {
  const Lane c00 = h(1, 1) * h(2, 2) - h(2, 1) * h(2, 1);
  const Lane c10 = h(2, 1) * h(2, 0) - h(1, 0) * h(2, 2);
  const Lane c20 = h(1, 0) * h(2, 1) - h(1, 1) * h(2, 0);
  const Lane c11 = h(0, 0) * h(2, 2) - h(2, 0) * h(2, 0);
  const Lane c21 = h(1, 0) * h(2, 0) - h(0, 0) * h(2, 1);
  const Lane c22 = h(0, 0) * h(1, 1) - h(1, 0) * h(1, 0);
  const Lane determinant = h(0, 0) * c00 + h(1, 0) * c10 + h(2, 0) * c20;
  const Lane trace = h(0, 0) + h(1, 1) + h(2, 2);
  good &= (h(0, 0) > 0.0) & (c22 > 0.0) & (determinant > 1e-9 * trace * trace * trace);
  const Lane scale = -1.0 / determinant;
  w[0] = scale * (c00 * gradient[0] + c10 * gradient[1] + c20 * gradient[2]);
  w[1] = scale * (c10 * gradient[0] + c11 * gradient[1] + c21 * gradient[2]);
  w[2] = scale * (c20 * gradient[0] + c21 * gradient[1] + c22 * gradient[2]);
}

// R <- R Q, Q the rotation of the quaternion (1, w/2), which is exp([w]) to second order.
LANE_INLINE void turn_lanes_by(const Lane* w, LaneMatrix& r) {
  const Lane x = 0.5 * w[0], y = 0.5 * w[1], z = 0.5 * w[2];
  const Lane s = 2.0 / (1.0 + x * x + y * y + z * z);
  LaneMatrix q;
  q(0, 0) = 1.0 - s * (y * y + z * z);
  q(1, 1) = 1.0 - s * (x * x + z * z);
  q(2, 2) = 1.0 - s * (x * x + y * y);
  q(1, 0) = s * (x * y + z);
  q(0, 1) = s * (x * y - z);
  q(2, 0) = s * (x * z - y);
  q(0, 2) = s * (x * z + y);
  q(2, 1) = s * (y * z + x);
  q(1, 2) = s * (y * z - x);
  r = product(r, q);
}

// R <- R (3 - R^T R) / 2: corrects the rounding errors of products.
LANE_INLINE void mend_rotation(LaneMatrix& r) {
  LaneMatrix square = transposed_times(r, r);
  for (int k = 0; k < 9; ++k) square.a[k] *= -0.5;
  for (int i = 0; i < 3; ++i) square(i, i) += 1.5;
  r = product(r, square);
}

LANE_INLINE void see(const LaneMatrix* at, const LaneMatrix& mean, LaneGroup& g) {
  g.mean = transposed_times(g.rotation, mean);
  axial_of(g.mean, g.b);
  for (int s = 0; s < 4; ++s) {
    g.seen[s] = transposed_times(g.rotation, at[s]);
    set_stress(g, g.seen[s], g.stress[s]);
  }
}

LANE_INLINE Lane strain_of(const LaneMatrix& s) {
  Lane sum = {};
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) {
      const Lane off = s(i, j) - (i == j ? 1.0 : 0.0);
      sum += off * off;
    }
  return sum;
}

TREMOLO_CLONES
void search_in_lanes(LaneGroup& g) {
  LaneMatrix at[4], mean;
  find_gradients(g, at, mean);
  mend_rotation(g.rotation);
  see(at, mean, g);
  g.good = ~LaneMask{};
  LaneMask done = {};
  for (int step = 0; step < kMostLaneSteps; ++step) {
    Lane gradient[3], w[3];
    find_turn(g, gradient, g.hessian, g.turned);
    find_step(g.hessian, gradient, w, g.good);
    const Lane square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
    // False for a value that is not a number.
    g.good &= square < kLongestLaneStep * kLongestLaneStep;
    // Lanes that have finished, found or not, keep their values.
    for (int i = 0; i < 3; ++i) w[i] = (g.good & ~done) != 0 ? w[i] : Lane{};
    turn_lanes_by(w, g.rotation);
    see(at, mean, g);
    done |= (square < kLastLaneStep * kLastLaneStep) | ~g.good;
    auto all = done[0];
    for (size_t k = 1; k < kElementLanes; ++k) all &= done[k];
    if (all != 0) break;
  }
  g.good &= done;
  Lane gradient[3];
  find_turn(g, gradient, g.hessian, g.turned);
  for (int s = 0; s < 4; ++s) g.good &= strain_of(g.seen[s]) < kMostLaneStrain * kMostLaneStrain;
}

void put_lane(const LaneMatrix& from, size_t lane, Eigen::Matrix3d& to) {
  for (int k = 0; k < 9; ++k) to.data()[k] = from.a[k][lane];
}

void put_symmetric(const LaneMatrix& lower, size_t lane, Eigen::Matrix3d& to) {
  for (int j = 0; j < 3; ++j)
    for (int i = j; i < 3; ++i) to(i, j) = to(j, i) = lower(i, j)[lane];
}

}  // namespace

unsigned shapes_in_lanes(const LaneElement* group, size_t count) {
  LaneGroup g;
  for (size_t lane = 0; lane < kElementLanes; ++lane) {
    const LaneElement& one = group[lane < count ? lane : 0];
    for (size_t n = 0; n < kMostNodes; ++n)
      for (size_t i = 0; i < 3; ++i) g.x[3 * n + i][lane] = one.nodes[n][i];
    for (int k = 0; k < 12; ++k) g.gradients[k][lane] = one.element->geometry.gradients.data()[k];
    for (int k = 0; k < 9; ++k) g.rotation.a[k][lane] = one.shape->rotation.data()[k];
    g.volume[lane] = one.element->geometry.volume;
    g.couple[lane] = one.element->couple;
    g.lambda[lane] = one.elasticity->lambda;
    g.mu[lane] = one.elasticity->mu;
  }
  search_in_lanes(g);
  unsigned lost = 0;
  for (size_t lane = 0; lane < count; ++lane) {
    if (g.good[lane] == 0) {
      lost |= 1U << lane;
      continue;
    }
    TetShape& shape = *group[lane].shape;
    shape.order = 2;
    shape.samples = 4;
    shape.converged = true;
    put_lane(g.rotation, lane, shape.rotation);
    put_lane(g.mean, lane, shape.mean);
    for (size_t s = 0; s < 4; ++s) {
      put_lane(g.seen[s], lane, shape.seen[s]);
      put_lane(g.stress[s], lane, shape.stress[s]);
    }
    put_symmetric(g.hessian, lane, shape.hessian);
    put_symmetric(g.turned, lane, shape.turned);
    shape.has_turn = true;
    for (int i = 0; i < 3; ++i) shape.couple[i] = group[lane].element->couple * g.b[i][lane];
  }
  return lost;
}

}  // namespace tremolo
