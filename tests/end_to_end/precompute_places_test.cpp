// tremolo-precompute and positions: vertices by their positions, axes, units, pictures of fixed
// vertices.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_reader.h"
#include "tests/support/precompute_folder.h"

namespace tremolo {
namespace {

using PrecomputePlaces = PrecomputeFolder;

TEST_F(PrecomputePlaces, NearTellsWhichVertexItTookAndHowFarAway) {
  const std::string load = " --load-force 0,0,-1 --load-at ";
  const ProgramResult one = run(kBlock + load + "near:0.4,0.16,0.2");
  ASSERT_EQ(one.code, 0) << one.err;
  EXPECT_NE(one.err.find("--load-at near:0.4,0.16,0.2: vertex 44 at (0.4, 0.15, 0.2) m, 0.01 m"),
            std::string::npos)
      << one.err;
  const ProgramResult held =
      run("block.veg -o held.tremolo --fix 'x<0.001' --fix near:0,0.01,0 --point-mass "
          "near:0.4,0.16,0.2=1 --linear-modes 4 --modes 8");
  ASSERT_EQ(held.code, 0) << held.err;
  EXPECT_NE(held.err.find("--fix near:0,0.01,0: vertex 0 at (0, 0, 0) m, 0.01 m"),
            std::string::npos)
      << held.err;
  EXPECT_NE(held.err.find("--point-mass near:0.4,0.16,0.2: vertex 44 at"), std::string::npos)
      << held.err;
  const ProgramResult along =
      run("reference block.veg --static --fix 'x<0.001' --fix-y near:0.4,0.16,0.2 --load-at "
          "'x>0.399' --load-force 0,0,-1");
  EXPECT_NE(along.err.find("--fix-y near:0.4,0.16,0.2: vertex 44 at"), std::string::npos)
      << along.err;
  const ProgramResult select = run("block.veg --select near:0.4,0.15,0.2,2");
  EXPECT_NE(select.err.find("2 vertices, the nearest vertex 44"), std::string::npos) << select.err;
  const ProgramResult moved =
      run_program(folder_, TREMOLO_BIN_DIR
                  "/tremolo run out.tremolo --duration 0.01 --load constant --out moved --at "
                  "near:0.4,0.16,0.2 --force 0,0,1");
  EXPECT_EQ(moved.code, 0) << moved.err;
  EXPECT_NE(moved.err.find("--at near:0.4,0.16,0.2: vertex 44 at"), std::string::npos) << moved.err;
  const ProgramResult probed =
      run_program(folder_, TREMOLO_BIN_DIR
                  "/tremolo run out.tremolo --duration 0.01 --load none --probe near:0.4,0.16,0.2");
  EXPECT_NE(probed.err.find("--probe near:0.4,0.16,0.2: vertex 44 at"), std::string::npos)
      << probed.err;
  const ProgramResult inspected = run_program(
      folder_, TREMOLO_BIN_DIR "/tremolo inspect out.tremolo --select near:0.4,0.16,0.2");
  EXPECT_NE(inspected.err.find("near:0.4,0.16,0.2: vertex 44 at"), std::string::npos)
      << inspected.err;
}

TEST_F(PrecomputePlaces, UpYTurnsTheModelAndItsSelectors) {
  const std::string options = " --linear-modes 4 --modes 8 --threads 1 --json";
  const ProgramResult plain =
      run("block.veg -o plain.tremolo --fix 'y<0.001' --load-at 'y>0.149' --load-force 0,-1,0" +
          options);
  const ProgramResult turned = run(
      "block.veg -o turned.tremolo --up y --fix 'z<0.001' --load-at 'z>0.149' --load-force 0,0,-1" +
      options);
  ASSERT_EQ(plain.code, 0) << plain.err;
  ASSERT_EQ(turned.code, 0) << turned.err;
  const auto frequencies = nlohmann::json::parse(plain.out)["frequencies_hz"];
  const auto again = nlohmann::json::parse(turned.out)["frequencies_hz"];
  for (std::size_t i = 0; i < frequencies.size(); ++i)
    EXPECT_NEAR(again[i], double(frequencies[i]), 1e-6 * double(frequencies[i]));
  const auto a = read_basis(folder_ + "/plain.tremolo"),
             b = read_basis(folder_ + "/turned.tremolo");
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->surface.rest.size(), b->surface.rest.size());
  for (std::size_t v = 0; v < a->surface.rest.size(); ++v) {
    const Eigen::Vector3d& x = a->surface.rest[v];
    EXPECT_EQ(b->surface.rest[v], Eigen::Vector3d(x[0], -x[2], x[1]));
  }
  expect_failure(run(kBlock + " --up x"), 2, "--up");
}

// The drawn surface is at the position of the solid.
TEST_F(PrecomputePlaces, UpYTurnsWhatIsDrawnToo) {
  std::ofstream obj(folder_ + "/box.obj");
  for (const double x : {0.0, 0.4})
    for (const double y : {0.0, 0.15})
      for (const double z : {0.0, 0.2}) obj << "v " << x << ' ' << y << ' ' << z << '\n';
  obj << "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n";
  obj.close();
  for (const std::string solid : {"box.obj --size 0.1", "block.veg --render box.obj"}) {
    const ProgramResult made = run(solid +
                                   " -o up.tremolo --up y --fix 'z<0.001' --linear-modes 4 "
                                   "--modes 8");
    ASSERT_EQ(made.code, 0) << made.err;
    const auto basis = read_basis(folder_ + "/up.tremolo");
    ASSERT_TRUE(basis);
    ASSERT_TRUE(basis->render);
    const BoundingBox drawn = bounding_box(basis->render->surface.vertices);
    EXPECT_LE((drawn.low - Eigen::Vector3d(0, -0.2, 0)).norm(), 1e-6) << solid;
    EXPECT_LE((drawn.high - Eigen::Vector3d(0.4, 0, 0.15)).norm(), 1e-6) << solid;
  }
}

// It stands on its square end along y and has a ridge above.
TEST_F(PrecomputePlaces, WhoHoldsTheSideOfWhatStandsOnYIsTold) {
  TetMesh standing = box_mesh({4, 4, 4}, {1, 1, 1});
  for (Eigen::Vector3d& x : standing.vertices)
    for (const int other : {0, 2}) x[other] = 0.5 + (1 - 0.9 * x[1]) * (x[other] - 0.5);
  const std::string hint = "z<30% takes the body's side, if y points up";
  const std::string modes = " --linear-modes 4 --modes 8 -o side.tremolo";
  const ProgramResult side = run_on(standing, "--fix 'z<30%'" + modes);
  EXPECT_EQ(side.code, 0) << side.err;
  EXPECT_NE(side.err.find(hint), std::string::npos) << side.err;
  EXPECT_NE(run_on(standing, "--select 'z<30%'").err.find(hint), std::string::npos);
  // Also if the side does not hold the body: here it is an edge, about which it can rotate.
  const ProgramResult edge = run_on(standing, "--fix 'z<1%'" + modes);
  EXPECT_EQ(edge.code, 3) << edge.err;
  EXPECT_NE(edge.err.find("z<1% takes the body's side, if y points up"), std::string::npos)
      << edge.err;
  const ProgramResult turned = run_on(standing, "--up y --fix 'z<30%'" + modes);
  EXPECT_EQ(turned.code, 0) << turned.err;
  EXPECT_EQ(turned.err.find("takes the body's side"), std::string::npos) << turned.err;
}

TEST_F(PrecomputePlaces, PreviewPaintsWhatIsHeldAndLoadedAndComputesNothing) {
  const ProgramResult alone =
      run("block.veg --fix 'x<0.001' --load-at 'x>0.399' --load-force 0,0,-5 --preview look.ply");
  ASSERT_EQ(alone.code, 0) << alone.err;
  EXPECT_NE(alone.err.find("look.ply: 9 vertices held, 9 loaded"), std::string::npos) << alone.err;
  EXPECT_EQ(slurp(folder_ + "/out.tremolo"), kOld);
  const std::string ply = slurp(folder_ + "/look.ply");
  EXPECT_NE(ply.find("property uchar red"), std::string::npos);
  // The hull's 42 vertices, the arrow's 50: floats and colour.
  const std::size_t data = ply.find("end_header\n") + 11;
  ASSERT_GT(ply.size(), data + 92 * 15);
  EXPECT_NE(ply.find("element vertex 92\n"), std::string::npos);
  std::map<std::string, int> count;
  for (std::size_t v = 0; v < 92; ++v) ++count[ply.substr(data + 15 * v + 12, 3)];
  EXPECT_EQ(count[std::string("\x28\x5a\xdc")], 9) << "blue";
  EXPECT_EQ(count[std::string("\xdc\x28\x1e")], 9 + 50) << "red, with the arrow";
  EXPECT_EQ(count[std::string("\xc8\xc8\xc8")], 24) << "grey";
  // The arrow's tail and tip are last: it points down, at or from the middle of the loaded
  // vertices.
  float tail[3], tip[3];
  std::memcpy(tail, ply.data() + data + 15 * 90, sizeof(tail));
  std::memcpy(tip, ply.data() + data + 15 * 91, sizeof(tip));
  for (const float* end : {tail, tip}) {
    EXPECT_NEAR(end[0], 0.4, 1e-6);
    EXPECT_NEAR(end[1], 0.075, 1e-6);
  }
  EXPECT_NEAR(tail[2] - tip[2], 0.25 * std::hypot(0.4, 0.15, 0.2), 1e-6);
  EXPECT_NEAR(std::min(std::abs(tail[2] - 0.1), std::abs(tip[2] - 0.1)), 0, 1e-6);

  ASSERT_EQ(run("block.veg --select 'y<0.001' --preview chosen.ply").code, 0);
  EXPECT_NE(slurp(folder_ + "/chosen.ply").find(std::string("\x28\xaa\x3c")), std::string::npos);
  expect_failure(run("block.veg --fix none --preview look.obj"), 2, "look.obj");
  expect_failure(run(kBlock + " --preview block.veg"), 2, "block.veg");

  // Beside a model, which stays the same byte for byte.
  ASSERT_EQ(run("block.veg -o a.tremolo --fix 'x<0.001' --preview a.ply").code, 0);
  ASSERT_EQ(run("block.veg -o b.tremolo --fix 'x<0.001'").code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder_ + "/a.ply"));
  EXPECT_EQ(slurp(folder_ + "/a.tremolo"), slurp(folder_ + "/b.tremolo"));
}

TEST_F(PrecomputePlaces, NearFromAnotherWorldIsRefused) {
  for (const std::string point : {"1e30,0,0", "400,150,200", "0,0,1e200"})
    expect_failure(run(kBlock + " --load-force 0,0,-1 --load-at near:" + point), 3,
                   "m away from the nearest vertex");
  EXPECT_EQ(run("block.veg --select near:1,1,1").code, 0) << "outside, but not far";
}

TEST_F(PrecomputePlaces, AUnitScalesATetrahedralMeshLikeASurface) {
  const auto report = [&](const std::string& arguments) {
    const ProgramResult result =
        run(arguments +
            " -o scaled.tremolo --linear-modes 4 --modes 8 --json --point-mass "
            "'x>99%=0.5'");
    EXPECT_EQ(result.code, 0) << result.err;
    return nlohmann::json::parse(result.out);
  };
  TetMesh millimetres = block_;
  for (Eigen::Vector3d& x : millimetres.vertices) x *= 1000.0;
  write_veg(folder_ + "/mm.veg", millimetres);
  const auto metres = report("block.veg --fix 'x<0.001'");
  for (const char* unit : {"--unit mm", "--unit 0.001", "--mesh-unit mm"}) {
    const auto scaled = report(std::string("mm.veg --fix 'x<0.001' ") + unit);
    for (std::size_t i = 0; i < 8; ++i) {
      const double f = metres["frequencies_hz"][i];
      EXPECT_NEAR(scaled["frequencies_hz"][i], f, 1e-8 * f) << unit;
    }
    EXPECT_NEAR(scaled["total_mass_kg"], metres["total_mass_kg"].get<double>(), 1e-9);
    EXPECT_NE(scaled["notes"].dump().find("the mesh's unit: "), std::string::npos);
  }
  // Nothing is said about a body of 0.4 m; one of 400 m may be in millimetres.
  EXPECT_EQ(metres["notes"].dump().find("--unit"), std::string::npos) << metres["notes"];
  const std::string doubts = report("mm.veg --fix 'x<1'")["notes"].dump();
  EXPECT_NE(doubts.find("m across: if its unit is not 1 m, say so, as in --unit mm"),
            std::string::npos)
      << doubts;
  expect_failure(run(std::string("block.veg --unit inch ") + kGood), 2, "inch");
}

TEST_F(PrecomputePlaces, LayersAcrossWallsAndWhatTheyMeanAreTold) {
  write_veg(folder_ + "/plate.veg", box_mesh({12, 12, 1}, {0.4, 0.4, 0.01}));
  const ProgramResult result =
      run("plate.veg -o plate.tremolo --fix 'x<0.001' --poisson 0.49 --linear-modes 3 --order 1 "
          "--json");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.err.find("are 1 layers of linear tetrahedra thick and nu is 0.49: frequencies "
                            "of bending come out too high, by about"),
            std::string::npos)
      << result.err;
  const auto locking = nlohmann::json::parse(result.out)["locking"];
  EXPECT_NEAR(locking["wall_thickness_m"], 0.01, 1e-12);
  EXPECT_NEAR(locking["layers"], 1.0, 1e-9);
  EXPECT_EQ(locking["poisson"], 0.49);
  EXPECT_GT(locking["frequency_excess"], 1.0);
}

}  // namespace
}  // namespace tremolo
