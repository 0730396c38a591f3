#include "common/mesh/selector.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/meshes/box_mesh.h"

namespace tremolo {
namespace {

using Ids = std::vector<VertexId>;

// Two cubes side by side; x is 0, 1, 2 for ids 0, 1, 2 modulo 3.
TetMesh two_cubes() {
  TetMesh mesh = testing::box_mesh({2, 1, 1}, {2, 1, 1});
  mesh.node_sets["foot"] = {0, 3};
  mesh.node_sets["xylophone<3"] = {5};
  return mesh;
}

Result<Ids> select(const std::string& text, const TetMesh& mesh) {
  const Result<Selector> selector = parse_selector(text);
  if (!selector) return selector.error();
  return select_vertices(*selector, mesh);
}

void expect_selected(const std::string& text, const Ids& expected) {
  const Result<Ids> ids = select(text, two_cubes());
  ASSERT_TRUE(ids) << ids.error().message;
  EXPECT_EQ(*ids, expected) << text;
}

TEST(Selector, ComparisonsIncludeTheirBoundOnlyWhenTheySaySo) {
  expect_selected("x<1", {0, 3, 6, 9});
  expect_selected("x<=1", {0, 1, 3, 4, 6, 7, 9, 10});
  expect_selected("x>1", {2, 5, 8, 11});
  expect_selected("x>=1", {1, 2, 4, 5, 7, 8, 10, 11});
  expect_selected("y>0.5", {3, 4, 5, 9, 10, 11});
  expect_selected("z<+1e-3", {0, 1, 2, 3, 4, 5});
}

TEST(Selector, BlanksDoNotMatter) {
  expect_selected("  x  <  1 ", {0, 3, 6, 9});
  expect_selected("vertex: 4 , 2", {2, 4});
}

TEST(Selector, ABoxIncludesItsBounds) {
  expect_selected("box:1,0,0,2,1,0", {1, 2, 4, 5});
  expect_selected("box:0.5,-1,-1,1.5,0.5,9", {1, 7});
}

TEST(Selector, PercentagesAreOfTheExtent) {
  expect_selected("x<50%", {0, 3, 6, 9});
  expect_selected("x<=50%", {0, 1, 3, 4, 6, 7, 9, 10});
  expect_selected("x>=100%", {2, 5, 8, 11});
  expect_selected("x<=0%", {0, 3, 6, 9});
  expect_selected("box:50%,0%,0%,100%,100%,0%", {1, 2, 4, 5});
  expect_selected("sphere:0%,0%,0%,41%", {0, 1, 3, 6});  // the diagonal is sqrt(6): 1.004 m
}

TEST(Selector, PercentagesStartAtTheLowEndOfWhatCanBeChosen) {
  TetMesh mesh = two_cubes();
  for (Eigen::Vector3d& x : mesh.vertices) x += Eigen::Vector3d(10, 0.1, -3);
  mesh.vertices.emplace_back(-100, 0, 0);  // belongs to no tetrahedron
  EXPECT_EQ(*select("x<50%", mesh), (Ids{0, 3, 6, 9}));
  EXPECT_EQ(*select("y>=100%", mesh), (Ids{3, 4, 5, 9, 10, 11})) << "the end itself";
}

TEST(Selector, ASphereIncludesItsSurface) {
  expect_selected("sphere:0,0,0,1", {0, 1, 3, 6});
  expect_selected("sphere:2,1,1,0", {11});
}

TEST(Selector, APlaneChoosesItselfAndTheSideOfItsNormal) {
  expect_selected("plane:1,0,0,1,0,0", {1, 2, 4, 5, 7, 8, 10, 11});
  expect_selected("plane:1,0,0,-2,0,0", {0, 1, 3, 4, 6, 7, 9, 10});
  expect_selected("plane:50%,0,0;1,0,0", {1, 2, 4, 5, 7, 8, 10, 11});
  // Through (1, 0, 0), (0, 1, 0) and (0, 0, 1), away from the origin.
  expect_selected("plane:1,0,0,1,1,1", {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
  expect_selected("plane:1,0,0,-1,-1,-1", {0, 1, 3, 6});
}

TEST(Selector, WhatIsFarOutsideStaysOutside) {
  EXPECT_FALSE(select("plane:1e300,0,0,1,0,0", two_cubes()));
  expect_selected("plane:-1e300,0,0,1,0,0", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
  TetMesh wide = two_cubes();
  for (Eigen::Vector3d& x : wide.vertices) x += Eigen::Vector3d(1e3, 1e3, 1e3);
  const Result<Ids> beyond = select("near:1e308%,0,0,2", wide);
  ASSERT_FALSE(beyond);
  EXPECT_NE(beyond.error().message.find("beyond"), std::string::npos);
}

TEST(Selector, NearChoosesTheNearestAndOfEqualsTheFirst) {
  expect_selected("near:2.1,0.9,1.4", {11});
  expect_selected("near:1.9,0,0,2", {1, 2});
  expect_selected("near:100%,100%,100%,1", {11});
  expect_selected("near:0.5,0,0", {0});
  expect_selected("near:0,0,0,1000", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
}

TEST(Selector, NearSaysWhatItTookAndRefusesAnotherWorld) {
  const TetMesh mesh = two_cubes();
  const auto choices = [&](const std::string& text) {
    return near_choices(*parse_selector(text), selection_space(mesh));
  };
  EXPECT_TRUE(choices("x<1").empty());
  const std::vector<NearChoice> two = choices("x<5 and near:1.9,0,0,2");
  ASSERT_EQ(two.size(), 1U);
  EXPECT_EQ(two[0].count, 2U);
  EXPECT_EQ(two[0].nearest, 2);
  EXPECT_NEAR(two[0].distance, 0.1, 1e-12);
  EXPECT_NEAR(two[0].farthest, 0.9, 1e-12);
  EXPECT_EQ(describe_near(choices("near:2,0,-0.5")[0], 77),
            "near:2,0,-0.5: vertex 77 at (2, 0, 0) m, 0.5 m from that point");
  for (const char* far : {"near:1e30,0,0", "near:0,-30,0,3", "near:1e300,0,0"}) {
    const Result<Ids> refused = select(far, mesh);
    ASSERT_FALSE(refused) << far;
    EXPECT_EQ(refused.error().kind, ErrorKind::kContent);
    EXPECT_NE(refused.error().message.find("m away from the nearest"), std::string::npos);
  }
}

TEST(Selector, ColoursAreChosenWithinATolerance) {
  TetMesh mesh = two_cubes();
  mesh.colours.assign(12, Colour{255, 255, 255, 255});
  mesh.colours[3] = {255, 0, 0, 255};
  mesh.colours[4] = {200, 60, 10, 255};
  mesh.colours[5] = {255, 0, 0, 0};  // bare
  mesh.colours[7] = {190, 0, 0, 255};
  EXPECT_EQ(*select("colour:red", mesh), (Ids{3, 4}));
  EXPECT_EQ(*select("color:Red", mesh), (Ids{3, 4}));
  EXPECT_EQ(*select("colour:#ff0000,0", mesh), (Ids{3}));
  EXPECT_EQ(*select("colour:red,65", mesh), (Ids{3, 4, 7}));
  const Result<Ids> none = select("colour:blue", mesh);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().kind, ErrorKind::kContent);
  for (const char* part : {"(2, 1, 1)", "`foot`", "#ffffff (8 vertices)", "#c83c0a (1 vertices)"})
    EXPECT_NE(none.error().message.find(part), std::string::npos) << none.error().message;
  EXPECT_NE(select("colour:red", two_cubes()).error().message.find("not painted"),
            std::string::npos);
}

// As deep as a command line can be long: neither the stack nor memory may grow with its square.
TEST(Selector, AChainOfManyPartsIsAListAndNotATower) {
  constexpr std::size_t kParts = 20'000;
  std::string text = "x<1";
  for (std::size_t n = 1; n < kParts; ++n) text += " and x<1";
  const Result<Selector> selector = parse_selector(text);
  ASSERT_TRUE(selector) << selector.error().message;
  EXPECT_EQ(selector->text, text);
  EXPECT_EQ(selector->further.size(), kParts - 1);
  for (const Selector& part : selector->further) ASSERT_EQ(part.text, "x<1");
}

TEST(Selector, AndKeepsWhatIsInAll) {
  expect_selected("x<=1 and y>0.5", {3, 4, 9, 10});
  expect_selected("x<=1 and y>0.5 and vertex:4,5", {4});
  expect_selected("foot and y<1", {0});
  EXPECT_EQ(select("x<1 and x>1", two_cubes()).error().kind, ErrorKind::kContent);
  EXPECT_EQ(select("x<1 and feet", two_cubes()).error().kind, ErrorKind::kUsage);
}

TEST(Selector, EverySetCanBeReachedByItsName) {
  TetMesh mesh = two_cubes();
  mesh.node_sets["x<1"] = {7};
  mesh.node_sets["none"] = {8};
  mesh.node_sets["head and shoulders"] = {9};
  EXPECT_EQ(*select("set:x<1", mesh), (Ids{7}));
  EXPECT_EQ(*select("set:none", mesh), (Ids{8}));
  EXPECT_EQ(*select("head and shoulders", mesh), (Ids{9}));
}

TEST(Selector, AListOfVerticesIsDescribedWithItsBox) {
  const TetMesh mesh = two_cubes();
  EXPECT_EQ(describe_vertices({0, 5}, {mesh.vertices[0], mesh.vertices[5]}),
            "2 vertices from (0, 0, 0) to (2, 1, 0) m: 0 5");
  EXPECT_EQ(describe_vertices({}, {}), "no vertex");
}

TEST(Selector, VertexListsAreSortedAndWithoutRepeats) {
  expect_selected("vertex:7", {7});
  expect_selected("vertex:7,1,7,3", {1, 3, 7});
}

TEST(Selector, NoneSelectsNothingAndIsNoError) {
  expect_selected("none", {});
}

TEST(Selector, OtherTextsAreNamesOfSets) {
  expect_selected("foot", {0, 3});
  expect_selected("xylophone<3", {5});
}

TEST(Selector, AFileIsLeftToTheCaller) {
  Result<Selector> selector = parse_selector("file:some ids.txt");
  ASSERT_TRUE(selector);
  auto* file = std::get_if<SelectFile>(&selector->choice);
  ASSERT_NE(file, nullptr);
  EXPECT_EQ(file->path, "some ids.txt");
  file->ids = {9, 2};
  const Result<Ids> ids = select_vertices(*selector, two_cubes());
  ASSERT_TRUE(ids);
  EXPECT_EQ(*ids, (Ids{2, 9}));
}

TEST(Selector, VerticesWithoutTetrahedronAreNeverSelected) {
  TetMesh mesh = two_cubes();
  mesh.vertices.emplace_back(0, 0, 0);
  mesh.node_sets["loose"] = {12};
  mesh.node_sets["both"] = {2, 12};
  EXPECT_EQ(*select("x<1", mesh), (Ids{0, 3, 6, 9}));
  EXPECT_EQ(*select("both", mesh), (Ids{2}));
  EXPECT_EQ(select("loose", mesh).error().kind, ErrorKind::kContent);
  EXPECT_EQ(select("vertex:12", mesh).error().kind, ErrorKind::kContent);
}

TEST(Selector, NothingSelectedIsAnErrorThatShowsTheMesh) {
  for (const char* text : {"x<-1", "box:5,5,5,6,6,6"}) {
    const Result<Ids> ids = select(text, two_cubes());
    ASSERT_FALSE(ids);
    EXPECT_EQ(ids.error().kind, ErrorKind::kContent);
    for (const char* part : {text, "(0, 0, 0)", "(2, 1, 1)", "`foot`"})
      EXPECT_NE(ids.error().message.find(part), std::string::npos) << ids.error().message;
  }
}

TEST(Selector, VertexIdsOutOfRangeAreContentErrors) {
  const Result<Ids> ids = select("vertex:3,12", two_cubes());
  ASSERT_FALSE(ids);
  EXPECT_EQ(ids.error().kind, ErrorKind::kContent);
  EXPECT_NE(ids.error().message.find("vertex 12"), std::string::npos);
}

TEST(Selector, UnknownNamesAreUsageErrorsThatListTheSets) {
  const Result<Ids> ids = select("feet", two_cubes());
  ASSERT_FALSE(ids);
  EXPECT_EQ(ids.error().kind, ErrorKind::kUsage);
  EXPECT_NE(ids.error().message.find("`foot`"), std::string::npos);
}

TEST(Selector, MalformedTextsAreUsageErrorsThatShowTheGrammar) {
  for (const char* text : {"",
                           "  ",
                           "x<",
                           "x=1",
                           "x==1",
                           "y<abc",
                           "z>1e",
                           "x<nan",
                           "x>inf",
                           "x<1,2",
                           "x<1 2",
                           "x<+-1",
                           "box:",
                           "box:1,2,3",
                           "box:0,0,0,1,1,1,1",
                           "box:0,0,0,-1,1,1",
                           "box:0,0,0,1,1,nan",
                           "vertex:",
                           "vertex:a",
                           "vertex:1,",
                           "vertex:,1",
                           "vertex:-1",
                           "vertex:1.5",
                           "vertex:99999999999",
                           "file:",
                           "file:  ",
                           "x<1%%",
                           "x<%",
                           "sphere:0,0,0",
                           "sphere:0,0,0,-1",
                           "plane:0,0,0,0,0,0",
                           "plane:1,0,0,1",
                           "plane:0,0,0,50%,0,0",
                           "near:1,2",
                           "near:1,2,3,0",
                           "near:1,2,3,x",
                           "near:1,2,3,4,5",
                           "colour:",
                           "colour:reddish",
                           "colour:#ff00",
                           "colour:#gg0000",
                           "colour:#+f0000",
                           "colour:red,256",
                           "colour:red,-1",
                           "set:",
                           "x<1 and ",
                           "x<1 and none",
                           "none and x<1"}) {
    const Result<Selector> selector = parse_selector(text);
    ASSERT_FALSE(selector) << text;
    EXPECT_EQ(selector.error().kind, ErrorKind::kUsage) << text;
    EXPECT_NE(selector.error().message.find(kSelectorGrammar), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace tremolo
