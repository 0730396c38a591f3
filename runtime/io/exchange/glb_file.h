// The container of glTF 2.0 (ISO/IEC 12113): a JSON text and one buffer in a .glb file, with the
// buffer's views and accessors. The writer gives the accessors their meaning.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/io/exchange/animation.h"
#include "runtime/io/exchange/bent_normals.h"
#include "runtime/io/exchange/glb_writer.h"
#include "runtime/io/exchange/morph_targets.h"

namespace tremolo {

// glTF's codes for kinds of components.
enum class GlbComponent { kByte = 5121, kShort = 5123, kInt = 5125, kFloat = 5126 };

// Kinds of arrays; those of one kind are in one view of the buffer. kMotion: for animations.
enum class GlbPart { kVectors, kUvs, kColours, kJoints, kWeights, kIndices, kMotion };
inline constexpr std::size_t kGlbParts = 7;

// The format of an accessor.
struct GlbFormat {
  GlbComponent component = GlbComponent::kFloat;
  int components = 1;  // of a vector, 1 to 4
  bool normalized = false;
  bool bounds =
      false;  // write the least and largest values; glTF requires it for positions and times
};

class GlbFile {
 public:
  // Adds an array and returns its accessor's number. count: of vectors. Only float arrays have
  // bounds.
  std::size_t add(GlbPart part, const GlbFormat& format, const void* bytes, std::size_t size,
                  std::size_t count);
  std::size_t add_floats(GlbPart part, int components, std::span<const float> values,
                         bool bounds = false);
  // Vectors of zeros, with bounds, of which the file has no bytes.
  std::size_t add_zeros(int components, std::size_t count);
  // Adds an image in the format of its file; returns its number.
  std::size_t add_image(const std::string& name, const std::string& type, std::string bytes);

  // Writes the file. members: of the JSON's top level, each `"name":value`, to which the buffer's
  // views and accessors are added. Errors: kContent if it is larger than glTF's 4 GB; kSystem.
  // bytes receives its size.
  Status write(const std::string& path, std::vector<std::string> members, std::uint64_t& bytes);

 private:
  struct Image {
    std::string name, type, bytes;
  };

  std::size_t view_of(GlbPart part);

  std::array<std::string, kGlbParts> parts_;
  std::array<int, kGlbParts> stride_{};  // bytes from vector to vector; 0: not written
  std::vector<GlbPart> views_;           // those that are used, in the order of their numbers
  std::vector<std::string> accessors_;
  std::vector<Image> images_;
};

// Lists at the file's top level, besides accessors; the entries are JSON.
struct GlbLists {
  std::vector<std::string> materials;
  std::vector<std::string> textures;
  std::vector<std::size_t> images;  // of GlbOptions::textures, each once; the image's number
};

// attributes: the members `"NAME":accessor` of the base. targets: the same of each target, those of
// the ranges first, then those of normals alone.
// primitives: of each material that has triangles, the accessor of its corners and its number in
// GlbLists::materials.
struct GlbShape {
  TargetRanges ranges;
  BentNormals bent;
  std::vector<std::string> attributes;
  std::vector<std::string> targets;
  struct Primitive {
    std::size_t indices;
    std::size_t material;
  };
  std::vector<Primitive> primitives;
};

// Reads the options' textures and adds them. Errors as write_glb.
Status add_textures(GlbFile& file, const GlbOptions& options, GlbLists& lists);

// Adds its numbers to the report.
GlbShape add_shape(GlbFile& file, const Animation& animation, std::size_t shape,
                   const GlbOptions& options, GlbLists& lists, GlbReport& report);

// The weights of all targets in a frame of the body of this number, which is one of the shape's.
std::vector<float> shape_weights(const Animation& animation, std::size_t body, std::size_t frame,
                                 const GlbShape& shape);

// The members of a body on bones: the joints and weights of its vertices, four a set, as many sets
// as the vertex with the most bones needs, which `most` receives.
std::vector<std::string> add_bone_weights(GlbFile& file, const BoneWeights& weights,
                                          std::size_t& most);

// GlbReport::four_bones_error of a body on bones; frames as morph_error takes them.
double four_bones_error(const Animation& animation, const AnimatedBody& body);

// The mesh of a body as JSON. further: members besides the shape's own; weights: at the start.
std::string mesh_text(const std::string& name, const GlbShape& shape,
                      const std::vector<std::string>& further, const std::vector<float>& weights);

}  // namespace tremolo
