// Reads the header of a .ply file, and its numbers in order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace tremolo {

enum class PlyForm { kText, kLittleEndian, kBigEndian };
enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

// The meaning of a property of vertices, faces or strips.
enum class PlyRole {
  kNone,
  kX,
  kY,
  kZ,  // a vertex's position,
  kNormalX,
  kNormalY,
  kNormalZ,
  kU,
  kV,  // its texture coordinates
  kRed,
  kGreen,
  kBlue,
  kAlpha,
  kCorners,    // a face's list of vertices
  kCornerUvs,  // its list of texture coordinates, two per corner
  kStrips      // vertices of triangle strips, -1 between them
};

struct PlyProperty {
  PlyType type = PlyType::kFloat;
  bool list = false;
  PlyType count_type = PlyType::kUint8;
  PlyRole role = PlyRole::kNone;
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

// size: of the header, bytes.
struct PlyHeader {
  PlyForm form = PlyForm::kText;
  std::vector<PlyElement> elements;
  std::size_t size = 0;
};

// Lines end in LF, CR LF or CR. Errors (kContent): it does not begin with `ply`, an unknown form,
// type or keyword, vertices without x, y and z; more items than the file has bytes.
Result<PlyHeader> parse_ply_header(std::string_view bytes, const std::string& name);

// Reads the numbers after the header, which must outlive it.
class PlyNumbers {
 public:
  PlyNumbers(std::string_view body, PlyForm form, std::size_t offset)
      : body_(body), form_(form), offset_(offset) {}

  // False at an early end, or if there is no number.
  bool read(PlyType type, double& value);
  Error error(const std::string& name) const;
  std::size_t remaining() const { return body_.size() - at_; }

 private:
  bool read_text(double& value);

  std::string_view body_;
  PlyForm form_;
  std::size_t offset_;
  std::size_t at_ = 0;
};

}  // namespace tremolo
