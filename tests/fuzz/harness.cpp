#include "tests/fuzz/harness.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <sanitizer/allocator_interface.h>

#include "common/mesh/mesh_check.h"

namespace tremolo::fuzz {
namespace {

// Meter of the heap, while a reader is at work. A reader has one thread.
struct HeapMeter {
  bool running = false;
  std::ptrdiff_t live = 0;
  std::ptrdiff_t peak = 0;
};
HeapMeter meter;

void count_allocation(const volatile void*, std::size_t size) {
  if (!meter.running) return;
  meter.live += static_cast<std::ptrdiff_t>(size);
  meter.peak = std::max(meter.peak, meter.live);
}

void count_release(const volatile void* memory) {
  if (!meter.running || memory == nullptr) return;
  meter.live -=
      static_cast<std::ptrdiff_t>(__sanitizer_get_allocated_size(const_cast<const void*>(memory)));
}

bool in_range(const TetMesh& mesh, VertexId id) {
  return id >= 0 && static_cast<std::size_t>(id) < mesh.vertices.size();
}

}  // namespace

void finding(const char* what) {
  std::fprintf(stderr, "finding: %s\n", what);
  std::abort();
}

void check_mesh_file(Result<MeshFile> file) {
  check_error(file);
  if (!file) return;
  TetMesh& mesh = file->mesh;
  if (mesh.tetrahedra.empty()) finding("a mesh without tetrahedra");
  for (const Eigen::Vector3d& x : mesh.vertices)
    if (!x.allFinite()) finding("a coordinate that is not finite");
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (VertexId id : tet)
      if (!in_range(mesh, id)) finding("a tetrahedron of a vertex that is not there");
  for (const auto& [name, ids] : mesh.node_sets) {
    for (VertexId id : ids)
      if (!in_range(mesh, id)) finding("a set with a vertex that is not there");
    if (!std::is_sorted(ids.begin(), ids.end()) ||
        std::adjacent_find(ids.begin(), ids.end()) != ids.end())
      finding("a set that is not sorted or has repeats");
  }
  if (!mesh.region_of.empty() && mesh.region_of.size() != mesh.tetrahedra.size())
    finding("regions of more or fewer tetrahedra than there are");
  for (const std::int32_t region : mesh.region_of)
    if (region < -1 || region >= static_cast<std::int32_t>(mesh.region_names.size()))
      finding("a region without a name");
  if (!mesh.colours.empty() && mesh.colours.size() != mesh.vertices.size())
    finding("colours of more or fewer vertices than there are");
  const Result<MeshReport> report = check_mesh(mesh);
  if (!report) return;
  for (const Tetrahedron& tet : mesh.tetrahedra)
    if (!(signed_volume(mesh, tet) > 0)) finding("an inverted tetrahedron after check_mesh");
}

}  // namespace tremolo::fuzz

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  __sanitizer_install_malloc_and_free_hooks(tremolo::fuzz::count_allocation,
                                            tremolo::fuzz::count_release);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using tremolo::fuzz::meter;
  meter = {true, 0, 0};
  tremolo::fuzz::read_input({reinterpret_cast<const char*>(data), size});
  meter.running = false;
  const std::size_t allowed = tremolo::fuzz::kFixedBytes + tremolo::fuzz::kBytesAByte * size;
  if (static_cast<std::size_t>(meter.peak) > allowed) {
    std::fprintf(stderr, "%zu bytes of input, %td bytes of heap, allowed %zu\n", size, meter.peak,
                 allowed);
    tremolo::fuzz::finding("a reader's memory is not bounded by its file");
  }
  return 0;
}
