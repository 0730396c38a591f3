// Copies of a body in a scene file.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "runtime/io/scenes/toml_keys.h"

namespace tremolo {

// Copies of a body in the scene, in rows along the world's axes from its own position.
// random_turns: each has its own rotation, the same in each run.
struct Copies {
  std::array<int, 3> count = {1, 1, 1};
  Eigen::Vector3d spacing = Eigen::Vector3d::Zero();  // m
  bool random_turns = false;

  int all() const { return count[0] * count[1] * count[2]; }
};

// Reads copies, spacing and random-turns.
Copies read_copies(TomlKeys& keys);

// A rotation that depends on k alone, uniform over all rotations: a point of the sphere of
// quaternions.
Eigen::Quaterniond random_turn(int k);

// The copies are named with a number each: name-001 ...
template <class Body>
void add_copies(const Body& body, const Copies& copies, std::vector<Body>& bodies) {
  if (copies.all() == 1) return bodies.push_back(body);
  const std::size_t digits = std::to_string(copies.all()).size();
  int number = 0;
  for (int z = 0; z < copies.count[2]; ++z)
    for (int y = 0; y < copies.count[1]; ++y)
      for (int x = 0; x < copies.count[0]; ++x) {
        Body copy = body;
        const std::string text = std::to_string(++number);
        copy.name += "-" + std::string(digits - text.size(), '0') + text;
        copy.pose.position += copies.spacing.cwiseProduct(Eigen::Vector3d(x, y, z));
        if (copies.random_turns) copy.pose.rotation = random_turn(number) * copy.pose.rotation;
        bodies.push_back(std::move(copy));
      }
}

}  // namespace tremolo
