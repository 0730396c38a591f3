// runtime/tremolo_scene.h: worlds in files of other programs.
#include <cstring>
#include <fstream>
#include <sstream>

#include "tests/mixed/world_c_api.h"
#include "tests/support/run_program.h"

namespace tremolo {
namespace {

class WorldCApiRecord : public WorldCApi {
 protected:
  void TearDown() override {
    tremolo_recorder_destroy(recorder_);
    WorldCApi::TearDown();
  }
  // Takes two steps and records.
  void frame(tremolo_world* world) {
    advance(world, 2);
    ASSERT_EQ(tremolo_recorder_begin_frame(recorder_, tremolo_world_time(world)), TREMOLO_OK);
    ASSERT_EQ(tremolo_recorder_record_world(recorder_, world, 1), TREMOLO_OK)
        << tremolo_last_error();
  }
  tremolo_status write(const std::string& name) {
    return tremolo_recorder_write(recorder_, path(name).c_str());
  }
  // The lines of a list that name a body.
  static int frames_of(const std::string& list, const std::string& body) {
    std::istringstream lines(testing::slurp(path(list)));
    int count = 0;
    for (std::string line; std::getline(lines, line);)
      count += line.find("," + body + ",") != std::string::npos ? 1 : 0;
    return count;
  }
  // The last frame of a point cache.
  static std::vector<float> last_frame(const std::string& name, std::size_t count) {
    const std::string bytes = testing::slurp(path(name));
    std::vector<float> places(count);
    // The number of points is behind the signature and the version. A rigid body has more than its
    // surface: both sides of sharp edges have theirs, behind the others.
    std::int32_t points = 0;
    if (bytes.size() > 20) std::memcpy(&points, bytes.data() + 16, sizeof points);
    const std::size_t frame = 3 * sizeof(float) * static_cast<std::size_t>(points);
    EXPECT_GE(frame, sizeof(float) * count);
    if (frame >= sizeof(float) * count && bytes.size() >= frame)
      std::memcpy(places.data(), bytes.data() + bytes.size() - frame, sizeof(float) * count);
    return places;
  }

  tremolo_recorder* recorder_ = nullptr;
};

const char* name_of(CubeKind kind) {
  constexpr std::array kNames = {"reduced", "rigid", "soft", "cloth"};
  return kNames[static_cast<std::size_t>(kind)];
}

// A point cache has the floats of the surface.
TEST_F(WorldCApiRecord, BodiesOfAllKindsAreWhereTheWorldSaysTheyAre) {
  tremolo_world* world = make_world(true);
  std::array<tremolo_body_id, 4> bodies{};
  for (const CubeKind kind : kKinds) {
    const auto k = static_cast<std::size_t>(kind);
    tremolo_scene_body place = at(name_of(kind), {0.3 * static_cast<double>(k), 0.0, 0.06});
    place.velocity[2] = -1.0;
    bodies[k] = add(world, kind, place);
  }
  ASSERT_EQ(tremolo_recorder_create(60.0, &recorder_), TREMOLO_OK);
  for (int k = 0; k < 10; ++k) frame(world);
  for (const char* name : {"a.pc2", "a.usda", "a.glb", "a.html", "a.pvd", "a.ply"})
    EXPECT_EQ(write(name), TREMOLO_OK) << name << tremolo_last_error();
  for (const CubeKind kind : kKinds) {
    SCOPED_TRACE(name_of(kind));
    const std::vector<double> exact = positions(world, bodies[static_cast<std::size_t>(kind)]);
    const std::vector<float> ours =
        last_frame(std::string("a-") + name_of(kind) + ".pc2", exact.size());
    for (std::size_t i = 0; i < exact.size(); ++i) EXPECT_NEAR(ours[i], exact[i], 1e-7);
    EXPECT_EQ(frames_of("a.csv", name_of(kind)), 10);
  }
  // The floor is scenery, in pictures alone.
  EXPECT_EQ(frames_of("a.csv", "collider 1"), 0);
  EXPECT_NE(testing::slurp(path("a.usda")).find("def Mesh \"collider_1\""), std::string::npos);
}

TEST_F(WorldCApiRecord, BodiesOfAllKindsComeAndGo) {
  tremolo_world* world = make_world(false);
  ASSERT_EQ(tremolo_recorder_create(60.0, &recorder_), TREMOLO_OK);
  for (int k = 0; k < 2; ++k) frame(world);
  std::array<tremolo_body_id, 4> bodies{};
  for (const CubeKind kind : kKinds) {
    const auto k = static_cast<std::size_t>(kind);
    bodies[k] = add(world, kind, at(name_of(kind), {0.3 * static_cast<double>(k), 0.0, 0.06}));
  }
  for (int k = 0; k < 3; ++k) frame(world);
  std::uint32_t floor = 9;
  floor_.position[2] = -1.0;
  ASSERT_EQ(tremolo_world_add_collider(world, &floor_, &floor), TREMOLO_OK);
  for (const CubeKind kind : kKinds)
    ASSERT_EQ(tremolo_world_remove(world, bodies[static_cast<std::size_t>(kind)]), TREMOLO_OK);
  for (int k = 0; k < 2; ++k) frame(world);
  // Others of the same names, some of them in the places of the first.
  for (const CubeKind kind : kKinds)
    add(world, kind, at(name_of(kind), {0.3 * static_cast<double>(kind), 1.0, 0.06}));
  frame(world);
  for (const char* name : {"b.usda", "b.glb", "b.html", "b.pvd", "b.ply"})
    EXPECT_EQ(write(name), TREMOLO_OK) << name << tremolo_last_error();
  EXPECT_EQ(frames_of("b.csv", "far"), 8);
  for (const CubeKind kind : kKinds) {
    SCOPED_TRACE(name_of(kind));
    EXPECT_EQ(frames_of("b.csv", name_of(kind)), 3);
    EXPECT_EQ(frames_of("b.csv", std::string(name_of(kind)) + "-2"), 1);
  }
  EXPECT_EQ(write("b.pc2"), TREMOLO_USAGE);
  EXPECT_NE(std::string(tremolo_last_error()).find("comes or goes within the motion"),
            std::string::npos);
}

TEST_F(WorldCApiRecord, WrongCallsAreRefused) {
  tremolo_world *world = make_world(false), *other = make_world(false);
  ASSERT_EQ(tremolo_recorder_create(60.0, &recorder_), TREMOLO_OK);
  EXPECT_EQ(tremolo_recorder_record_world(recorder_, world, 0), TREMOLO_USAGE) << "no frame";
  EXPECT_EQ(tremolo_recorder_record_world(nullptr, world, 0), TREMOLO_USAGE);
  EXPECT_EQ(tremolo_recorder_record_world(recorder_, nullptr, 0), TREMOLO_USAGE);
  frame(world);
  EXPECT_EQ(tremolo_recorder_record_world(recorder_, world, 0), TREMOLO_USAGE) << "twice";
  EXPECT_EQ(tremolo_recorder_record_world(recorder_, other, 0), TREMOLO_USAGE);
  EXPECT_EQ(std::string(tremolo_last_error()), "the recorder records another world");
  EXPECT_EQ(tremolo_recorder_end_track(recorder_, 7), TREMOLO_USAGE);
}

}  // namespace
}  // namespace tremolo
