// The rooms' order, read from the includes (docs/architecture.md, "Rooms").
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace tremolo {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = TREMOLO_SOURCE_DIR;

// A source file of the project, its path from the top of the tree, and its includes, both
// "room/header.h" and <header>.
struct Source {
  fs::path path;
  std::vector<std::string> ours;
  std::vector<std::string> foreign;
};

Source read_source(const fs::path& file) {
  Source source{fs::relative(file, kRoot), {}, {}};
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    constexpr std::string_view kInclude = "#include ";
    if (!line.starts_with(kInclude)) continue;
    const std::size_t begin = kInclude.size() + 1;
    const std::size_t end = line.find_first_of("\">", begin);
    if (end == std::string::npos) continue;
    (line[begin - 1] == '"' ? source.ours : source.foreign)
        .push_back(line.substr(begin, end - begin));
  }
  return source;
}

// All sources of the four rooms and the laboratory.
const std::vector<Source>& sources() {
  static const std::vector<Source> all = [] {
    std::vector<Source> found;
    for (const char* room : {"common", "formats", "precompute", "runtime", "tests/lab"})
      for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kRoot / room))
        if (const fs::path ending = entry.path().extension();
            ending == ".h" || ending == ".cpp" || ending == ".inc")
          found.push_back(read_source(entry.path()));
    return found;
  }();
  return all;
}

bool is_below(const fs::path& path, const std::string& folder) {
  return path.generic_string().starts_with(folder + "/");
}

TEST(Rooms, AreThere) {
  EXPECT_GT(sources().size(), 400U);
}

TEST(Rooms, IncludesGoOneWay) {
  const std::map<std::string, std::vector<std::string>> known = {
      {"common", {"common"}},
      {"formats", {"common", "formats"}},
      {"precompute", {"common", "formats", "precompute", "assets"}},
      {"runtime", {"common", "formats", "runtime"}},
      {"tests", {"common", "formats", "runtime", "tests"}}};
  for (const Source& source : sources())
    for (const std::string& include : source.ours) {
      // C headers find the first one next to them, where all are installed.
      const bool of_c =
          source.path == "runtime/tremolo_cloth.h" || source.path == "runtime/tremolo_tets.h";
      if (of_c && include == "tremolo.h") continue;
      const std::string room = source.path.begin()->string();
      const std::string other = fs::path(include).begin()->string();
      const std::vector<std::string>& allowed = known.at(room);
      EXPECT_NE(std::find(allowed.begin(), allowed.end(), other), allowed.end())
          << source.path << " includes " << include;
    }
}

// Targets that are built on the engine's public interface.
bool is_beside_the_engine(const fs::path& path) {
  return is_below(path, "runtime/apps/tremolo") || is_below(path, "runtime/io/scenes") ||
         is_below(path, "runtime/apps/view");
}

TEST(Rooms, TheLibraryKnowsNothingOfItsPrograms) {
  for (const Source& source : sources()) {
    if (!is_below(source.path, "runtime") || is_beside_the_engine(source.path)) continue;
    for (const std::string& include : source.ours)
      EXPECT_FALSE(is_beside_the_engine(include)) << source.path << " includes " << include;
  }
}

TEST(Rooms, TheReaderOfScenesKnowsNothingOfThePrograms) {
  for (const Source& source : sources()) {
    if (!is_below(source.path, "runtime/io/scenes")) continue;
    for (const std::string& include : source.ours)
      EXPECT_FALSE(is_below(include, "runtime/apps/tremolo") ||
                   is_below(include, "runtime/apps/view"))
          << source.path << " includes " << include;
  }
}

// The viewer shows what `tremolo run` runs; that one needs no display.
TEST(Rooms, TheProgramKnowsNothingOfTheViewer) {
  for (const Source& source : sources()) {
    if (!is_below(source.path, "runtime/apps/tremolo") && !is_below(source.path, "tests/lab"))
      continue;
    for (const std::string& include : source.ours)
      EXPECT_FALSE(is_below(include, "runtime/apps/view"))
          << source.path << " includes " << include;
  }
}

// A build of the engine needs Eigen and xxhash and nothing else.
TEST(Rooms, TheEngineKnowsNoLibraryOfThePrograms) {
  for (const Source& source : sources()) {
    const bool of_engine = is_below(source.path, "common") || is_below(source.path, "runtime");
    if (!of_engine || is_beside_the_engine(source.path)) continue;
    for (const std::string& include : source.foreign)
      for (const char* library :
           {"petsc", "slepc", "mpi", "metis", "assimp", "CGAL", "boost", "CLI", "nlohmann", "toml",
            "fmt", "pugixml", "epoxy", "GLFW", "imgui", "png"})
        EXPECT_FALSE(include.starts_with(library))
            << source.path << " includes <" << include << ">";
  }
}

// folder -> folders that its files include.
using Arrows = std::map<std::string, std::set<std::string>>;

// A path along the arrows from `at` back to `goal`; empty: there is none.
std::vector<std::string> way_back(const Arrows& arrows, const std::string& at,
                                  const std::string& goal, std::set<std::string>& seen) {
  const auto found = arrows.find(at);
  if (found == arrows.end()) return {};
  for (const std::string& next : found->second) {
    if (next == goal) return {at, goal};
    if (!seen.insert(next).second) continue;
    std::vector<std::string> rest = way_back(arrows, next, goal, seen);
    if (rest.empty()) continue;
    rest.insert(rest.begin(), at);
    return rest;
  }
  return {};
}

TEST(Rooms, FoldersDoNotIncludeEachOtherInACircle) {
  Arrows arrows;
  for (const Source& source : sources())
    for (const std::string& include : source.ours) {
      const std::string from = source.path.parent_path().generic_string();
      const std::string to = fs::path(include).parent_path().generic_string();
      if (from != to) arrows[from].insert(to);
    }
  for (const auto& [folder, others] : arrows) {
    std::set<std::string> seen;
    const std::vector<std::string> circle = way_back(arrows, folder, folder, seen);
    std::string text;
    for (const std::string& step : circle) text += step + " -> ";
    EXPECT_TRUE(circle.empty()) << text;
  }
}

TEST(Rooms, NoFolderHoldsMoreThanCanBeSurveyed) {
  constexpr int kMost = 30;
  std::map<std::string, int> files;
  for (const Source& source : sources()) ++files[source.path.parent_path().generic_string()];
  for (const auto& [folder, count] : files) EXPECT_LE(count, kMost) << folder;
}

}  // namespace
}  // namespace tremolo
