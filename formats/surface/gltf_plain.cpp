#include <algorithm>
#include <array>
#include <cstring>
#include <utility>
#include <vector>

#include "formats/file/base64.h"
#include "formats/file/printable_text.h"
#include "formats/file/scanner.h"
#include "formats/surface/gltf_data.h"
#include "formats/surface/surface_answer.h"

namespace tremolo {
namespace {

using nlohmann::json;

constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";
constexpr const char* kDraco = "KHR_draco_mesh_compression";

// True for extensions that do not change shapes: their additions are not read.
bool changes_no_shape(std::string_view name) {
  constexpr std::array<std::string_view, 11> kHarmless = {
      "KHR_technique",    "KHR_texture_transform", "KHR_texture_basisu", "EXT_texture_webp",
      "EXT_texture_avif", "MSFT_texture_dds",      "KHR_lights_",        "EXT_lights_",
      "KHR_xmp",          "KHR_materials_",        "EXT_materials_"};
  return std::any_of(kHarmless.begin(), kHarmless.end(),
                     [name](std::string_view harmless) { return name.starts_with(harmless); });
}

Error refused_extension(const std::string& name) {
  const std::string shown = printable_text(name, 80);
  std::string advice = "export it without this extension";
  if (name.starts_with(kDraco)) advice = "export it without Draco compression";
  if (name.find("meshopt") != std::string::npos)
    advice = "export it without meshopt compression (gltf-transform copy IN OUT unpacks it)";
  return content_error("it requires the glTF extension " + shown +
                       ", which is not read: " + advice);
}

Status check_extensions(const json& document) {
  for (const json& entry : gltf_list(document, "extensionsRequired")) {
    if (!entry.is_string()) continue;
    const std::string name = entry.get<std::string>();
    // assimp unpacks Draco, or says that it was built without.
    if (name != "KHR_mesh_quantization" && name != kInstancing && name != kDraco &&
        !changes_no_shape(name))
      return refused_extension(name);
  }
  return Success{};
}

// A .glb's parts; json is empty where it is not one of version 2.
struct GlbParts {
  std::string_view json, binary;
};

GlbParts glb_parts(std::string_view bytes) {
  constexpr std::uint32_t kMagic = 0x46546c67, kJson = 0x4e4f534a, kBinary = 0x004e4942;
  GlbParts parts;
  const auto word = [bytes](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
  };
  if (bytes.size() < 20 || word(0) != kMagic || word(4) != 2) return parts;
  for (std::size_t at = 12; bytes.size() - at >= 8;) {
    const std::size_t length = word(at);
    const std::uint32_t kind = word(at + 4);
    at += 8;
    if (length > bytes.size() - at) break;
    if (kind == kJson && parts.json.empty()) parts.json = bytes.substr(at, length);
    if (kind == kBinary && parts.binary.empty()) parts.binary = bytes.substr(at, length);
    at += length;
  }
  return parts;
}

std::string glb_bytes(std::string text, std::string_view binary) {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string bytes = "glTF";
  const auto add = [&bytes](std::size_t value) {
    const auto word = static_cast<std::uint32_t>(value);
    bytes.append(reinterpret_cast<const char*>(&word), sizeof word);
  };
  add(2);
  add(20 + text.size() + (binary.empty() ? 0 : 8 + binary.size()));
  add(text.size());
  bytes += "JSON" + text;
  if (binary.empty()) return bytes;
  add(binary.size());
  bytes += std::string("BIN\0", 4);
  return bytes.append(binary);
}

class PlainMaker {
 public:
  PlainMaker(json& document, std::string_view binary, const GltfData::Open& open)
      : document_(document), original_(document), data_(original_, binary, open) {}

  // Returns whether anything was changed.
  Result<bool> make() {
    if (Status s = make_meshes(); !s) return s.error();
    if (Status s = make_animations(); !s) return s.error();
    if (Status s = make_instances(); !s) return s.error();
    make_skins();
    if (!floats_.empty()) {
      document_["buffers"].push_back(
          {{"byteLength", floats_.size()},
           {"uri", "data:application/octet-stream;base64," + encode_base64(floats_)}});
    }
    return changed_;
  }

 private:
  // The accessor of the same values as floats: itself where it has them.
  Status make_floats(json& accessor) {
    if (!accessor.is_number_integer()) return Success{};
    const auto index = accessor.get<std::int64_t>();
    const json& list = gltf_list(original_, "accessors");
    if (index < 0 || std::cmp_greater_equal(index, list.size())) return Success{};
    if (gltf_integer(list[static_cast<std::size_t>(index)], "componentType", 0) == kGltfFloat)
      return Success{};
    if (const auto made = made_.find(index); made != made_.end()) {
      accessor = made->second;
      return Success{};
    }
    const Result<GltfValues> values = data_.values(index);
    if (!values) return values.error();
    static constexpr std::array kTypes = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    if (values->columns > 4) return Success{};
    const auto columns = static_cast<std::size_t>(values->columns);
    accessor = made_[index] = add_floats(values->values, columns, kTypes[columns]);
    return Success{};
  }

  // Colours and joints are read as the integers that they are.
  static bool is_float_attribute(std::string_view name) {
    constexpr std::array<std::string_view, 5> kKinds = {"POSITION", "NORMAL", "TANGENT",
                                                        "TEXCOORD_", "WEIGHTS_"};
    return std::any_of(kKinds.begin(), kKinds.end(),
                       [name](std::string_view kind) { return name.starts_with(kind); });
  }
  Status make_attributes(json& attributes) {
    if (!attributes.is_object()) return Success{};
    for (auto& [name, accessor] : attributes.items())
      if (is_float_attribute(name))
        if (Status s = make_floats(accessor); !s) return s;
    return Success{};
  }

  Status make_meshes() {
    if (gltf_list(document_, "meshes").empty()) return Success{};
    for (json& mesh : document_["meshes"]) {
      if (gltf_list(mesh, "primitives").empty()) continue;
      for (json& primitive : mesh["primitives"]) {
        if (!primitive.is_object()) continue;
        const Result<bool> draco = is_draco(primitive);
        if (!draco) return draco.error();
        if (*draco) continue;
        if (primitive.contains("attributes"))
          if (Status s = make_attributes(primitive["attributes"]); !s) return s;
        if (gltf_list(primitive, "targets").empty()) continue;
        for (json& target : primitive["targets"])
          if (Status s = make_attributes(target); !s) return s;
      }
    }
    return Success{};
  }

  // True if assimp decompresses the primitive; all its accessors are then floats.
  Result<bool> is_draco(const json& primitive) const {
    const auto extensions = primitive.find("extensions");
    if (extensions == primitive.end() || !extensions->is_object() ||
        !extensions->contains(kDraco) || !primitive.contains("attributes") ||
        !primitive["attributes"].is_object())
      return false;
    const json& list = gltf_list(original_, "accessors");
    for (const auto& [name, accessor] : primitive["attributes"].items()) {
      const std::int64_t index = accessor.is_number_integer() ? accessor.get<std::int64_t>() : -1;
      if (!is_float_attribute(name) || index < 0 || std::cmp_greater_equal(index, list.size()))
        continue;
      if (gltf_integer(list[static_cast<std::size_t>(index)], "componentType", 0) != kGltfFloat)
        return refused_extension(std::string(kDraco) + " of integers");
    }
    return true;
  }

  Status make_animations() {
    if (gltf_list(document_, "animations").empty()) return Success{};
    for (json& animation : document_["animations"]) {
      if (gltf_list(animation, "samplers").empty()) continue;
      for (json& sampler : animation["samplers"])
        if (sampler.is_object() && sampler.contains("output"))
          if (Status s = make_floats(sampler["output"]); !s) return s;
    }
    return Success{};
  }

  // Appends floats to the existing ones, as an accessor.
  std::int64_t add_floats(const std::vector<float>& values, std::size_t columns, const char* type) {
    changed_ = true;
    document_["bufferViews"].push_back({{"buffer", gltf_list(original_, "buffers").size()},
                                        {"byteOffset", floats_.size()},
                                        {"byteLength", values.size() * sizeof(float)}});
    document_["accessors"].push_back({{"bufferView", document_["bufferViews"].size() - 1},
                                      {"componentType", kGltfFloat},
                                      {"count", values.size() / columns},
                                      {"type", type}});
    floats_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
    return static_cast<std::int64_t>(document_["accessors"].size() - 1);
  }

  // Missing inverse bind matrices are the identity. Bones are found by their names, so each node
  // gets a unique one.
  void make_skins() {
    if (gltf_list(document_, "skins").empty()) return;
    for (json& skin : document_["skins"]) {
      const std::size_t joints = gltf_list(skin, "joints").size();
      if (!skin.is_object() || joints == 0 || skin.contains("inverseBindMatrices")) continue;
      std::vector<float> matrices;
      for (std::size_t k = 0; k < 16 * joints; ++k)
        matrices.push_back(k % 16 % 5 == 0 ? 1.0F : 0.0F);
      skin["inverseBindMatrices"] = add_floats(matrices, 16, "MAT4");
    }
    UniqueNames names("node");
    if (gltf_list(document_, "nodes").empty()) return;
    for (json& node : document_["nodes"]) {
      if (!node.is_object()) continue;
      const std::string name = gltf_text(node, "name");
      // A mesh without a name of its node is called as the mesh is.
      if (name.empty() && node.contains("mesh")) continue;
      const std::string own = names.take(name);
      if (own == name) continue;
      node["name"] = own;
      changed_ = true;
    }
  }

  Status make_instances() {
    const std::size_t count = gltf_list(document_, "nodes").size();
    for (std::size_t n = 0; n < count; ++n) {
      json& node = document_["nodes"][n];
      if (!node.is_object() || !node.contains("mesh") || !node.contains("extensions") ||
          !node["extensions"].is_object() || !node["extensions"].contains(kInstancing))
        continue;
      if (Status s = make_instances_of(n); !s) return s;
    }
    return Success{};
  }

  Status make_instances_of(std::size_t n) {
    const json extension = document_["nodes"][n]["extensions"][kInstancing];
    static const json kNone = json::object();
    const json& attributes =
        extension.is_object() && extension.contains("attributes") ? extension["attributes"] : kNone;
    struct Part {
      const char *attribute, *member;
      std::int64_t columns;
      GltfValues values;
    };
    std::array parts = {Part{"TRANSLATION", "translation", 3, {}},
                        Part{"ROTATION", "rotation", 4, {}}, Part{"SCALE", "scale", 3, {}}};
    std::size_t instances = 0;
    for (Part& part : parts) {
      const std::int64_t accessor = gltf_integer(attributes, part.attribute, -1);
      if (accessor < 0) continue;
      if (Status s = take(part.values, data_.values(accessor)); !s) return s;
      const std::size_t rows = part.values.values.size() / static_cast<std::size_t>(part.columns);
      if (part.values.columns != part.columns || (instances != 0 && rows != instances))
        return content_error(std::string(kInstancing) + ": " + part.attribute +
                             " has another number of rows or columns than the instances");
      instances = rows;
    }
    changed_ = true;
    json& nodes = document_["nodes"];
    const json mesh = nodes[n]["mesh"];
    const std::string name = gltf_text(nodes[n], "name");
    nodes[n].erase("mesh");
    if (!nodes[n].contains("children") || !nodes[n]["children"].is_array())
      nodes[n]["children"] = json::array();
    for (std::size_t i = 0; i < instances; ++i) {
      json copy = {{"mesh", mesh}};
      if (!name.empty()) copy["name"] = name;
      for (const Part& part : parts) {
        if (part.values.values.empty()) continue;
        const auto width = static_cast<std::size_t>(part.columns);
        copy[part.member] = std::vector<float>(
            part.values.values.begin() + static_cast<std::ptrdiff_t>(i * width),
            part.values.values.begin() + static_cast<std::ptrdiff_t>((i + 1) * width));
      }
      nodes[n]["children"].push_back(nodes.size());
      nodes.push_back(std::move(copy));
    }
    return Success{};
  }

  json& document_;
  const json original_;
  GltfData data_;
  std::map<std::int64_t, std::int64_t> made_;
  std::string floats_;
  bool changed_ = false;
};

}  // namespace

Result<std::optional<std::string>> plain_gltf(std::string_view bytes, bool glb,
                                              const GltfData::Open& open) {
  const GlbParts parts = glb ? glb_parts(bytes) : GlbParts{without_mark(bytes), {}};
  json document = json::parse(parts.json, nullptr, false);
  // assimp reports errors in the JSON, and reads version 1 completely.
  if (!document.is_object() || !document.contains("asset") ||
      gltf_text(document["asset"], "version").starts_with("1"))
    return std::optional<std::string>();
  if (Status s = check_extensions(document); !s) return s.error();
  const Result<bool> changed = PlainMaker(document, parts.binary, open).make();
  if (!changed) return changed.error();
  const bool marked = !glb && parts.json.size() != bytes.size();
  if (!*changed && !marked) return std::optional<std::string>();
  std::string text = document.dump(-1, ' ', false, json::error_handler_t::replace);
  return std::optional<std::string>(glb ? glb_bytes(std::move(text), parts.binary) : text);
}

}  // namespace tremolo
