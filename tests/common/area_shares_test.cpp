// A force on a face is a uniform traction, however the face is meshed.
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "common/mesh/surface_mesh.h"
#include "tests/support/meshes/box_mesh.h"

namespace tremolo {
namespace {

// A unit square whose left part, up to x = 1/4, is cut into n x 4n cells and whose right part into
// two triangles a row, row by row.
struct Face {
  std::vector<VertexId> ids;
  std::vector<Eigen::Vector3d> rest;
  std::vector<Triangle> triangles;
};

Face graded_face(int n) {
  Face face;
  std::vector<double> columns;
  for (int i = 0; i <= n; ++i) columns.push_back(0.25 * i / n);
  columns.push_back(1.0);
  const int wide = static_cast<int>(columns.size()), rows = 2 * n;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i < wide; ++i) {
      face.ids.push_back(3 * static_cast<VertexId>(face.ids.size()));  // with gaps
      face.rest.emplace_back(columns[i], static_cast<double>(j) / rows, 0.0);
    }
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i + 1 < wide; ++i) {
      const VertexId a = i + wide * j, b = a + 1, c = a + wide, d = c + 1;
      face.triangles.push_back({a, b, d});
      face.triangles.push_back({a, d, c});
    }
  return face;
}

TEST(AreaShares, PutTheResultantAtTheCentroidOfAFaceThatIsMeshedFinerOnOneSide) {
  for (const int n : {1, 3, 10}) {
    const Face face = graded_face(n);
    const std::vector<double> shares = area_shares(face.ids, face.ids, face.triangles, face.rest);
    EXPECT_NEAR(std::accumulate(shares.begin(), shares.end(), 0.0), 1.0, 1e-14);
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (std::size_t v = 0; v < shares.size(); ++v) centre += shares[v] * face.rest[v];
    // Equal shares would put it at x = 0.14 for n = 10.
    EXPECT_TRUE(centre.isApprox(Eigen::Vector3d(0.5, 0.5, 0.0), 1e-13)) << centre.transpose();
  }
}

TEST(AreaShares, AreEqualWhereNoTriangleIsChosenWhole) {
  const Face face = graded_face(2);
  const std::vector<VertexId> two = {face.ids[0], face.ids[7]};
  EXPECT_EQ(area_shares(two, face.ids, face.triangles, face.rest), (std::vector<double>{0.5, 0.5}));
  // Vertices that are inside, of which the boundary has none.
  EXPECT_EQ(area_shares(std::vector<VertexId>{1}, face.ids, face.triangles, face.rest),
            std::vector<double>{1.0});
}

TEST(AreaShares, GiveNothingToVerticesOfNoWholeTriangle) {
  const Face face = graded_face(2);
  // One triangle, a vertex far from it, and one inside.
  std::vector<VertexId> chosen = {1};
  for (const VertexId row : face.triangles.front()) chosen.push_back(face.ids[row]);
  chosen.push_back(face.ids.back());
  const std::vector<double> shares = area_shares(chosen, face.ids, face.triangles, face.rest);
  EXPECT_EQ(shares.front(), 0.0);
  EXPECT_EQ(shares.back(), 0.0);
  for (std::size_t n = 1; n < 4; ++n) EXPECT_NEAR(shares[n], 1.0 / 3, 1e-15);
}

}  // namespace
}  // namespace tremolo
