// The buffers and accessors of a glTF 2.0 document.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/result.h"

namespace tremolo {

// The number or text at `key`, or `otherwise` if there is none of that type.
std::int64_t gltf_integer(const nlohmann::json& object, const char* key, std::int64_t otherwise);
std::string gltf_text(const nlohmann::json& object, const char* key);
// The array at `key`, or an empty one.
const nlohmann::json& gltf_list(const nlohmann::json& object, const char* key);

// The component type of 32-bit floats.
inline constexpr std::int64_t kGltfFloat = 5126;

// Values of an accessor, row by row; normalised integers are numbers from -1 or 0 to 1.
struct GltfValues {
  std::int64_t columns = 0;
  std::vector<float> values;
};

// Reads values. Nothing in the document is trusted.
class GltfData {
 public:
  // open: returns the bytes of a file in the document's folder, or an empty text. binary: the
  // .glb's second chunk, or empty. Both and the document must outlive it.
  using Open = std::function<std::string(const std::string& name)>;
  GltfData(const nlohmann::json& document, std::string_view binary, Open open)
      : document_(document), binary_(binary), open_(std::move(open)) {}

  // Errors (kContent): an index, a type or a length that cannot be; a buffer that is not there.
  Result<GltfValues> values(std::int64_t accessor);

 private:
  struct Layout {
    std::int64_t component = 0, columns = 0;
    std::uint64_t count = 0;
    bool normalised = false;
  };
  Result<Layout> layout(const nlohmann::json& accessor) const;
  // The bytes of `count` rows of `row` bytes; stride: from one to the next.
  Result<std::string_view> rows(const nlohmann::json& holder, std::uint64_t count,
                                std::uint64_t row, std::uint64_t& stride);
  Result<std::string_view> buffer(std::int64_t index);
  Status apply_sparse(const nlohmann::json& sparse, const Layout& layout, GltfValues& values);

  const nlohmann::json& document_;
  std::string_view binary_;
  Open open_;
  std::map<std::int64_t, std::string> loaded_;
};

// glTF 2.0 as assimp 5.2.5 understands it: 32-bit floats, a node for each copy of a mesh. Converts
// the file to simpler glTF; nothing if it is simple already, or is not glTF 2.0. Integers in
// attributes and animations (KHR_mesh_quantization, and those of glTF itself) become floats,
// EXT_mesh_gpu_instancing becomes nodes, a byte-order mark is removed. glb: the file is a .glb.
// open: as for GltfData. Errors (kContent): a required extension that is not supported, with its
// name and what to do; accessors that cannot be read.
Result<std::optional<std::string>> plain_gltf(std::string_view bytes, bool glb,
                                              const GltfData::Open& open);

}  // namespace tremolo
