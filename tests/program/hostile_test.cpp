// Scenes and basis files from strangers, as the program reads them.
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_writer.h"
#include "formats/file/atomic_file.h"
#include "runtime/apps/tremolo/command_line.h"
#include "runtime/apps/tremolo/run/simulate.h"
#include "runtime/model.h"
#include "tests/lab/report/report.h"
#include "tests/lab/report/table.h"
#include "tests/lab/work/failure.h"
#include "tests/lab/work/store.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_basis.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

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

TEST(Scene, TextsWithANulAreRefusedWithTheirKey) {
  const auto scene = parse_scene("[b]\nmodel = \"x.tremolo\\u0000y\"\n", "s.toml");
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().message, "s.toml: line 2: the value of 'model' holds a NUL");
}

TEST(Scene, AWholeNumberMayBeWrittenAsAFloatThatFits) {
  const auto parse = [](const std::string& value) {
    return parse_scene("[b]\nmodel = 'x.tremolo'\nprobe = " + value + "\nevery = 2.0\n", "s.toml");
  };
  EXPECT_TRUE(parse("7.0"));
  EXPECT_TRUE(parse("[7, 8.0]"));
  for (const char* value : {"7.5", "2e91", "-2e91", "inf", "nan", "[1, 1e300]", "99999999999"})
    EXPECT_FALSE(parse(value)) << value;
}

int inspect(const BasisData& data, bool json, std::string& errors, std::string& text) {
  const std::string path = testing::fresh_folder() + "/a.tremolo";
  EXPECT_TRUE(write_basis(path, data));
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  const int code = inspect_command(path, "", json);
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

TEST(Inspect, RefusesWhatNoBodyCanBeMadeOfAndNamesTheFileOnce) {
  std::vector<BasisData> bad(4, testing::tiny_basis());
  bad[0].lambda << 90000.0, 400.0;
  bad[1].surface.vertex_ids = {0, 2, 1, 3};
  bad[2].triangles[0] = {1, 1, 7};
  bad[3].vertex_count = 6;  // those inside do not ascend
  bad[3].interior.vertex_ids = {5, 4};
  bad[3].interior.rest = {{0.25, 0.25, 0.25}, {0.2, 0.2, 0.2}};
  bad[3].interior.rows = BasisRows::Constant(6, 2, 0.5);
  for (std::size_t i = 0; i < bad.size(); ++i) {
    const std::string path = testing::fresh_folder() + "/a.tremolo";
    if (!write_basis(path, bad[i])) continue;  // our own writer refuses it
    const Result<Model::Pointer> model = Model::load(path);
    ::testing::internal::CaptureStderr();
    ::testing::internal::CaptureStdout();
    const int code = inspect_command(path, "", false);
    ::testing::internal::GetCapturedStdout();
    const std::string errors = ::testing::internal::GetCapturedStderr();
    EXPECT_EQ(code, 3) << i << errors;
    EXPECT_NE(errors.find(path), std::string::npos) << errors;
    EXPECT_EQ(errors.find(path), errors.rfind(path)) << errors;
    if (model) continue;
    EXPECT_EQ("tremolo: " + model.error().message + "\n", errors);
  }
}

TEST(Inspect, ControlCharactersOfAFileDoNotReachTheTerminal) {
  BasisData data = testing::tiny_basis();
  data.provenance = "{\"generator\": \"\\u001b[2J\\u0007\"}";
  std::string errors, text;
  EXPECT_EQ(inspect(data, false, errors, text), 0) << errors;
  for (const char c : text) EXPECT_TRUE(c == '\n' || c >= ' ') << static_cast<int>(c);
}

// In a child process that may write no file of more than 16 bytes, as on a full disk: whether the
// writer gives an error that names the path.
bool fails_with_path(const std::function<Status(const std::string&)>& write,
                     const std::string& path) {
  const pid_t child = ::fork();
  if (child == 0) {
    remove_partial_files_on_signals();
    const rlimit limit{16, 16};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    const Status status = write(path);
    ::_exit(!status && status.error().kind == ErrorKind::kSystem &&
                    status.error().message.find(path) != std::string::npos
                ? 0
                : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

TEST(FullDisk, ReportsAreOldOrNewAndTheErrorNamesThePath) {
  const Table table{{"a", "b"}, {{"1", "2"}, {"3", "4"}, {"5", "6"}, {"7", "8"}}};
  Report report(".", "title", "subtitle");
  report.table(table);
  const std::map<std::string, std::function<Status(const std::string&)>> writers{
      {"a.csv", [&](const std::string& path) { return write_csv(table, path); }},
      {"a.html", [&](const std::string& path) { return write_page(report.json(), path); }},
      {"a.json", [](const std::string& path) -> Status {
         const fs::path whole(path);
         const Result<Store> store = Store::open(whole.parent_path().string());
         try {
           store->get(whole.stem().string(), {{"k", 1}}, [] { return nlohmann::json(3); });
         } catch (const Failure& failure) {
           return failure.error;
         }
         return Success{};
       }}};
  const std::string folder = testing::fresh_folder();
  for (const auto& [name, write] : writers) {
    const std::string path = folder + "/" + name;
    std::ofstream(path) << "old";
    EXPECT_TRUE(fails_with_path(write, path)) << name;
    std::ifstream stream(path);
    EXPECT_EQ((std::string{std::istreambuf_iterator<char>(stream), {}}), "old") << name;
    ASSERT_TRUE(write(path)) << name;
    EXPECT_GT(fs::file_size(path), 16u) << name;
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}),
            static_cast<std::ptrdiff_t>(writers.size()));
}

}  // namespace
}  // namespace tremolo
