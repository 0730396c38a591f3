#include "formats/surface/surface_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string_view>
#include <unistd.h>

#include "common/result.h"
#include "common/text.h"
#include "formats/file/input_file.h"
#include "formats/file/limited_child.h"
#include "formats/surface/surface_answer.h"

namespace tremolo {
namespace {

// Extensions that assimp 5.2.5 reads, without files of animations alone and without any kind of
// XML.
constexpr std::array<std::string_view, 64> kExtensions = {
    ".3d",   ".3ds",     ".3mf",  ".ac",       ".ac3d", ".acc", ".amf",    ".ase",
    ".ask",  ".assbin",  ".b3d",  ".blend",    ".bsp",  ".cob", ".dae",    ".dxf",
    ".enff", ".fbx",     ".glb",  ".gltf",     ".hmp",  ".ifc", ".ifczip", ".iqm",
    ".irr",  ".irrmesh", ".lwo",  ".lws",      ".lxo",  ".md2", ".md3",    ".md5mesh",
    ".mdc",  ".mdl",     ".mesh", ".mesh.xml", ".ms3d", ".ndo", ".nff",    ".obj",
    ".off",  ".ogex",    ".pk3",  ".ply",      ".pmx",  ".prj", ".q3o",    ".q3s",
    ".raw",  ".scn",     ".sib",  ".smd",      ".step", ".stl", ".stp",    ".ter",
    ".uc",   ".vta",     ".x",    ".x3d",      ".x3db", ".xgl", ".zae",    ".zgl"};

constexpr std::uint64_t kLeastMemory = 256'000'000;
constexpr std::uint64_t kMemoryPerByte = 100;
// An extent beyond these is more likely a unit that was not said, m.
constexpr double kLarge = 100;
constexpr double kSmall = 1e-3;
// Coordinates are in single precision: at this distance from the origin their error is 1e-4 of the
// size.
constexpr double kFarOff = 1e-4 * (1 << 24);

// The size of a regular file that can be read. It is opened by assimp only.
Result<std::uint64_t> size_of(const std::string& path) {
  const Result<struct stat> status = examine_input(path);
  if (!status) return status.error();
  if (::access(path.c_str(), R_OK) != 0) return os_error(path + ": cannot open");
  if (status->st_size <= 0) return content_error(path + ": the file is empty");
  return status->st_size;
}

// The size including the .bin files in the folder of a .gltf, which may hold its values.
std::uint64_t size_with_others(const std::string& path, std::uint64_t size) {
  namespace fs = std::filesystem;
  if (lower_case(fs::path(path).extension().string()) != ".gltf") return size;
  std::error_code none;
  const fs::path folder = fs::absolute(path, none).parent_path();
  for (fs::directory_iterator entry(folder, none), end; !none && entry != end;
       entry.increment(none)) {
    std::error_code unknown;
    if (entry->path().extension() != ".bin" || !entry->is_regular_file(unknown)) continue;
    const std::uintmax_t bytes = entry->file_size(unknown);
    if (!unknown) size += bytes;
  }
  return size;
}

std::uint64_t memory_for(std::uint64_t size) {
  const long pages = ::sysconf(_SC_PHYS_PAGES);
  const std::uint64_t machine = pages > 0 ? pages * ::sysconf(_SC_PAGESIZE) : UINT64_MAX;
  return std::min(kLeastMemory + std::min(size, UINT64_MAX / 200) * kMemoryPerByte,
                  std::max(kLeastMemory, machine));
}

std::string advice(const std::string& path) {
  const std::string extension = lower_case(std::filesystem::path(path).extension().string());
  if (extension == ".step" || extension == ".stp")
    return " (of STEP only buildings, IFC, are read: export the model as STL or OBJ)";
  return "";
}

// Text in two bytes a character, which assimp does not read: what to do about it, or nothing.
std::string encoding_advice(const std::string& path) {
  const Result<MappedFile> file = MappedFile::open(path);
  if (!file || file->bytes().size() < 2) return "";
  const std::byte first = file->bytes()[0], second = file->bytes()[1];
  constexpr std::byte kFe{0xfe}, kFf{0xff};
  const bool marked = (first == kFf && second == kFe) || (first == kFe && second == kFf);
  return marked ? ". The file begins with the byte-order mark of UTF-16 text: save it as UTF-8"
                : "";
}

void note_size(SurfaceFile& file, bool unit_given) {
  const BoundingBox box = bounding_box(file.surface.vertices);
  const double diagonal = box.diagonal();
  if (!unit_given && diagonal > 0 && (diagonal > kLarge || diagonal < kSmall))
    file.notes.push_back("the surface is " + number_text(diagonal) +
                         " m across: if its unit is not " + number_text(file.metres_per_unit) +
                         " m, say so, as in --unit mm or --unit cm");
  const double far = std::max(box.low.cwiseAbs().maxCoeff(), box.high.cwiseAbs().maxCoeff());
  if (far > kFarOff * diagonal)
    file.notes.push_back("the surface lies " + number_text(far / diagonal) +
                         " times its size from the origin: coordinates have seven digits, of which "
                         "few are left for its shape; move it to the origin before it is exported");
}

Status to_metres(SurfaceFile& file, const SurfaceReadOptions& options) {
  const bool given = options.metres_per_unit != 0;
  if (given) {
    file.metres_per_unit = options.metres_per_unit;
    file.unit = "given: " + number_text(options.metres_per_unit) + " m";
  }
  if (!std::isfinite(file.metres_per_unit) || file.metres_per_unit <= 0)
    return content_error("a unit of " + number_text(file.metres_per_unit) + " m");
  for (Eigen::Vector3d& x : file.surface.vertices) {
    x *= file.metres_per_unit;
    if (!x.allFinite()) return content_error("coordinates too large for a number");
  }
  if (file.surface.rig != nullptr) {
    SurfaceRig rig = *file.surface.rig;
    for (RigBone& bone : rig.bones) {
      bone.head *= file.metres_per_unit;
      bone.tail *= file.metres_per_unit;
    }
    for (RigClip& clip : rig.clips)
      for (RigPose& pose : clip.poses) pose.position *= file.metres_per_unit;
    file.surface.rig = std::make_shared<const SurfaceRig>(std::move(rig));
  }
  note_size(file, given);
  return Success{};
}

}  // namespace

bool is_surface_file(const std::string& path) {
  const std::string name = lower_case(std::filesystem::path(path).filename().string());
  return std::any_of(kExtensions.begin(), kExtensions.end(), [&](std::string_view extension) {
    return name.size() > extension.size() && name.ends_with(extension);
  });
}

Result<SurfaceFile> read_surface(const std::string& path, const SurfaceReadOptions& options) {
  const Result<std::uint64_t> size = size_of(path);
  if (!size) return size.error();
  const std::uint64_t memory =
      options.bytes > 0 ? options.bytes : memory_for(size_with_others(path, *size));
  const auto prefixed = [&path](const Error& error) {
    return Error{error.kind, path + ": " + error.message};
  };

  const auto work = [&path, memory] {
    const Result<SurfaceFile> file = import_surface(path, memory);
    return file ? encode_surface(*file) : encode_refusal(file.error().message);
  };
  const Result<std::vector<std::byte>> answer =
      answer_of_child(work, {.seconds = options.seconds, .memory = memory, .answer = memory});
  if (!answer) {
    if (answer.error().kind != ErrorKind::kContent) return prefixed(answer.error());
    return content_error(path + ": reading it " + answer.error().message + " (the file has " +
                         std::to_string(*size) + " bytes)");
  }
  Result<SurfaceFile> file = decode_surface(*answer);
  if (!file)
    return content_error(path + ": cannot be read: " + file.error().message + advice(path) +
                         encoding_advice(path));
  const Status scaled = to_metres(*file, options);
  if (!scaled) return prefixed(scaled.error());
  return file;
}

}  // namespace tremolo
