// How far the vertices of a deformed surface are from where they would be without deformation.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

namespace tremolo {

// rest: the surface at rest, m; positions: x y z ... of its vertices now. out: the distance of each
// vertex from its place at rest in the pose that is nearest to all of them, m; all zero if none is
// above a millionth of the largest coordinate, which is what rounding makes. Returns the largest.
float moved_by(const std::vector<Eigen::Vector3d>& rest, std::span<const float> positions,
               std::vector<float>& out);

}  // namespace tremolo
