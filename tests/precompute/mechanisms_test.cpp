// Mechanisms against the null space of the stiffness, and what is said of them.
#include "precompute/problem/mechanisms.h"

#include <gtest/gtest.h>

#include "precompute/dense/dense_decompositions.h"
#include "precompute/fem/matrices.h"
#include "precompute/system/failure.h"
#include "tests/support/meshes/joined_mesh.h"
#include "tests/support/meshes/random_mesh.h"

namespace tremolo {
namespace {

using testing::cubes;
using testing::vertices_on_plane;

struct Case {
  std::string name;
  TetMesh mesh;
  std::vector<VertexId> fixed;  // none: a free body
  int motions = 0;              // that cost no strain, rigid ones of a free body not counted

  friend void PrintTo(const Case& each, std::ostream* out) { *out << each.name; }
};

VertexId vertex_at(const TetMesh& mesh, const Eigen::Vector3d& x) {
  VertexId v = 0;
  while ((mesh.vertices[v] - x).norm() > 1e-9) ++v;
  return v;
}

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  const auto add = [&](const char* name, const TetMesh& mesh, int held, int free) {
    cases.push_back({std::string(name) + ", clamped", mesh, vertices_on_plane(mesh, 0, 0.0), held});
    cases.push_back({std::string(name) + ", free", mesh, {}, free});
  };
  const TetMesh edge = cubes({{0, 0, 0}, {1, 1, 0}}, 2);
  const TetMesh corner = cubes({{0, 0, 0}, {1, 1, 1}}, 2);
  const TetMesh chain = cubes({{0, 0, 0}, {1, 1, 0}, {2, 2, 0}});
  add("one cube", cubes({{0, 0, 0}}), 0, 0);
  add("two cubes with a face", cubes({{0, 0, 0}, {1, 0, 0}}), 0, 0);
  add("two cubes with an edge", edge, 1, 1);
  add("two cubes with a vertex", corner, 3, 3);
  add("two edges off a line", cubes({{0, 0, 0}, {1, 1, 0}, {1, 1, 1}, {0, 1, 1}}), 0, 0);
  add("two edges on a line",
      cubes(
          {{0, 0, 0}, {0, 0, 1}, {0, 0, 2}, {1, 1, 0}, {2, 1, 0}, {2, 1, 1}, {2, 1, 2}, {1, 1, 2}}),
      1, 1);
  add("a chain of two hinges", chain, 2, 2);
  add("a hinge and a ball joint", cubes({{0, 0, 0}, {1, 1, 0}, {2, 2, 1}}), 4, 4);
  add("four bars", cubes({{0, 0, 0}, {1, 1, 0}, {2, 0, 0}, {1, -1, 0}}), 1, 1);
  add("three cubes about one edge", cubes({{0, 0, 0}, {1, 1, 0}, {1, -1, 0}, {2, 0, 0}}), 1, 1);
  cases.push_back({"a chain held at both ends", chain, vertices_on_plane(chain, 0, 0.0), 0});
  for (VertexId v : vertices_on_plane(chain, 0, 0.3)) cases.back().fixed.push_back(v);
  cases.push_back({"a hinge blocked by one vertex", edge, vertices_on_plane(edge, 0, 0.0), 0});
  cases.back().fixed.push_back(vertex_at(edge, {0.2, 0.2, 0}));
  cases.push_back({"a ball joint and one vertex", corner, vertices_on_plane(corner, 0, 0.0), 1});
  cases.back().fixed.push_back(vertex_at(corner, {0.2, 0.2, 0.2}));
  cases.push_back({"both pieces held by a vertex of three",
                   corner,
                   {vertex_at(corner, {0, 0, 0}), vertex_at(corner, {0.1, 0, 0}),
                    vertex_at(corner, {0.2, 0.2, 0.2})},
                   2});
  for (Case& each : cases) std::sort(each.fixed.begin(), each.fixed.end());
  return cases;
}

// Motions that cost no strain, of the matrix that is solved with.
int null_space(const TetMesh& mesh, const std::vector<VertexId>& fixed) {
  const DofMap map = make_dof_map(mesh, fixed, 1);
  const LocalDofs local = local_dofs(mesh, map, 0);
  const Solid solid = make_solid(mesh, {1e6, 0.3, 1000.0});
  const Matrices matrices = assemble(solid, map, local, MassKind::kConsistent);
  const Eigen::MatrixXd k =
      multiply(matrices.stiffness.get(), Eigen::MatrixXd::Identity(local.dofs(), local.dofs()));
  const Eigen::VectorXd values = eigenpairs(k).values;
  // Rounding leaves 1e-16 of the largest, bending of a few cubes is far above 1e-10.
  return static_cast<int>((values.array() < 1e-10 * values.maxCoeff()).count());
}

int found_motions(TetMesh mesh, const std::vector<VertexId>& fixed) {
  const MeshReport report = *check_mesh(mesh);
  int motions = 0;
  for (const Mechanism& mechanism :
       find_mechanisms(mesh, report, rigid_pieces(mesh), fixed, fixed.empty()))
    motions += mechanism.motions;
  return motions;
}

class Mechanisms : public ::testing::TestWithParam<Case> {};

TEST_P(Mechanisms, AreTheNullSpaceOfTheStiffness) {
  const Case& each = GetParam();
  EXPECT_EQ(found_motions(each.mesh, each.fixed), each.motions);
  EXPECT_EQ(null_space(each.mesh, each.fixed), each.motions + (each.fixed.empty() ? 6 : 0));
}

TEST_P(Mechanisms, DoNotDependOnPlaceSizeOrNumbers) {
  testing::Random random(3);
  const Case& each = GetParam();
  const auto order = testing::random_permutation(each.mesh.vertices.size(), random);
  TetMesh mesh = testing::renumbered(each.mesh, order);
  const Eigen::Matrix3d turn = testing::random_rotation(random);
  for (Eigen::Vector3d& x : mesh.vertices) x = 37.0 * (turn * x) + Eigen::Vector3d(40, -20, 3);
  std::shuffle(mesh.tetrahedra.begin(), mesh.tetrahedra.end(), random);
  std::vector<VertexId> fixed;
  for (VertexId v : each.fixed) fixed.push_back(order[v]);
  std::sort(fixed.begin(), fixed.end());
  EXPECT_EQ(found_motions(mesh, fixed), each.motions);
}

INSTANTIATE_TEST_SUITE_P(All, Mechanisms, ::testing::ValuesIn(all_cases()),
                         [](const auto& each) { return std::to_string(each.index); });

TEST(Mechanisms, OfHeapsOfCubesAreTheNullSpaceToo) {
  testing::Random random(5);
  int several = 0, moving = 0;
  for (int n = 0; n < 60; ++n) {
    std::vector<std::array<int, 3>> places;
    for (int place = 0; place < 27; ++place)
      if (random() % 3 == 0) places.push_back({place % 3, place / 3 % 3, place / 9});
    if (places.empty()) continue;
    TetMesh mesh = cubes(places);
    const MeshReport report = *check_mesh(mesh);
    const int found = found_motions(mesh, {});
    EXPECT_EQ(null_space(mesh, {}), found + 6 * static_cast<int>(report.parts)) << n;
    several += report.parts > 1;
    moving += found > 0;
  }
  EXPECT_GT(several, 5);
  EXPECT_GT(moving, 30);
}

TEST(Mechanisms, OfAHingeSayWhereAndWhatHangs) {
  TetMesh mesh = cubes({{0, 0, 0}, {1, 1, 0}}, 2);
  const MeshReport report = *check_mesh(mesh);
  const std::vector<VertexId> fixed = vertices_on_plane(mesh, 0, 0.0);
  const auto found = find_mechanisms(mesh, report, rigid_pieces(mesh), fixed, false);
  ASSERT_EQ(found.size(), 1u);
  ASSERT_EQ(found[0].joints.size(), 1u);
  const Joint& joint = found[0].joints[0];
  EXPECT_EQ(joint.piece, 1);
  EXPECT_EQ(joint.on, 0);
  EXPECT_EQ(joint.motions, 1);
  ASSERT_EQ(joint.vertices.size(), 3u);
  EXPECT_NEAR((mesh.vertices[joint.vertices[0]] - mesh.vertices[joint.vertices[1]]).norm(), 0.1,
              1e-12)
      << "the ends come first";
}

TEST(Mechanisms, OfALoopNameTheJointsThatMoveOnly) {
  // Four bars, and a fifth piece that two edges off a line hold to the first.
  TetMesh mesh = cubes({{0, 0, 0}, {1, 1, 0}, {2, 0, 0}, {1, -1, 0}});
  testing::join(mesh, cubes({{-1, 1, 0}, {-1, 1, -1}, {-1, 0, -1}}), {0, 0, 0});
  const MeshReport report = *check_mesh(mesh);
  const auto found = find_mechanisms(mesh, report, rigid_pieces(mesh), {}, true);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].motions, 1);
  EXPECT_EQ(found[0].joints.size(), 4u);
  for (const Joint& joint : found[0].joints) EXPECT_EQ(joint.motions, 1);
}

TEST(Mechanisms, OfALongChainAreCounted) {
  std::vector<std::array<int, 3>> places;
  for (int i = 0; i < kMostPieces; ++i) places.push_back({i, i, 0});
  TetMesh mesh = cubes(places);
  EXPECT_EQ(found_motions(mesh, vertices_on_plane(mesh, 0, 0.0)), kMostPieces - 1);
  places.push_back({kMostPieces, kMostPieces, 0});
  mesh = cubes(places);
  EXPECT_EQ(found_motions(mesh, vertices_on_plane(mesh, 0, 0.0)), 0) << "not checked";
}

std::string refusal(TetMesh mesh, const std::vector<VertexId>& fixed) {
  const MeshReport report = *check_mesh(mesh);
  try {
    require_no_loose_piece(mesh, report, fixed, fixed.empty());
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.error().kind, ErrorKind::kContent);
    return failure.error().message;
  }
  return "";
}

void expect_words(const std::string& text, const std::vector<std::string>& words) {
  for (const std::string& word : words)
    EXPECT_NE(text.find(word), std::string::npos) << word << " in: " << text;
}

TEST(LoosePieces, AreDescribed) {
  const TetMesh edge = cubes({{0, 0, 0}, {1, 1, 0}}, 2);
  expect_words(
      refusal(edge, vertices_on_plane(edge, 0, 0.0)),
      {"piece 2 of 2 (27 vertices, 48 tetrahedra, around 0.15, 0.15, 0.05)", "turns on piece 1",
       "the line through vertex 26 at 0.1, 0.1, 0.1", "a hinge", "--fix"});
  const TetMesh corner = cubes({{0, 0, 0}, {1, 1, 1}});
  expect_words(refusal(corner, {}), {"about vertex 7 at 0.1, 0.1, 0.1", "a ball joint: 3 motions"});
  const TetMesh one = cubes({{0, 0, 0}});
  expect_words(refusal(one, {0}), {"part 1 of 1", "is not held", "3 rigid motions are left",
                                   "rotations about vertex 0 at 0, 0, 0, the only fixed one"});
  expect_words(refusal(one, {0, 7}), {"1 rigid motion is left", "about the line through vertex",
                                      "vertex 7 at 0.1, 0.1, 0.1"});
  EXPECT_EQ(refusal(one, {0, 1, 2}), "");
  EXPECT_EQ(refusal(one, {}), "");
  TetMesh two = one;
  testing::join(two, one, {1, 0, 0});
  expect_words(refusal(two, {0, 1, 2}),
               {"part 2 of 2", "6 rigid motions are left (3 translations and 3 rotations"});
  // The first of two pieces is fixed by a line of vertices, the second by another.
  const TetMesh held = cubes({{0, 0, 0}, {1, 1, 0}});
  expect_words(refusal(held, {0, 1, 4}), {"piece 2 of 2", "a hinge"});
}

TEST(LoosePieces, OfAFreeBodyAreItsParts) {
  TetMesh two = cubes({{0, 0, 0}});
  MeshReport report = *check_mesh(two);
  EXPECT_TRUE(rigid_motion_notes(two, report).empty());
  testing::join(two, cubes({{0, 0, 0}}), {1, 0, 0});
  report = *check_mesh(two);
  const auto notes = rigid_motion_notes(two, report);
  ASSERT_EQ(notes.size(), 2u);
  expect_words(notes[1], {"part 2 of 2 (8 vertices around 1.05, 0.05, 0.05)", "left out"});
}

}  // namespace
}  // namespace tremolo
