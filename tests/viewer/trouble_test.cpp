// The viewer's answer to missing or wrong input: message, exit code, nothing half-done.
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "formats/basis/basis_writer.h"
#include "tests/support/tiny_basis.h"
#include "tests/viewer/viewer_files.h"

namespace tremolo {
namespace {

using testing::fresh_folder;
using testing::kView;
using testing::ProgramResult;
using testing::run_program;
using testing::sample_model;

void expect_word(const ProgramResult& result, int code, const std::string& word) {
  EXPECT_EQ(result.code, code) << result.err;
  EXPECT_NE(result.err.find(word), std::string::npos) << result.err;
}

TEST(ViewerTrouble, WithoutADisplayItNamesTheWayWithoutOne) {
  const ProgramResult result = run_program(
      fresh_folder(), "env -u DISPLAY -u WAYLAND_DISPLAY " + kView + sample_model("beam"));
  expect_word(result, 1, "there is no display");
  EXPECT_NE(result.err.find("--offscreen"), std::string::npos);
}

TEST(ViewerTrouble, WhereItIsNotBuiltTheCommandIsNamed) {
  const std::string folder = fresh_folder();
  std::filesystem::copy_file(TREMOLO_BIN_DIR "/tremolo", folder + "/tremolo");
  const ProgramResult result = run_program(folder, "./tremolo view " + sample_model("beam"));
  expect_word(result, 1, "--target tremolo-view");
  EXPECT_NE(result.err.find("TREMOLO_BUILD_VIEWER=ON"), std::string::npos) << result.err;
}

TEST(ViewerTrouble, WithoutOpenGLItNamesPackages) {
  const std::string folder = fresh_folder();
  const ProgramResult result = run_program(
      folder, "__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent LIBGL_DRIVERS_PATH=/nonexistent " +
                  kView + sample_model("beam") + " --offscreen --out out");
  expect_word(result, 1, "libegl-mesa0");
  EXPECT_FALSE(std::filesystem::exists(folder + "/out"));
}

TEST(ViewerTrouble, FilesThatAreNoneAreNamed) {
  const std::string folder = fresh_folder();
  expect_word(run_program(folder, kView + "none.tremolo --offscreen --out out"), 1, "none.tremolo");
  std::ofstream(folder + "/broken.tremolo") << "TREMOLO and then nothing";
  expect_word(run_program(folder, kView + "broken.tremolo --offscreen --out out"), 3,
              "broken.tremolo");
  std::ofstream(folder + "/broken.toml") << "[[bodies]]\nname = 3\n";
  expect_word(run_program(folder, kView + "broken.toml --offscreen --out out"), 3, "broken.toml");
  EXPECT_FALSE(std::filesystem::exists(folder + "/out"));
}

TEST(ViewerTrouble, AModelWithoutASurfaceIsRefused) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const std::string folder = fresh_folder();
  BasisData data = testing::tiny_basis();
  data.triangles.clear();
  ASSERT_TRUE(write_basis(folder + "/bare.tremolo", data));
  const ProgramResult result =
      run_program(folder, kView + "bare.tremolo --load none --offscreen --out out");
  expect_word(result, 3, "no surface");
}

TEST(ViewerTrouble, FlagsAreJudged) {
  const std::string view = kView + sample_model("beam") + " --offscreen --out out ";
  const std::vector<std::pair<std::string, int>> wrong = {
      {"--size 20", 2},           {"--size 1x1", 3},
      {"--camera 1", 2},          {"--camera 0,100", 3},
      {"--frames 0", 3},          {"--rate 0", 3},
      {"--from -1", 3},           {"--up x", 2},
      {"--background blue", 2},   {"--colour red", 2},
      {"--stress-full -1", 3},    {"--paint red", 2},
      {"--paint 'x=#ffffff'", 3}, {"--lights 1", 3},
      {"--integrator rk5", 2},    {"--step 0", 3},
      {"--deflect 5%", 2},        {"--texture no.png", 1},
      {"--no-such-flag", 2},      {"--video film.avi", 2},
      {"--seconds -1", 3}};
  for (const auto& [flag, code] : wrong) {
    const std::string folder = fresh_folder();
    const ProgramResult result = run_program(folder, view + flag);
    EXPECT_EQ(result.code, code) << flag << ": " << result.err;
    EXPECT_GT(result.err.size(), 20U) << flag;
    EXPECT_FALSE(std::filesystem::exists(folder + "/out/frame-000000.png")) << flag;
  }
  expect_word(run_program(fresh_folder(), kView + sample_model("beam") + " --offscreen"), 2,
              "--out DIR");
}

TEST(ViewerTrouble, AnOutputThatCannotBeWrittenIsNamed) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const std::string view = kView + sample_model("beam") + " --size 64x48 --lights 2 --offscreen ";
  const std::string folder = fresh_folder();
  std::ofstream(folder + "/taken") << "a file";
  expect_word(run_program(folder, view + "--out taken/pictures"), 1, "taken/pictures");
  std::filesystem::create_directories(folder + "/out/frame-000000.png");
  expect_word(run_program(folder, view + "--out out"), 1, "frame-000000.png");
  expect_word(run_program(folder, view + "--video taken/film.mp4"), 1, "taken/film.mp4");
}

TEST(ViewerTrouble, WithoutFfmpegThereIsAWordAndNoFilm) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const std::string folder = fresh_folder();
  const ProgramResult result =
      run_program(folder, "PATH=/nonexistent " + kView + sample_model("beam") +
                              " --size 64x48 --lights 2 --offscreen --video film.mp4");
  expect_word(result, 1, "ffmpeg, which is not installed");
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    EXPECT_EQ(entry.path().filename().string().find("film"), std::string::npos) << entry.path();
}

TEST(ViewerTrouble, FilmsAreReadByFfprobe) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  if (std::system("command -v ffprobe >/dev/null") != 0) GTEST_SKIP() << "there is no ffprobe";
  const std::string view =
      kView + sample_model("beam") + " --lights 2 --frames 12 --rate 24 --offscreen ";
  for (const char* film : {"film.mp4", "film.webm"}) {
    const std::string folder = fresh_folder();
    ASSERT_EQ(run_program(folder, view + "--size 64x48 --video " + film).code, 0);
    const ProgramResult probe = run_program(
        folder, std::string("ffprobe -v error -count_frames -show_entries "
                            "stream=width,height,nb_read_frames,r_frame_rate -of csv=p=0 ") +
                    film);
    EXPECT_EQ(probe.out.substr(0, probe.out.find('\n')), "64,48,24/1,12") << film;
    // And the two texts of the programs.
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder),
                            std::filesystem::directory_iterator()),
              3)
        << film;
  }
  expect_word(run_program(fresh_folder(), view + "--video film.mp4 --size 65x48"), 3, "even");
}

}  // namespace
}  // namespace tremolo
