#include "common/selector.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/box_mesh.h"

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
                           "file:  "}) {
    const Result<Selector> selector = parse_selector(text);
    ASSERT_FALSE(selector) << text;
    EXPECT_EQ(selector.error().kind, ErrorKind::kUsage) << text;
    EXPECT_NE(selector.error().message.find(kSelectorGrammar), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace tremolo
