// Outputs are kept apart from inputs however the paths are spelled.
#include "formats/file/output_guard.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

class OutputGuard : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::fresh_folder();
    fs::create_directory(folder_ + "/sub");
    std::ofstream(folder_ + "/a") << "a";
    std::ofstream(folder_ + "/b") << "a";
  }
  std::string at(const std::string& name) const { return folder_ + "/" + name; }

  std::string folder_;
};

TEST_F(OutputGuard, OneFileIsKnownByAnyOfItsPaths) {
  fs::create_symlink("a", at("link"));
  fs::create_hard_link(at("a"), at("hard"));
  fs::create_directory_symlink("sub", at("door"));
  std::ofstream(at("sub/c")) << "c";
  for (const char* name : {"a", "./a", "sub/../a", "link", "hard", "sub//../a"})
    EXPECT_TRUE(same_file(at("a"), at(name))) << name;
  EXPECT_TRUE(same_file(at("door/c"), at("sub/c")));
  EXPECT_FALSE(same_file(at("a"), at("b")));
}

TEST_F(OutputGuard, PlacesWithoutAFileAreToldApartToo) {
  fs::create_directory_symlink("sub", at("door"));
  EXPECT_TRUE(same_file(at("new"), at("sub/../new")));
  EXPECT_TRUE(same_file(at("door/new"), at("sub/new")));
  EXPECT_TRUE(same_file(at("none/new"), at("none/./new")));
  EXPECT_FALSE(same_file(at("new"), at("sub/new")));
  EXPECT_FALSE(same_file(at("a"), at("new")));
}

TEST_F(OutputGuard, FilesThatAnInputNamesAreInputsToo) {
  std::ofstream(at("mesh.obj")) << "mtllib b\n";
  const std::vector<NamedFile> inputs{{at("mesh.obj"), "the mesh", true}};
  EXPECT_FALSE(keep_apart({at("b")}, inputs));
  EXPECT_TRUE(keep_apart({at("a")}, inputs));
  EXPECT_TRUE(keep_apart({at("b")}, {{at("mesh.obj"), "the mesh"}}));
  // A file of that name in another folder is another file.
  std::ofstream(at("sub/mesh.obj")) << "mtllib b\n";
  EXPECT_TRUE(keep_apart({at("b")}, {{at("sub/mesh.obj"), "the mesh", true}}));
  std::ofstream(at("part.node")) << "0 3 0 0\n";
  std::ofstream(at("part.ele")) << "0 4 0\n";
  EXPECT_FALSE(keep_apart({at("part.ele")}, {{at("part.node"), "the mesh", true}}));
}

}  // namespace
}  // namespace tremolo
