// make_surfaces FOLDER: writes the corpus of awkward surfaces and its manifest.tsv: a line a file,
// its name, what is the matter with it and what is expected, with tabs between.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "tests/corpus/corpus.h"

namespace {

bool write(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream stream(path, std::ios::binary);
  stream << bytes;
  stream.close();
  return stream.good();
}

}  // namespace

int main(int count, char** words) {
  using namespace tremolo::corpus;
  if (count != 2) {
    std::fprintf(stderr, "usage: make_surfaces FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = words[1];
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  std::string manifest;
  std::set<std::string> names;
  for (std::vector<Entry> (*list)() : {&good_surfaces, &several_bodies, &spoilt_surfaces,
                                       &crossing_surfaces, &thin_surfaces, &odd_files}) {
    for (const Entry& entry : (*list)()) {
      if (!names.insert(entry.name).second || !write(folder / entry.name, entry.bytes)) {
        std::fprintf(stderr, "make_surfaces: cannot write %s\n", entry.name.c_str());
        return 1;
      }
      manifest += entry.name + "\t" + entry.what + "\t" + entry.expected + "\n";
    }
  }
  if (!write(folder / "manifest.tsv", manifest)) {
    std::fprintf(stderr, "make_surfaces: cannot write the manifest\n");
    return 1;
  }
  std::printf("%zu surfaces\n", names.size());
  return 0;
}
