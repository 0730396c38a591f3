#include "common/mesh/given_vertices.h"

#include <algorithm>

namespace tremolo {

std::vector<std::int32_t> GivenVertices::meant_by(const std::vector<std::int32_t>& ids) const {
  std::vector<bool> given(nearest.size(), false), covered(nearest.size(), false);
  for (const std::int32_t id : ids) given[first_at[id]] = true;
  const auto all_given = [&given](const std::array<std::int32_t, 3>& three) {
    return std::all_of(three.begin(), three.end(),
                       [&](std::int32_t v) { return v < 0 || given[v]; });
  };
  std::vector<std::int32_t> meant;
  for (std::size_t n = 0; n < boundary.size(); ++n)
    if (all_given(below[n])) meant.push_back(boundary[n]);
  // Triangles far smaller than the tetrahedra may have no vertex of the mesh over them.
  if (!meant.empty())
    for (const auto& triangle : corners)
      if (all_given(triangle))
        for (const std::int32_t v : triangle) covered[v] = true;
  for (const std::int32_t id : ids)
    if (!covered[first_at[id]]) meant.push_back(nearest[id]);
  std::sort(meant.begin(), meant.end());
  meant.erase(std::unique(meant.begin(), meant.end()), meant.end());
  return meant;
}

}  // namespace tremolo
