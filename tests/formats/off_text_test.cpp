// OFF as programs write it, and as it is broken.
#include "formats/polygons/off_text.h"

#include <gtest/gtest.h>

namespace tremolo {
namespace {

// A square of two triangles' worth.
constexpr const char* kSquare = "4 1 4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

OffMesh parsed(const std::string& text) {
  Result<OffMesh> off = parse_off(text);
  EXPECT_TRUE(off) << off.error().message;
  return off ? std::move(*off) : OffMesh{};
}

void expect_square(const std::string& text) {
  const OffMesh off = parsed(text);
  EXPECT_EQ(off.coordinates.size(), 4U) << text;
  EXPECT_EQ(off.corners, (std::vector<VertexId>{0, 1, 2, 3})) << text;
  EXPECT_EQ(off.first, (std::vector<std::size_t>{0, 4})) << text;
}

void expect_refused(const std::string& text, const std::string& part) {
  const Result<OffMesh> off = parse_off(text);
  ASSERT_FALSE(off) << text;
  EXPECT_EQ(off.error().kind, ErrorKind::kContent);
  EXPECT_NE(off.error().message.find(part), std::string::npos) << off.error().message;
}

TEST(OffText, CommentsAndEmptyLinesMayStandAnywhere) {
  expect_square(std::string("OFF\n") + kSquare);
  expect_square(
      "# by hand\n\nOFF # a square\n# counts\n4 1 # of vertices, of faces\n\n0 0 0 # first\n"
      "# second\n1 0 0\n1 1 0\n\n0 1 0\n# faces\n4 0 1 # two\n 2 3 # and two\n# end");
}

TEST(OffText, TheHeaderMayShareItsLineOrBeLeftOut) {
  expect_square(std::string("OFF ") + kSquare);
  expect_square(std::string("off\r\n") + kSquare);
  expect_square(std::string("OFF") + kSquare);
  expect_square(kSquare);
  expect_square(std::string("\xef\xbb\xbfOFF\n") + kSquare);
}

TEST(OffText, CoordinatesMayStandOnLinesOfTheirOwn) {
  expect_square("OFF 4 1 0\n0\n0\n0\n1 0\n0\n1 1\n0\n0 1 0\n4 0 1\n2 3");
}

TEST(OffText, AFaceMayHaveAnyNumberOfCorners) {
  std::string text = "OFF\n300 1 0\n", face = "300";
  for (int i = 0; i < 300; ++i) {
    text += std::to_string(i) + " 0 0\n";
    face += " " + std::to_string(i);
  }
  const OffMesh off = parsed(text + face + "\n");
  EXPECT_EQ(off.corners.size(), 300U);
  EXPECT_EQ(parsed("OFF 1 3 0\n0 0 0\n0\n1 0\n2 0 0\n").first,
            (std::vector<std::size_t>{0, 0, 1, 3}));
}

TEST(OffText, NormalsColoursAndTextureComeWithTheirLetters) {
  const OffMesh off = parsed(
      "STCNOFF\n3 1 0\n0 0 0 0 0 1 255 0 0 255 0.25 0.5\n1 0 0 0 0 1 0 255 0 0.5 1\n"
      "0 1 0 0 1 0 0 51 0 0 0\n3 0 1 2\n");
  ASSERT_EQ(off.normals.size(), 3U);
  EXPECT_EQ(off.normals[2], (OffNumbers{0, 1, 0, 0}));
  ASSERT_EQ(off.colours.size(), 3U);
  EXPECT_EQ(off.colours[0], (OffNumbers{1, 0, 0, 1}));
  EXPECT_FLOAT_EQ(off.colours[2][1], 0.2F);
  EXPECT_EQ(off.colours[2][3], 1) << "no alpha is no glass";
  ASSERT_EQ(off.uvs.size(), 3U);
  EXPECT_EQ(off.uvs[1], (OffNumbers{0.5, 1, 0, 0}));
}

TEST(OffText, FacesMayBePainted) {
  const OffMesh off = parsed("OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 1 0.5 0\n3 0 2 1\n");
  ASSERT_EQ(off.face_colours.size(), 2U);
  EXPECT_EQ(off.face_colours[0], (OffNumbers{1, 0.5, 0, 1}));
  EXPECT_EQ(off.face_colours[1], (OffNumbers{1, 1, 1, 1})) << "white";
  EXPECT_TRUE(parsed(std::string("OFF\n") + kSquare).face_colours.empty());
}

TEST(OffText, WhatIsNotTakenIsTold) {
  const OffMesh more = parsed(std::string("OFF\n") + kSquare + "3 0 1 2\n");
  ASSERT_EQ(more.notes.size(), 1U);
  EXPECT_NE(more.notes[0].find("last of 1 faces"), std::string::npos) << more.notes[0];
  EXPECT_EQ(parsed("OFF\n3 1 0\n0 0 0 9 9 9\n1 0 0 9 9 9\n0 1 0 9 9 9\n3 0 1 2 7\n").notes.size(),
            2U);
}

TEST(OffText, WhatIsNoSurfaceIsRefusedWithItsLine) {
  expect_refused("", "OFF");
  expect_refused("ply\nformat ascii 1.0\n", "expected OFF, COFF");
  expect_refused("OFF BINARY\n", "binary");
  expect_refused(std::string("4OFF\n") + kSquare, "three dimensions");
  expect_refused("nOFF\n3\n3 1 0\n", "three dimensions");
  expect_refused("OFF\n4 -1 0\n", "line 2");
  expect_refused("OFF\n4000000000 1 0\n0 0 0\n", "line 2");
  const std::string triangle = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n";
  expect_refused("OFF\n3 1 0\n0 0 zero\n1 0 0\n0 1 0\n3 0 1 2\n", "line 3");
  expect_refused("OFF\n3 1 0\n0 0 0\n1 0 0 5\n0 1 0\n3 0 1 2\n", "line 4");
  expect_refused("NOFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "expected 3 numbers");
  expect_refused(triangle + "3 0 1 3\n", "line 6");
  expect_refused(triangle + "3 0 -1 2\n", "line 6");
  expect_refused(triangle + "2000000000 0 1 2\n", "line 6");
  expect_refused("OFF\n2 3 0\n0 0 0\n1 0 0\n2 0 1\n# missing ones\n", "behind 1 of 3 faces");
  expect_refused("OFF\n3 1 0\n0 0 0\n1 0 0\n# missing ones\n", "behind 2 of 3 vertices");
}

}  // namespace
}  // namespace tremolo
