// Saved states: the state of a body or a world between steps, and the identity of that body or
// world.
//
// A file of sections (formats/sections/section_layout.h) of the kind "TREMSAVE", version 1.0:
// `about`, u8, lines of text: the kind and the version that saved it, then a line per part;
// `hashes`, u64, one per part; `state`, u8, the bytes of common/state_stream.h. A state can be
// restored only by the version that saved it, and only if every part is the same.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"

namespace tremolo {

// A part of the model or scene that a state belongs to (a body's model, a scene's colliders ...),
// with a unique name of one line and a hash of its contents.
struct SavedPart {
  std::string name;
  std::uint64_t hash = 0;
};

// kind: "a body" or "a world". version: of the library that saved it.
struct SavedState {
  std::string kind;
  std::string version;
  std::vector<SavedPart> parts;
  std::string state;
};

// The bytes of the file; the same state gives the same bytes.
std::vector<std::byte> encode_saved(const SavedState& saved);

// The same, written under a temporary name and renamed to `path`. Errors: kSystem.
Status write_saved(const std::string& path, const SavedState& saved);

// Reads an untrusted file. Errors give the file and the section: kContent for a file that is cut
// off, damaged or of another kind, kSystem for one that cannot be read.
Result<SavedState> read_saved(const std::string& path);
// `name` is for errors.
Result<SavedState> read_saved(std::span<const std::byte> bytes, const std::string& name);

// Checks that the state was saved by this version and belongs to `here`, whose `state` is ignored;
// kContent with the difference.
Status check_belongs(const SavedState& saved, const SavedState& here);

}  // namespace tremolo
