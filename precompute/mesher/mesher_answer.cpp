#include "precompute/mesher/mesher_answer.h"

#include <algorithm>
#include <cstring>
#include <string_view>

#include <nlohmann/json.hpp>

namespace tremolo {
namespace {

static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
static_assert(sizeof(Tetrahedron) == 4 * sizeof(VertexId));

template <class Value>
void append(std::vector<std::byte>& bytes, const std::vector<Value>& values) {
  const auto* begin = reinterpret_cast<const std::byte*>(values.data());
  bytes.insert(bytes.end(), begin, begin + values.size() * sizeof(Value));
}

template <class Value>
void take(std::span<const std::byte>& bytes, std::vector<Value>& values) {
  const std::size_t size = values.size() * sizeof(Value);
  if (size > 0) std::memcpy(static_cast<void*>(values.data()), bytes.data(), size);
  bytes = bytes.subspan(size);
}

Error no_answer() {
  return system_error("tremolo-mesh gave no answer that this program understands");
}

}  // namespace

std::vector<std::byte> encode_answer(const Result<MesherAnswer>& answer) {
  nlohmann::json head;
  if (answer) {
    head["format"] = answer->format;
    head["notes"] = answer->notes;
    head["vertices"] = answer->mesh.vertices.size();
    head["tetrahedra"] = answer->mesh.tetrahedra.size();
    head["turned"] = answer->turned.size();
  } else {
    head["kind"] = static_cast<int>(answer.error().kind);
    head["message"] = answer.error().message;
  }
  // A name in a file need not be UTF-8.
  const std::string line =
      head.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace) + "\n";
  std::vector<std::byte> bytes(line.size());
  std::memcpy(bytes.data(), line.data(), line.size());
  if (answer) {
    append(bytes, answer->mesh.vertices);
    append(bytes, answer->mesh.tetrahedra);
    append(bytes, answer->turned);
  }
  return bytes;
}

Result<MesherAnswer> decode_answer(std::span<const std::byte> bytes) {
  const auto end = std::find(bytes.begin(), bytes.end(), std::byte{'\n'});
  if (end == bytes.end()) return no_answer();
  const std::size_t length = end - bytes.begin();
  const std::string_view line(reinterpret_cast<const char*>(bytes.data()), length);
  const nlohmann::json head = nlohmann::json::parse(line, nullptr, false);
  if (!head.is_object()) return no_answer();
  try {
    if (head.contains("message"))
      return Error{static_cast<ErrorKind>(head.at("kind").get<int>()),
                   head.at("message").get<std::string>()};
    MesherAnswer answer;
    answer.format = head.at("format").get<std::string>();
    answer.notes = head.at("notes").get<std::vector<std::string>>();
    const auto vertices = head.at("vertices").get<std::size_t>();
    const auto tetrahedra = head.at("tetrahedra").get<std::size_t>();
    const auto turned = head.at("turned").get<std::size_t>();
    bytes = bytes.subspan(length + 1);
    constexpr std::size_t kMost = std::size_t{1} << 40;
    if (vertices > kMost || tetrahedra > kMost || turned > kMost ||
        bytes.size() != vertices * sizeof(Eigen::Vector3d) + tetrahedra * sizeof(Tetrahedron) +
                            turned * sizeof(std::int32_t))
      return no_answer();
    answer.mesh.vertices.resize(vertices);
    answer.mesh.tetrahedra.resize(tetrahedra);
    take(bytes, answer.mesh.vertices);
    take(bytes, answer.mesh.tetrahedra);
    answer.turned.resize(turned);
    take(bytes, answer.turned);
    return answer;
  } catch (const nlohmann::json::exception&) {
    return no_answer();
  }
}

}  // namespace tremolo
