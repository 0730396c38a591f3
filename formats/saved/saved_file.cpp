#include "formats/saved/saved_file.h"

#include <algorithm>
#include <array>
#include <utility>

#include "formats/sections/section_file.h"
#include "formats/sections/section_writer.h"

namespace tremolo {
namespace {

using namespace section_layout;

constexpr FileKind kSavedKind = {{'T', 'R', 'E', 'M', 'S', 'A', 'V', 'E'}, 1, "a saved state"};
constexpr std::string_view kAbout = "about";
constexpr std::string_view kHashes = "hashes";
constexpr std::string_view kState = "state";

std::array<SectionShape, 3> saved_shapes(std::uint64_t parts) {
  return {{{kAbout, ElementType::kU8, kAnyRows, 1, true},
           {kHashes, ElementType::kU64, parts, 1, true},
           {kState, ElementType::kU8, kAnyRows, 1, true}}};
}

template <class Use>
auto with_saved_sections(const SavedState& saved, const Use& use) {
  std::string about = saved.kind + "\n" + saved.version + "\n";
  std::vector<std::uint64_t> hashes;
  for (const SavedPart& part : saved.parts) {
    about += part.name + "\n";
    hashes.push_back(part.hash);
  }
  auto [text, numbers, state] = saved_shapes(hashes.size());
  text.rows = about.size();
  state.rows = saved.state.size();
  return use(SectionList{
      kSavedKind,
      0,
      {{text, bytes_of(about)}, {numbers, bytes_of(hashes)}, {state, bytes_of(saved.state)}}});
}

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

Result<SavedState> read_sections(Result<SectionFile> file) {
  if (!file) return file.error();
  if (Status s = file->check_shapes(saved_shapes(kAnyRows)); !s) return s.error();
  const auto text = file->text(kAbout);
  if (!text) return text.error();
  const auto hashes = file->elements<std::uint64_t>(kHashes);
  if (!hashes) return hashes.error();
  const auto state = file->text(kState);
  if (!state) return state.error();
  std::vector<std::string> lines = lines_of(*text);
  if (lines.size() != hashes->size() + 2)
    return file->error_at(kAbout, file->find(kAbout)->offset,
                          "expected " + std::to_string(hashes->size() + 2) + " lines, found " +
                              std::to_string(lines.size()));
  SavedState saved{std::move(lines[0]), std::move(lines[1]), {}, std::string(*state)};
  for (std::size_t k = 0; k < hashes->size(); ++k)
    saved.parts.push_back({std::move(lines[k + 2]), (*hashes)[k]});
  return saved;
}

const SavedPart* find_part(const SavedState& saved, const std::string& name) {
  const auto found = std::find_if(saved.parts.begin(), saved.parts.end(),
                                  [&name](const SavedPart& part) { return part.name == name; });
  return found == saved.parts.end() ? nullptr : &*found;
}

}  // namespace

std::vector<std::byte> encode_saved(const SavedState& saved) {
  // Without streams it cannot fail.
  return *with_saved_sections(saved, [](const SectionList& list) { return encode_sections(list); });
}

Status write_saved(const std::string& path, const SavedState& saved) {
  return with_saved_sections(
      saved, [&path](const SectionList& list) { return write_sections(path, list); });
}

Result<SavedState> read_saved(const std::string& path) {
  return read_sections(SectionFile::open(path, kSavedKind));
}

Result<SavedState> read_saved(std::span<const std::byte> bytes, const std::string& name) {
  return read_sections(SectionFile::from_memory(bytes, name, kSavedKind));
}

Status check_belongs(const SavedState& saved, const SavedState& here) {
  if (saved.kind != here.kind)
    return content_error("it is the state of " + saved.kind + ", not of " + here.kind);
  if (saved.version != here.version)
    return content_error("it was saved by version " + saved.version + ", this is " + here.version +
                         ": only the version that saved a state puts it back");
  for (const SavedPart& part : here.parts) {
    const SavedPart* other = find_part(saved, part.name);
    if (other == nullptr)
      return content_error("it was saved without " + part.name + ", which is here");
    if (other->hash != part.hash)
      return content_error("it belongs to " + here.kind + " with another " + part.name);
  }
  for (const SavedPart& part : saved.parts)
    if (find_part(here, part.name) == nullptr)
      return content_error("it was saved with " + part.name + ", which is not here");
  const auto same_name = [](const SavedPart& a, const SavedPart& b) { return a.name == b.name; };
  if (!std::equal(saved.parts.begin(), saved.parts.end(), here.parts.begin(), here.parts.end(),
                  same_name))
    return content_error("its parts stand in another order");
  return Success{};
}

}  // namespace tremolo
