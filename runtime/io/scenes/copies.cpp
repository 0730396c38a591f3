#include "runtime/io/scenes/copies.h"

#include <cmath>
#include <random>

namespace tremolo {

Copies read_copies(TomlKeys& keys) {
  Copies copies;
  Eigen::Vector3d count = Eigen::Vector3d::Ones();
  keys.read("copies", count);
  for (int k = 0; k < 3; ++k) {
    const double n = count[k];
    if (!(n >= 1.0 && n <= 1e4) || n != std::floor(n)) {
      keys.fail("copies", "copies are three whole numbers from 1 to 10000");
      return copies;
    }
    copies.count[k] = static_cast<int>(n);
  }
  if (count.prod() > 1e5) {
    keys.fail("copies", "more than 100000 copies");
    copies.count = {1, 1, 1};
  }
  keys.read("spacing", copies.spacing);
  keys.read("random-turns", copies.random_turns);
  if (copies.all() > 1 && !keys.has("spacing"))
    keys.fail("copies", "copies need their `spacing`, [dx, dy, dz] in m");
  if (keys.has("spacing") && !keys.has("copies"))
    keys.fail("spacing", "it is between `copies`, three whole numbers, which are not given");
  return copies;
}

Eigen::Quaterniond random_turn(int k) {
  std::minstd_rand numbers(static_cast<unsigned>(k) + 1U);
  numbers.discard(10);
  Eigen::Vector4d q;
  do {
    for (int i = 0; i < 4; ++i)
      q[i] = 2.0 * static_cast<double>(numbers()) / static_cast<double>(numbers.max()) - 1.0;
  } while (q.squaredNorm() > 1.0 || q.squaredNorm() < 0.01);
  return Eigen::Quaterniond(q).normalized();
}

}  // namespace tremolo
