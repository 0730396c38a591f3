// Pages with a motion: their numbers, read back, and text that they must not contain.
#include <cmath>
#include <cstring>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/file/base64.h"
#include "runtime/apps/tremolo/export/export.h"
#include "runtime/apps/tremolo/output/plot.h"
#include "runtime/io/page/document.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wavy_animation.h"

namespace tremolo {
namespace {

using testing::slurp;
using testing::TemporaryFolder;
using testing::wavy_animation;
using PageJson = nlohmann::json;

template <class Number>
std::vector<Number> array_of(const PageJson& array, const char* type) {
  EXPECT_EQ(array["type"], type);
  const std::string bytes = decode_base64(array["data"].get<std::string>()).bytes;
  std::vector<Number> values(bytes.size() / sizeof(Number));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

// 3s x r as the page's script makes it.
Eigen::MatrixXd shown_modes(const PageJson& shape) {
  const Eigen::Index rows = 3 * shape["vertices"].get<Eigen::Index>(), r = shape["modes"];
  if (!shape.contains("scales")) {
    const auto floats = array_of<float>(shape["fields"], "float32");
    return Eigen::Map<const Eigen::MatrixXf>(floats.data(), rows, r).cast<double>();
  }
  const auto whole = array_of<std::int16_t>(shape["fields"], "int16");
  const auto scales = shape["scales"].get<std::vector<double>>();
  Eigen::MatrixXd modes(rows, r);
  for (Eigen::Index i = 0; i < r; ++i)
    for (Eigen::Index k = 0; k < rows; ++k) modes(k, i) = scales[i] * whole[i * rows + k];
  return modes;
}

// The largest distance of X + U q of the page from the animation's, over the shape's size.
double shown_distance(const Animation& animation, const PageJson& film) {
  const PageJson& shape = film["shapes"][0];
  const Eigen::MatrixXd modes = shown_modes(shape);
  const auto rest = array_of<float>(shape["rest"], "float32");
  const auto q = array_of<float>(film["bodies"][0]["q"], "float32");
  const Eigen::VectorXd base =
      Eigen::Map<const Eigen::VectorXf>(rest.data(), modes.rows()).cast<double>();
  double worst = 0.0;
  Eigen::VectorXd exact(modes.rows());
  for (std::size_t frame = 0; frame < animation.frames(); ++frame) {
    const Eigen::VectorXd shown =
        base + modes * Eigen::Map<const Eigen::VectorXf>(
                           q.data() + frame * static_cast<std::size_t>(modes.cols()), modes.cols())
                           .cast<double>();
    local_positions(animation, animation.bodies[0], frame,
                    {exact.data(), static_cast<std::size_t>(exact.size())});
    for (Eigen::Index v = 0; v < exact.size(); v += 3)
      worst = std::max(worst, (shown - exact).segment<3>(v).norm());
  }
  return worst / largest_extent(animation.shapes[0]);
}

TEST(MotionPage, ShowsEveryFrameWithinAHundredThousandthOfTheSize) {
  // Small motions are stored as whole numbers, large ones as floats.
  for (const double amplitude : {0.005, 0.02, 0.1, 2.0}) {
    const Animation animation = wavy_animation(12, 7, 90, amplitude);
    const Result<PageMotion> motion = page_motion(animation);
    ASSERT_TRUE(motion) << motion.error().message;
    const PageJson film = PageJson::parse(motion->json);
    const double distance = shown_distance(animation, film);
    EXPECT_LE(distance, 1e-5) << amplitude;
    // It checks 64 of the 90 frames; scales are read here as decimals, there they are floats.
    EXPECT_LE(motion->position_error, 1.001 * distance) << amplitude;
    EXPECT_GE(motion->position_error, 0.5 * distance) << amplitude;
    EXPECT_EQ(film["shapes"][0].contains("scales"), amplitude < 0.03) << amplitude;
  }
}

TEST(MotionPage, HasTimesPosesAndTrianglesAsTheyAre) {
  const Animation animation = wavy_animation(5, 3, 40);
  const Result<PageMotion> motion = page_motion(animation, false);
  ASSERT_TRUE(motion) << motion.error().message;
  const PageJson film = PageJson::parse(motion->json);
  EXPECT_EQ(film["up"], "y");
  EXPECT_EQ(film["bodies"][0]["bones"], 1);
  const auto times = array_of<float>(film["times"], "float32");
  const auto poses = array_of<float>(film["bodies"][0]["poses"], "float32");
  ASSERT_EQ(poses.size(), 7 * times.size());
  for (std::size_t f = 0; f < times.size(); ++f) {
    EXPECT_FLOAT_EQ(times[f], static_cast<float>(animation.times[f]));
    const Pose& pose = animation.bodies[0].poses[f];
    for (int k = 0; k < 3; ++k)
      EXPECT_FLOAT_EQ(poses[7 * f + k], static_cast<float>(pose.position[k]));
    for (int k = 0; k < 4; ++k)
      EXPECT_NEAR(poses[7 * f + 3 + k], pose.rotation.coeffs()[k], 1e-6);  // floats of size one
  }
  const auto corners = array_of<std::uint32_t>(film["shapes"][0]["corners"], "uint32");
  const auto& triangles = animation.shapes[0].surface.triangles;
  ASSERT_EQ(corners.size(), 3 * triangles.size());
  for (std::size_t k = 0; k < corners.size(); ++k)
    EXPECT_EQ(corners[k], static_cast<std::uint32_t>(triangles[k / 3][k % 3]));
}

TEST(MotionPage, KeepsThePoseOfWhatStandsStillOnce) {
  Animation animation = wavy_animation(5, 3, 40);
  for (Pose& pose : animation.bodies[0].poses) pose = Pose{};
  const Result<PageMotion> motion = page_motion(animation);
  ASSERT_TRUE(motion) << motion.error().message;
  const PageJson film = PageJson::parse(motion->json);
  EXPECT_EQ(array_of<float>(film["bodies"][0]["poses"], "float32"),
            (std::vector<float>{0, 0, 0, 0, 0, 0, 1}));
}

TEST(MotionPage, RefusesMoreCoordinatesThanItDraws) {
  const Result<PageMotion> motion = page_motion(wavy_animation(3, 193, 2));
  ASSERT_FALSE(motion);
  EXPECT_EQ(motion.error().kind, ErrorKind::kContent);
  EXPECT_NE(motion.error().message.find("193 coordinates"), std::string::npos);
  EXPECT_TRUE(page_motion(wavy_animation(3, 192, 2)));
}

// A folder as `tremolo run --out` leaves it.
void write_run(const std::string& folder) {
  std::filesystem::create_directory(folder);
  std::ofstream(folder + "/run.csv") << "t,kinetic,potential,total,high_band\n"
                                        "0,0,0,0,0\n0.5,1,2,3,0.25\n1,2,,,0.125\n1.5,1,1,2,1\n";
  std::ofstream(folder + "/report.json")
      << R"({"integrator": "newmark", "steps": 3, "energy_drift_max": 0.00123456, "low_modes": null})";
}

PageJson report_on(const std::string& html) {
  const std::string_view open = "<script id=\"report\" type=\"application/json\">";
  const std::size_t begin = html.find(open) + open.size();
  return PageJson::parse(html.substr(begin, html.find("</script", begin) - begin));
}

TEST(MotionPage, ShowsTheRunsThatItIsGivenAndNeedsNoOtherFile) {
  const TemporaryFolder folder;
  write_run(folder.file("newmark"));
  PageExtras extras;
  extras.runs = {folder.file("newmark")};
  extras.note = "say `./demo` </script><b>";
  const std::string path = folder.file("sheet.html");
  const auto written =
      write_page_report(path, wavy_animation(6, 4, 30), extras, "how it moved", true);
  ASSERT_TRUE(written) << written.error().message;
  const std::string html = slurp(path);
  EXPECT_EQ(written->bytes, html.size());
  // Not one address, image, style sheet or script from elsewhere.
  for (const char* reference : {"http", "src=\"", "url(\"", "@import", "<link"})
    EXPECT_EQ(html.find(reference), html.npos) << reference;
  const PageJson report = report_on(html);
  EXPECT_EQ(report["title"], "sheet");
  EXPECT_EQ(report["sections"][0]["parts"][0]["kind"], "film");
  EXPECT_EQ(report["sections"][0]["parts"][1]["paragraph"], extras.note);
  const PageJson& chart = report["sections"][1]["parts"][0]["charts"]["charts"][0];
  EXPECT_EQ(chart["curves"][0]["label"], "newmark");
  EXPECT_EQ(chart["curves"][0]["y"].dump(), "[0.0,3.0,null,2.0]");
  const PageJson& rows = report["sections"][2]["parts"][0]["table"]["rows"];
  EXPECT_EQ(rows[0].dump(), R"(["method","newmark"])");
  EXPECT_EQ(rows[8].dump(), R"(["largest relative drift of the energy","0.001235"])");
  EXPECT_EQ(rows[9][1], "–");
}

TEST(EnergyPage, TellsTheLineThatIsNoRow) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& text, const std::string& words) {
    std::ofstream(folder.file("run.csv")) << text;
    const Status status = write_energy_page({{"a", folder.file("run.csv")}}, folder.file("a.html"));
    ASSERT_FALSE(status) << text;
    EXPECT_EQ(status.error().kind, ErrorKind::kContent);
    EXPECT_NE(status.error().message.find(words), std::string::npos) << status.error().message;
    EXPECT_FALSE(std::filesystem::exists(folder.file("a.html")));
  };
  refused("", "the file is empty");
  refused("t,kinetic\n0,0\n", "line 1: expected a column `total`");
  refused("t,total\n0,1\n1,much\n", "line 3: expected a number");
  refused("t,total\n0,1\n1\n", "line 3: the line is too short");
}

TEST(EnergyPage, HasAPanelForTheHighBandWhereARunKnowsIt) {
  const TemporaryFolder folder;
  write_run(folder.file("newmark"));
  std::ofstream(folder.file("mesh.csv")) << "t,total\r\n0,1\r\n1,2\r\n";
  const std::string page = folder.file("a.html");
  ASSERT_TRUE(write_energy_page({{"mesh", folder.file("mesh.csv")}}, page));
  EXPECT_EQ(report_on(slurp(page))["sections"][0]["parts"][0]["charts"]["charts"].size(), 1U);
  ASSERT_TRUE(write_energy_page(plot_sources({folder.file("newmark"), folder.file("mesh.csv")}), page));
  const PageJson charts = report_on(slurp(page))["sections"][0]["parts"][0]["charts"];
  ASSERT_EQ(charts["charts"].size(), 2U);
  EXPECT_EQ(charts["charts"][0]["curves"].size(), 2U);
  EXPECT_EQ(charts["charts"][1]["curves"][0]["y"].dump(), "[0.0,0.25,0.125,1.0]");
}

}  // namespace
}  // namespace tremolo
