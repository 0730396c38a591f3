// The list of awkward surfaces.
#pragma once

#include <string>
#include <vector>

namespace tremolo::corpus {

// expected: "mesh", "message", or "either" where both are right if the user gets a message.
struct Entry {
  std::string name;  // of the file, with extension
  std::string what;  // is the matter with it
  std::string expected;
  std::string bytes;
};

std::vector<Entry> good_surfaces();      // closed, nothing to repair
std::vector<Entry> several_bodies();     // that are in contact, overlap, lie in each other
std::vector<Entry> spoilt_surfaces();    // holes, turned, repeated, degenerate and split triangles
std::vector<Entry> crossing_surfaces();  // that cross themselves, are one-sided or non-manifold
std::vector<Entry> thin_surfaces();      // plates, sheets, needles
std::vector<Entry> odd_files();          // sizes, positions, numbers and files without a surface

}  // namespace tremolo::corpus
