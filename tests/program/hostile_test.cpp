// Scenes and basis files from strangers, as the program reads them.
#include <gtest/gtest.h>

#include "formats/basis_writer.h"
#include "runtime/program/commands.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_basis.h"

namespace tremolo {
namespace {

std::string repeated(const std::string& piece, std::size_t times) {
  std::string text;
  for (std::size_t n = 0; n < times; ++n) text += piece;
  return text;
}

// Deep enough to exhaust a stack of 8 MB if anything recurses.
constexpr std::size_t kDeep = 300'000;

TEST(Scene, TablesInTablesAreRefusedHoweverDeep) {
  const std::string keys = repeated("a.", kDeep);
  for (const std::string& text : {"[b]\n" + keys + "a = 1\n", "[" + keys + "a]\nmodel = 'x'\n",
                                  "[b]\nmodel = " + repeated("{a=", kDeep) + "1\n",
                                  "[b]\nmodel = " + repeated("[", kDeep) + "1\n",
                                  repeated("[[" + repeated("a.", 60) + "a]]\n", 2000)}) {
    const Result<std::vector<RunOptions>> scene = parse_scene(text, "scene.toml");
    ASSERT_FALSE(scene);
    EXPECT_EQ(scene.error().kind, ErrorKind::kContent);
    EXPECT_TRUE(scene.error().message.starts_with("scene.toml: line ")) << scene.error().message;
  }
}

TEST(Scene, PathsMayHaveManyDots) {
  const auto scene = parse_scene("[b]\nmodel = '" + repeated("../", 20) + "x.tremolo'\n", "s.toml");
  ASSERT_TRUE(scene) << scene.error().message;
}

int inspect(const BasisData& data, bool json, std::string& errors, std::string& text) {
  const std::string path = testing::fresh_folder() + "/a.tremolo";
  EXPECT_TRUE(write_basis(path, data));
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  const int code = inspect_command(path, json);
  text = ::testing::internal::GetCapturedStdout();
  errors = ::testing::internal::GetCapturedStderr();
  return code;
}

TEST(Inspect, AProvenanceThatIsNestedTooDeepIsAnError) {
  BasisData data = testing::tiny_basis();
  std::string errors, text;
  for (const bool json : {false, true}) {
    data.provenance = repeated("[", kDeep) + repeated("]", kDeep);
    EXPECT_EQ(inspect(data, json, errors, text), 3);
    EXPECT_NE(errors.find("nested too deep"), std::string::npos) << errors;
    data.provenance = "{\"a\": " + repeated("[", 50) + repeated("]", 50) + "}";
    EXPECT_EQ(inspect(data, json, errors, text), 0) << errors;
  }
}

TEST(Inspect, ControlCharactersOfAFileDoNotReachTheTerminal) {
  BasisData data = testing::tiny_basis();
  data.provenance = "{\"generator\": \"\\u001b[2J\\u0007\"}";
  std::string errors, text;
  EXPECT_EQ(inspect(data, false, errors, text), 0) << errors;
  for (const char c : text) EXPECT_TRUE(c == '\n' || c >= ' ') << static_cast<int>(c);
}

}  // namespace
}  // namespace tremolo
