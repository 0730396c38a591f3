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

bool is_c_header(const fs::path& path) {
  for (const char* name : {"tremolo.h", "tremolo_cloth.h", "tremolo_tets.h", "tremolo_scene.h"})
    if (path == fs::path("runtime") / name) return true;
  return false;
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
      // C headers find the others next to them, where all are installed.
      if (is_c_header(source.path) && is_c_header("runtime/" + include)) continue;
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
         is_below(path, "runtime/apps/view") || is_below(path, "runtime/apps/python") ||
         is_below(path, "runtime/c/scenes");
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
            "fmt", "pugixml", "epoxy", "GLFW", "imgui", "png", "pybind11", "Python"})
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

// The folder of a file; a public header of runtime/ belongs to the room that defines its functions.
std::string folder_of(const fs::path& file) {
  static const std::map<std::string, std::string> rooms = {
      {"parts.h", "runtime/math"},
      {"energy_bound.h", "runtime/math"},
      {"contact_body.h", "runtime/contact/islands"},
      {"world.h", "runtime/bodies/lanes"},
      {"tremolo.h", "runtime/c"},
      {"tremolo_cloth.h", "runtime/c"},
      {"tremolo_tets.h", "runtime/c"},
      {"tremolo_scene.h", "runtime/c"}};
  std::string folder = file.parent_path().generic_string();
  if (folder != "runtime") return folder;
  const auto found = rooms.find(file.filename().string());
  return found == rooms.end() ? "runtime/bodies/reduced" : found->second;
}

// Of the runtime, from the one that knows nothing to the programs, which know all.
const std::vector<std::string>& runtime_rooms() {
  static const std::vector<std::string> rooms = {"runtime/math",
                                                 "runtime/step",
                                                 "runtime/contact",
                                                 "runtime/bodies/reduced",
                                                 "runtime/response",
                                                 "runtime/bodies/lanes",
                                                 "runtime/bodies/cloth",
                                                 "runtime/bodies/tets",
                                                 "runtime/contact/solve",
                                                 "runtime/contact/islands",
                                                 "runtime/mixed",
                                                 "runtime/scene",
                                                 "runtime/world",
                                                 "runtime/io/exchange",
                                                 "runtime/io/page",
                                                 "runtime/io/scenes",
                                                 "runtime/c",
                                                 "runtime/apps"};
  return rooms;
}

// The index of the room whose name is the longest that the folder begins with.
std::size_t room_of(const std::string& folder) {
  std::size_t room = runtime_rooms().size(), longest = 0;
  for (std::size_t i = 0; i < runtime_rooms().size(); ++i) {
    const std::string& name = runtime_rooms()[i];
    if (!(folder + "/").starts_with(name + "/") || name.size() < longest) continue;
    room = i;
    longest = name.size();
  }
  return room;
}

// Bodies know no contact with other bodies, no world and no C; only programs know each other's
// kinds.
TEST(Rooms, OfTheRuntimeIncludeDownwards) {
  std::size_t includes = 0;
  for (const Source& source : sources()) {
    if (!is_below(source.path, "runtime")) continue;
    const std::size_t own = room_of(folder_of(source.path));
    ASSERT_LT(own, runtime_rooms().size()) << source.path << " is in no room";
    for (const std::string& include : source.ours) {
      if (!is_below(include, "runtime")) continue;
      const std::size_t other = room_of(folder_of(include));
      // Cloth and tetrahedra still bring scenes and worlds of their own.
      const bool own_world = runtime_rooms()[other] == "runtime/scene" &&
                             (runtime_rooms()[own] == "runtime/bodies/cloth" ||
                              runtime_rooms()[own] == "runtime/bodies/tets");
      EXPECT_TRUE(other <= own || own_world) << source.path << " includes " << include;
      ++includes;
    }
  }
  EXPECT_GT(includes, 500U);
}

TEST(Rooms, FoldersDoNotIncludeEachOtherInACircle) {
  Arrows arrows;
  for (const Source& source : sources())
    for (const std::string& include : source.ours) {
      const std::string from = folder_of(source.path);
      const std::string to = folder_of(include);
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
