#include <cstddef>
#include <cstring>

#include "common/processor.h"
#include "runtime/bodies/tets/elements/element_turn.h"

namespace tremolo {
namespace {

// A column of three numbers and an unused one.
typedef double Column __attribute__((vector_size(32)));

// in, out: nine numbers per block, by columns; r: nine numbers of R by columns.
TREMOLO_CLONES
void turn_nines(const double* r, double factor, const double* in, double* out, std::size_t count) {
  const Column r0 = {factor * r[0], factor * r[1], factor * r[2], 0.0};
  const Column r1 = {factor * r[3], factor * r[4], factor * r[5], 0.0};
  const Column r2 = {factor * r[6], factor * r[7], factor * r[8], 0.0};
  for (std::size_t k = 0; k < count; ++k, in += 9, out += 9) {
    const Column t0 = r0 * in[0] + r1 * in[1] + r2 * in[2];
    const Column t1 = r0 * in[3] + r1 * in[4] + r2 * in[5];
    const Column t2 = r0 * in[6] + r1 * in[7] + r2 * in[8];
    for (std::size_t j = 0; j < 3; ++j) {
      const Column column = t0 * r[j] + t1 * r[3 + j] + t2 * r[6 + j];
      std::memcpy(out + 3 * j, &column, 3 * sizeof(double));
    }
  }
}

}  // namespace

void turn_blocks(const Eigen::Matrix3d& rotation, double factor,
                 std::span<const Eigen::Matrix3d> in, Eigen::Matrix3d* out) {
  static_assert(sizeof(Eigen::Matrix3d) == 9 * sizeof(double));
  if (!in.empty()) turn_nines(rotation.data(), factor, in.front().data(), out->data(), in.size());
}

}  // namespace tremolo
