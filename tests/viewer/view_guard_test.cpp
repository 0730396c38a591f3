// Outputs of the viewer replace no input and leave no pictures of a longer series, and a signal
// ends it while it writes, too.
#include <filesystem>
#include <fstream>
#include <set>

#include "runtime/apps/view/picture/picture_series.h"
#include "runtime/apps/view/picture/png_file.h"
#include "tests/support/programs.h"
#include "tests/viewer/viewer_files.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;
using testing::kView;

class ViewGuard : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
    folder_ = fresh_folder();
    std::ofstream(folder_ + "/sheet.toml")
        << "step = 0.01\n[[cloths]]\ncolumns = 4\nrows = 4\npins = [\"top\"]\n";
  }
  std::string at(const std::string& name) const { return folder_ + "/" + name; }
  ProgramResult view(const std::string& arguments) {
    return run_program(folder_, "timeout -s KILL 120 " + kView + arguments);
  }
  void expect_kept(const std::string& arguments, const std::string& file) {
    const std::string before = slurp(at(file));
    ASSERT_FALSE(before.empty());
    const ProgramResult result = view(arguments);
    EXPECT_EQ(result.code, 2) << arguments << "\n" << result.err;
    EXPECT_NE(result.err.find("would take the place of"), std::string::npos) << result.err;
    EXPECT_EQ(slurp(at(file)), before);
  }
  std::set<std::string> names() const {
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder_))
      found.insert(entry.path().filename().string());
    return found;
  }

  std::string folder_;
};

const std::string kSmall = " --offscreen --size 64x48 --lights 2 ";

TEST_F(ViewGuard, PicturesFilmsAndHandsTakeNoInputAway) {
  fs::copy(testing::sample_model("beam"), at("beam.tremolo"));
  ASSERT_TRUE(write_png(at("frame-000000.png"), {1, 1, {0, 0, 0}}));
  expect_kept("beam.tremolo --texture frame-000000.png --out ." + kSmall, "frame-000000.png");
  fs::create_symlink("sheet.toml", at("film.mp4"));
  expect_kept("sheet.toml --video film.mp4" + kSmall, "sheet.toml");
  expect_kept("sheet.toml --record-hand ./sheet.toml", "sheet.toml");
  expect_kept("beam.tremolo --record-hand beam.tremolo", "beam.tremolo");
  std::ofstream(at("beam.toml")) << "[[bodies]]\nname = \"a\"\nmodel = \"beam.tremolo\"\n";
  expect_kept("beam.toml --record-hand beam.tremolo", "beam.tremolo");
  expect_kept("beam.toml --record-hand beam.toml", "beam.toml");
  // Refused before a window is asked for.
  EXPECT_EQ(view("sheet.toml --record-hand nowhere/hand.toml").code, 1);
  EXPECT_EQ(view("sheet.toml --video nowhere/a.mp4" + kSmall).code, 1);
  EXPECT_EQ(view("beam.toml --record-hand hand.toml --out o" + kSmall).code, 2);
}

TEST_F(ViewGuard, ALongerSeriesLeavesNoPicture) {
  ASSERT_EQ(view("sheet.toml --out . --frames 4" + kSmall).code, 0);
  EXPECT_TRUE(names().contains("frame-000003.png"));
  std::ofstream(at("frame-000009.png")) << "mine";
  const ProgramResult shorter = view("sheet.toml --out . --frames 2" + kSmall);
  ASSERT_EQ(shorter.code, 0) << shorter.err;
  EXPECT_TRUE(names().contains("frame-000001.png"));
  EXPECT_FALSE(names().contains("frame-000002.png"));
  EXPECT_FALSE(names().contains("frame-000003.png"));
  EXPECT_EQ(slurp(at("frame-000009.png")), "mine");
}

TEST_F(ViewGuard, ASeriesWithoutAPictureWritesAndRemovesNothing) {
  ASSERT_TRUE(write_png(at("frame-000000.png"), {1, 1, {0, 0, 0}}));
  auto series = PictureSeries::create(folder_, "", 10.0, 64, 48);
  ASSERT_TRUE(series);
  ASSERT_TRUE(series->finish());
  EXPECT_TRUE(fs::exists(at("frame-000000.png")));
}

TEST_F(ViewGuard, TheFirstSignalEndsTheWayToTheFirstPicture) {
  fs::copy(testing::sample_model("beam"), at("beam.tremolo"));
  for (const std::string what : {"sheet.toml", "beam.tremolo"})
    for (const char* signal : {"INT", "TERM", "HUP"}) {
      const ProgramResult result =
          run_program(folder_, "(env --default-signal=INT " + kView + what + " --from 1e6 --out o" +
                                   kSmall + "& sleep 6; kill -" + signal + " $!; wait $!)");
      EXPECT_EQ(result.code, 128 + (std::string(signal) == "INT"    ? 2
                                    : std::string(signal) == "TERM" ? 15
                                                                    : 1))
          << what << signal << result.err;
      EXPECT_TRUE(!fs::exists(at("o")) || fs::is_empty(at("o"))) << what;
    }
}

TEST_F(ViewGuard, AWayOfMoreStepsThanCanBeMadeIsRefused) {
  fs::copy(testing::sample_model("beam"), at("beam.tremolo"));
  for (const std::string what : {"sheet.toml", "beam.tremolo"})
    for (const std::string flags : {"--from 1e300", "--frames 2 --rate 1e-300", "--from 1e12"})
      EXPECT_EQ(view(what + " --out o " + flags + kSmall).code, 3) << what << flags;
}

}  // namespace
}  // namespace tremolo
