// The file of tetrahedra: a written file is read back, and a reader that trusts nothing.
#include "formats/tets/tets_file.h"

#include <limits>

#include <gtest/gtest.h>

#include "formats/tets/tets_layout.h"
#include "runtime/bodies/tets/contact/tet_surface.h"
#include "tests/support/meshes/random_tet.h"
#include "tests/support/meshes/small_tets.h"
#include "tests/support/section_bytes.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using testing::Bytes;

Bytes tets_bytes() {
  const Result<std::vector<std::byte>> bytes = encode_tets(testing::small_tets());
  EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().message);
  return bytes ? *bytes : Bytes();
}

bool takes_tets(const Bytes& bytes) {
  return static_cast<bool>(read_tets(bytes));
}

TEST(TetsFile, ComesBackAsItWasWritten) {
  const TetsData data = testing::small_tets();
  const testing::TemporaryFolder folder;
  ASSERT_TRUE(write_tets(folder.file("a.tets"), data));
  const Result<TetsFile> file = read_tets(folder.file("a.tets"));
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->mesh.vertices, data.mesh.vertices);
  EXPECT_EQ(file->mesh.tetrahedra, data.mesh.tetrahedra);
  EXPECT_EQ(file->held, data.held);
  EXPECT_EQ(file->materials.of_tet, data.materials.of_tet);
  ASSERT_EQ(file->materials.materials.size(), 2U);
  EXPECT_EQ(file->materials.materials[0].material.young, 1e5);
  ASSERT_TRUE(file->materials.materials[1].material.orthotropic);
  EXPECT_EQ(file->materials.materials[1].material.orthotropic->young,
            data.materials.materials[1].material.orthotropic->young);
  EXPECT_EQ(file->surface.weights, data.surface.weights);
  EXPECT_EQ(file->surface.triangles, data.surface.triangles);
  EXPECT_EQ(file->surface.uvs, data.surface.uvs);
  EXPECT_TRUE(file->grid);
  EXPECT_EQ(file->provenance, data.provenance);
}

TEST(TetsFile, EveryDamagedByteIsNoticed) {
  testing::expect_every_damaged_byte_is_noticed(tets_bytes(), takes_tets);
}

TEST(TetsFile, EveryTruncationIsNoticed) {
  testing::expect_every_truncation_is_noticed(tets_bytes(), takes_tets);
}

TEST(TetsFile, NoFieldIsTrusted) {
  testing::expect_no_field_is_trusted(tets_bytes(), takes_tets);
}

TEST(TetsFile, HostileNumbersAreRefusedByName) {
  const Bytes bytes = tets_bytes();
  const auto refusal = [&bytes](std::string_view section, std::size_t at, auto value) {
    Bytes copy = bytes;
    testing::put(copy, testing::offset_of(copy, std::string(section).c_str()) + at, value);
    testing::reseal(copy);
    const Result<TetsFile> file = read_tets(copy, "a.tets");
    EXPECT_FALSE(file) << section;
    return file ? std::string() : file.error().message;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal("counts", 0, std::uint64_t{1} << 40).find("a count is"), std::string::npos);
  EXPECT_NE(refusal("vertices", 8, nan).find("finite"), std::string::npos);
  EXPECT_NE(refusal("tetrahedra", 0, std::uint32_t{99}).find("not there"), std::string::npos);
  EXPECT_NE(refusal("materials", 0, -1.0).find("materials"), std::string::npos);
  EXPECT_NE(refusal("material_of", 4, std::uint32_t{2}).find("a material"), std::string::npos);
  EXPECT_NE(refusal("held", 0, std::uint32_t{77}).find("ascending"), std::string::npos);
  EXPECT_NE(refusal("drawn_tets", 0, std::uint32_t{12}).find("hangs on none"), std::string::npos);
  EXPECT_NE(refusal("drawn_weights", 0, 1.5).find("sum is not 1"), std::string::npos);
  EXPECT_NE(refusal("drawn_weights", 0, nan).find("sum is not 1"), std::string::npos);
  EXPECT_NE(refusal("distances", 0, -1.0F).find("margin"), std::string::npos);
}

TEST(TetsFile, ATurnedElementIsNotWritten) {
  TetsData data = testing::small_tets();
  std::swap(data.mesh.tetrahedra[3][0], data.mesh.tetrahedra[3][1]);
  const auto bytes = encode_tets(data);
  ASSERT_FALSE(bytes);
  EXPECT_EQ(bytes.error().kind, ErrorKind::kContent);
  EXPECT_NE(bytes.error().message.find("tetrahedron 3"), std::string::npos);
}

// The surface of a body in an affine motion is that motion of the surface, also of the parts
// outside; of the quadratic motion x_i + c x_0^2 within elements too, where control points are its
// blossom.
TEST(TetSurface, FollowsAffineAndQuadraticMotionsExactly) {
  const TetsData data = testing::small_tets();
  const auto model = TetModel::create(data.mesh, data.materials, {});
  ASSERT_TRUE(model);
  const TetSurface surface(*model, data.surface);
  std::vector<Eigen::Vector3d> places(surface.vertices());
  std::vector<Eigen::Vector3f> normals(surface.vertices());
  Eigen::Matrix3d f;
  f << 1.1, 0.3, -0.2, 0.1, 0.9, 0.4, -0.3, 0.2, 1.2;
  const Eigen::Vector3d t(0.5, -1.0, 2.0);
  for (const double bend : {0.0, 2.0}) {
    Eigen::VectorXd x((*model)->rest().size());
    for (std::size_t i = 0; i < (*model)->nodes(); ++i) {
      const Eigen::Vector3d rest = (*model)->rest().segment<3>(3 * i);
      double square = rest.x() * rest.x();
      if (i >= (*model)->vertices()) {
        const MeshEdge& edge = (*model)->edge(i - (*model)->vertices());
        const auto& corners = (*model)->mesh().vertices;
        square = corners[edge.a].x() * corners[edge.b].x();
      }
      x.segment<3>(3 * i) = f * rest + t + bend * square * Eigen::Vector3d::UnitZ();
    }
    surface.place(x, places, normals);
    // The last vertex is outside of its element, where a quadratic field is continued straight.
    const std::size_t count = bend == 0.0 ? places.size() : places.size() - 1;
    for (std::size_t v = 0; v < count; ++v) {
      const Eigen::Vector3d rest = data.surface.vertices[v];
      const Eigen::Vector3d expected =
          f * rest + t + bend * rest.x() * rest.x() * Eigen::Vector3d::UnitZ();
      // Roundings of numbers of size 2.
      EXPECT_LT((places[v] - expected).norm(), 1e-14) << bend << " " << v;
    }
    if (bend > 0.0) continue;
    // All triangles of this surface: the normal of the rotated ones at vertex 0, which has one.
    const Eigen::Vector3d n = (places[1] - places[0]).cross(places[2] - places[0]).normalized();
    EXPECT_LT((normals[0].cast<double>() - n).norm(), 1e-6);  // of float
  }
}

}  // namespace
}  // namespace tremolo
