// Common parts of all fuzz targets. A target is one file NAME_fuzz.cpp that defines read_input();
// harness.cpp calls it and checks the memory that it used.
#pragma once

#include <string_view>

#include "common/result.h"
#include "formats/mesh/mesh_reader.h"

namespace tremolo::fuzz {

// Gives the bytes to the reader. The harness ends the process, which libFuzzer reports as a
// finding, if the reader used more than kFixedBytes + kBytesAByte * bytes.size() at any time.
void read_input(std::string_view bytes);

// A reader's own tables and error texts.
inline constexpr std::size_t kFixedBytes = 256 << 10;
// An element of an MSH file, ten bytes of text, becomes a tetrahedron, its position in sorted lists
// and a member of up to 64 sets, in vectors that are up to twice as large as what they hold.
inline constexpr std::size_t kBytesAByte = 400;

// Ends the process with this text.
[[noreturn]] void finding(const char* what);

// An error says what is wrong.
template <class T>
void check_error(const Result<T>& result) {
  if (!result && result.error().message.empty()) finding("an error without a message");
}

// Checks the promises of a mesh reader for a mesh that it returns; then calls check_mesh() on it.
void check_mesh_file(Result<MeshFile> file);

}  // namespace tremolo::fuzz
