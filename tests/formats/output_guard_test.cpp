// Outputs are kept apart from inputs however the paths are spelled.
#include "formats/file/output_guard.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "formats/file/atomic_file.h"
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

// Of Abaqus, in files in files; one that includes itself is no reason to go on without end.
TEST_F(OutputGuard, FilesThatAnIncludedFileIncludesAreInputsToo) {
  std::ofstream(at("a.inp")) << "*HEADING\nx\n** INPUT=none.inp\n*Include, Input=\"b.inp\"\n";
  std::ofstream(at("b.inp")) << "*INCLUDE, INPUT=c.inp\n*INCLUDE, INPUT=b.inp\n";
  std::ofstream(at("c.inp")) << "*NODE\n";
  std::ofstream(at("d.inp")) << "*NODE\n";
  const std::vector<NamedFile> inputs{{at("a.inp"), "the mesh", true}};
  EXPECT_FALSE(keep_apart({at("c.inp")}, inputs));
  EXPECT_TRUE(keep_apart({at("d.inp")}, inputs));
}

TEST_F(OutputGuard, NoOutputIsAFolderOfAnother) {
  EXPECT_FALSE(keep_apart({at("new"), at("new/run.csv")}, {}));
  EXPECT_FALSE(keep_apart({at("new/a/b/run.csv"), at("new/a")}, {}));
  EXPECT_TRUE(keep_apart({at("new/a"), at("new/ab")}, {}));
  fs::create_directory_symlink("sub", at("door"));
  EXPECT_FALSE(keep_apart({at("sub/x"), at("door/x/y")}, {}));
}

TEST_F(OutputGuard, ManyOutputsAreComparedWithEachOther) {
  std::vector<std::string> outputs;
  for (int i = 0; i < 20000; ++i)
    outputs.push_back(at("out/body-" + std::to_string(i) + "/run.csv"));
  EXPECT_TRUE(keep_apart(outputs, {{at("a"), "the mesh"}}));
  outputs.push_back(at("out/body-77/../body-78/run.csv"));
  EXPECT_FALSE(keep_apart(outputs, {}));
}

// Also under names that nobody has listed.
TEST_F(OutputGuard, AGuardedInputIsReplacedAndRemovedByNobody) {
  fs::create_symlink("a", at("link"));
  fs::create_hard_link(at("a"), at("hard"));
  {
    const GuardedInputs guard({{at("a"), "the mesh"}});
    for (const char* name : {"a", "sub/../a", "link", "hard"}) {
      const Result<AtomicFile> file = AtomicFile::create(at(name));
      ASSERT_FALSE(file) << name;
      EXPECT_EQ(file.error().kind, ErrorKind::kUsage);
      EXPECT_FALSE(remove_result(at(name))) << name;
    }
    EXPECT_TRUE(AtomicFile::create(at("b")));
    EXPECT_TRUE(remove_result(at("none")));
  }
  EXPECT_TRUE(AtomicFile::create(at("a")));
}

TEST_F(OutputGuard, WhatCannotBeWrittenIsFoundWithoutATrace) {
  EXPECT_TRUE(check_writable({at("new"), "", at("a")}));
  for (const char* name : {"sub", "none/new", "a/new"}) {
    const Status status = check_writable({at(name)});
    ASSERT_FALSE(status) << name;
    EXPECT_EQ(status.error().kind, ErrorKind::kSystem);
  }
  EXPECT_TRUE(check_writable({at("none/deep/new")}, true));
  EXPECT_FALSE(check_writable({at("a/deep/new")}, true));
  EXPECT_FALSE(check_writable({at("none/" + std::string(300, 'x') + "/new")}, true));
  EXPECT_FALSE(fs::exists(at("none")));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 3);
}

}  // namespace
}  // namespace tremolo
