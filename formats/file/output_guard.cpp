#include "formats/file/output_guard.h"

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "formats/file/mapped_file.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

// Absolute, links resolved as far as there is something. Empty if that fails.
fs::path place_of(const fs::path& path) {
  std::error_code error;
  const fs::path absolute = fs::absolute(path, error);
  const fs::path place = error ? fs::path() : fs::weakly_canonical(absolute, error);
  return error ? fs::path() : place;
}

bool lies_in(const fs::path& file, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first ==
         folder.end();
}

// Formats that name files do it by their names as they stand on the disk.
bool holds_text(const std::string& path, std::string_view text) {
  const Result<MappedFile> file = MappedFile::open(path);
  if (!file) return false;  // who reads it will say so
  const auto bytes = file->bytes();
  return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()).find(text) !=
         std::string_view::npos;
}

// Whether an output that is there already belongs to the input.
bool is_named_by(const std::string& output, const NamedFile& input) {
  const fs::path file = place_of(output), owner = place_of(input.path);
  std::error_code none;
  if (!input.names_others || owner.empty() || !fs::exists(file, none)) return false;
  if (!lies_in(file, owner.parent_path())) return false;
  const std::string extension = owner.extension().string();
  if ((extension == ".node" || extension == ".ele") && file.stem() == owner.stem() &&
      (file.extension() == ".node" || file.extension() == ".ele"))
    return true;
  return holds_text(input.path, file.filename().string());
}

Error taken(const std::string& output, const std::string& whose) {
  return {ErrorKind::kUsage, output + ": the output would take the place of " + whose};
}

}  // namespace

bool same_file(const std::string& a, const std::string& b) {
  std::error_code error;
  if (fs::equivalent(a, b, error) && !error) return true;
  const fs::path first = place_of(a), second = place_of(b);
  return !first.empty() && first == second;
}

Status keep_apart(const std::vector<std::string>& outputs, const std::vector<NamedFile>& inputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const std::string& output = outputs[i];
    if (output.empty()) continue;
    for (const NamedFile& input : inputs) {
      if (input.path.empty()) continue;
      const std::string whose = input.path + " (" + input.role + ")";
      if (same_file(output, input.path)) return taken(output, whose);
      if (is_named_by(output, input)) return taken(output, "a file that belongs to " + whose);
    }
    for (std::size_t other = 0; other < i; ++other)
      if (!outputs[other].empty() && same_file(output, outputs[other]))
        return Error{ErrorKind::kUsage,
                     output + ": two outputs of this name, the other is " + outputs[other]};
  }
  return Success{};
}

}  // namespace tremolo
