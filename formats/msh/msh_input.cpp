#include "formats/msh/msh_input.h"

#include <algorithm>
#include <limits>

namespace tremolo {
namespace {

constexpr std::size_t kTextBytes = 2;  // a number in a text takes a digit and a separator

}  // namespace

MshInput::MshInput(std::string_view text, const std::string& path)
    : whole_(text), path_(path), text_(text, path), bytes_(text, path, 0, false) {}

Result<MshInput> MshInput::open(std::string_view text, const std::string& path) {
  MshInput input(text, path);
  const Status status = input.read_format();
  if (!status) return status.error();
  return input;
}

Status MshInput::read_format() {
  int type = 0;
  int data_size = 0;
  if (!text_.expect("$MeshFormat") || !text_.read_word(version_, "a version number"))
    return text_.error();
  if (version_ != "4.1" && version_ != "2" && !version_.starts_with("2."))
    return text_.problem("expected an MSH file of version 2.2 or 4.1, found version " +
                         quoted_text(version_));
  if (!text_.read(type, "a file type (0: text, 1: binary)")) return text_.error();
  if (type != 0 && type != 1)
    return text_.problem("expected file type 0 (text) or 1 (binary), found " +
                         std::to_string(type));
  if (!text_.read(data_size, "a data size")) return text_.error();
  if (data_size != 8)
    return text_.problem("expected data size 8, found " + std::to_string(data_size));
  binary_ = type == 1;
  if (binary_) {
    if (!begin_data()) return error();
    std::int32_t one = 0;
    if (!bytes_.read(one, "the number 1, which shows the byte order")) return error();
    swap_ = one == swapped_bytes(std::int32_t{1});
    if (one != 1 && !swap_)
      return bytes_.problem("expected the number 1 in either byte order, found " +
                            std::to_string(one));
    end_data();
  }
  if (!end_section("MeshFormat")) return error();
  return Success{};
}

std::string MshInput::format() const {
  return "MSH " + version_ + (binary_ ? " binary" : " text");
}

bool MshInput::next_section(std::string_view& name) {
  const std::string_view found = text_.token();
  name = {};
  if (found.empty()) return true;
  if (found.front() != '$' || found.size() == 1)
    return text_.fail("a section such as $Nodes", found);
  name = found.substr(1);
  return true;
}

bool MshInput::skip_section(std::string_view name) {
  const std::string end = "\n$End" + std::string(name);
  const std::size_t found = whole_.find(end, text_.offset());
  if (found == std::string_view::npos) {
    text_.seek(whole_.size());
    return text_.fail("`$End" + std::string(name) + "`", "");
  }
  text_.seek(found + end.size());
  return true;
}

bool MshInput::end_section(std::string_view name) {
  return text_.expect("$End" + std::string(name));
}

bool MshInput::begin_data() {
  if (!binary_) return true;
  if (!text_.at_line_end()) return text_.fail("the end of the line", text_.token());
  text_.rest_of_line();
  bytes_ = ByteScanner(whole_, path_, text_.offset(), swap_);
  in_bytes_ = true;
  return true;
}

void MshInput::end_data() {
  if (!in_bytes_) return;
  in_bytes_ = false;
  // After binary data errors give byte offsets instead of lines.
  text_ = TextScanner(whole_, path_, {.binary_file = true});
  text_.seek(bytes_.offset());
}

bool MshInput::integer(std::int64_t& value, std::string_view what) {
  if (!in_bytes_) return text_.read(value, what);
  std::int32_t stored = 0;
  if (!bytes_.read(stored, what)) return false;
  value = stored;
  return true;
}

bool MshInput::size(std::uint64_t& value, std::string_view what) {
  return in_bytes_ ? bytes_.read(value, what) : text_.read(value, what);
}

bool MshInput::real(double& value, std::string_view what) {
  return in_bytes_ ? bytes_.read(value, what) : text_.read(value, what);
}

bool MshInput::fits(std::uint64_t count, MshItem item, std::string_view what) {
  if (in_bytes_) return bytes_.fits(count, 4 * item.integers + 8 * (item.sizes + item.reals), what);
  return text_.fits(count, kTextBytes * (item.integers + item.sizes + item.reals), what);
}

Error MshInput::problem(const std::string& complaint) const {
  return in_bytes_ ? bytes_.problem(complaint) : text_.problem(complaint);
}

namespace {

constexpr const char* kDimensionNames[] = {"point", "curve", "surface", "volume"};

// The magnitude of a tag; the one value without a positive counterpart stays apart.
std::int64_t magnitude(std::int64_t tag) {
  if (tag == std::numeric_limits<std::int64_t>::min()) return tag;
  return tag < 0 ? -tag : tag;
}

}  // namespace

int msh_dimension(std::int64_t type) {
  constexpr int kPoints[] = {15};
  constexpr int kLines[] = {1, 8, 26, 27, 28};
  constexpr int kSurfaces[] = {2, 3, 9, 10, 16, 20, 21, 22, 23, 24, 25};
  const auto is_one_of = [type](std::span<const int> types) {
    return std::find(types.begin(), types.end(), type) != types.end();
  };
  return is_one_of(kPoints) ? 0 : is_one_of(kLines) ? 1 : is_one_of(kSurfaces) ? 2 : 3;
}

bool MshGroups::read_names(MshInput& input) {
  TextScanner& text = input.text();
  std::uint64_t count = 0;
  if (!text.read(count, "the number of physical names") || !text.fits(count, 6, "physical names"))
    return false;
  for (std::uint64_t n = 0; n < count; ++n) {
    int dimension = 0;
    std::int64_t tag = 0;
    std::string name;
    if (!text.read(dimension, "the dimension of a physical group") ||
        !text.read(tag, "the tag of a physical group") ||
        !text.read_quoted(name, "the name of a physical group"))
      return false;
    if (dimension < 0 || dimension > 3)
      return text.fail("a dimension from 0 to 3", std::to_string(dimension));
    if (name.empty()) continue;
    names_[{dimension, magnitude(tag)}] = name;
    given_.insert(name);
  }
  return input.end_section("PhysicalNames");
}

void MshGroups::add(int dimension, std::int64_t tag, std::span<const VertexId> vertices) {
  if (tag == 0) return;
  std::vector<VertexId>& members = members_[{dimension, magnitude(tag)}];
  members.insert(members.end(), vertices.begin(), vertices.end());
}

std::string MshGroups::name(int dimension, std::int64_t tag) const {
  const auto found = names_.find({dimension, magnitude(tag)});
  if (found != names_.end()) return found->second;
  std::string text = std::string(kDimensionNames[dimension]) + " " + std::to_string(magnitude(tag));
  while (given_.contains(text)) text += " (unnamed)";
  return text;
}

void MshGroups::give_to(MeshBuilder& builder, std::span<const std::int64_t> volume_of_tet) {
  for (auto& [key, members] : members_) {
    builder.add_to_set(name(key.first, key.second), members);
    std::vector<VertexId>().swap(members);
  }
  builder.set_regions(volume_of_tet,
                      [this](std::int64_t tag) { return tag == 0 ? std::string() : name(3, tag); });
}

}  // namespace tremolo
