// fuzz_seeds DIR writes DIR/TARGET/*: the small files that the tests write for themselves.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "formats/basis/basis_writer.h"
#include "formats/collider/collider_file.h"
#include "formats/file/checkpoint_file.h"
#include "formats/surface/surface_answer.h"
#include "formats/vega/reduced_files.h"
#include "tests/support/meshes/mesh_variants.h"
#include "tests/support/meshes/writer_forms.h"
#include "tests/support/small_collider.h"
#include "tests/support/tiny_basis.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

void save(const fs::path& folder, const std::string& name, const std::string& bytes) {
  fs::create_directories(folder);
  std::ofstream(folder / name, std::ios::binary) << bytes;
}

std::string file_contents(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void save_meshes(const fs::path& root) {
  int number = 0;
  for (const testing::MeshVariant& variant : testing::all_mesh_variants()) {
    const std::string& bytes = variant.files.front().second;
    const std::string extension = fs::path(variant.files.front().first).extension().string();
    const std::string name = std::to_string(number++);
    if (extension == ".node")
      save(root / "tetgen", name, bytes + "$" + variant.files.back().second);
    else if (extension != ".ele")
      save(root / extension.substr(1), name, bytes);
  }
  save(root / "vtu", "crlf", testing::with_crlf(testing::vtu_text()));
  // Other programs' forms, as far as inputs of a fuzzer are long.
  for (const testing::WriterForm& form : testing::all_writer_forms()) {
    const auto& [file, bytes] = form.files.front();
    const std::string extension = fs::path(file).extension().string();
    const std::string target = extension == ".nas" ? "bdf" : extension.substr(1);
    if (target != "node" && bytes.size() <= 4096)
      save(root / target, std::to_string(number++), bytes);
  }
  const std::string inp =
      "*HEADING\nx\n*PART, NAME=p\n*NODE, NSET=all\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n"
      "*ELEMENT, TYPE=C3D4, ELSET=a\n1,1,2,3,4\n*ELEMENT, TYPE=C3D6\n2,1,2,3,\n4,5,2\n*NSET, "
      "NSET=s, "
      "GENERATE\n1,3,2\n*NSET, NSET=t\ns, 4\n*SOLID SECTION, ELSET=a, MATERIAL=m\n*END "
      "PART\n*ASSEMBLY\n"
      "*INSTANCE, NAME=i, PART=p\n1,0,0\n0,0,0,0,0,1,90\n*END INSTANCE\n*NSET, NSET=u, "
      "INSTANCE=i\n2\n"
      "*END ASSEMBLY\n*MATERIAL, NAME=m\n*DENSITY\n1000,\n*ELASTIC\n1e6, 0.3\n*STEP\n";
  const std::string bdf =
      "CEND\nSET 5 = 1 THRU 3,\n4\nBEGIN BULK\nGRID,1,,0.,0.,0.\nGRID    2               1.      "
      "0.      "
      "0.\nGRID*   3                                              0.0             1.+0\n*          "
      "        "
      "0.E+0\nGRID,4,,0.,0.,1.\nGRID,5,,1.,1.,1.\nCTETRA,1,3,1,2,3,4\nCPENTA,2,4,1,2,3,4,5,2\n"
      "CTRIA3,3,5,1,2,3\nPSOLID,3,9\nMAT1,9,1.+6,,.3,1000.\nENDDATA\n";
  save(root / "inp", "small", inp);
  save(root / "bdf", "small", bdf);
}

void save_bases(const fs::path& root) {
  BasisData linear = testing::tiny_basis();
  linear.cubic.clear();
  linear.quartic.clear();
  save(root, "linear", "");
  if (!write_basis((root / "linear").string(), linear, BasisEncoding::kFull))
    std::fprintf(stderr, "fuzz_seeds: the linear basis file cannot be written\n");
  const fs::path golden = fs::path(TREMOLO_SOURCE_DIR) / "tests/formats/golden";
  for (const fs::directory_entry& entry : fs::directory_iterator(golden))
    if (entry.path().extension() == ".tremolo")
      save(root, entry.path().stem().string(), file_contents(entry.path()));
}

void save_colliders(const fs::path& root) {
  ColliderData data = testing::small_collider();
  const auto save_as = [&root](const std::string& name, const ColliderData& content) {
    save(root, name, "");
    if (!write_collider((root / name).string(), content))
      std::fprintf(stderr, "fuzz_seeds: a collider file cannot be written\n");
  };
  save_as("ball", data);
  data.provenance.clear();
  save_as("bare", data);
}

void save_checkpoints(const fs::path& root) {
  const std::vector<double> values = {1, 2, 3, 4, 5, 6};
  const std::vector<std::int64_t> integers = {-1, 0, std::int64_t{1} << 62};
  const std::vector<NamedArray> arrays = {
      named_array("identity", "mesh 0123456789abcdef\n"), named_array("values", values, 3, 2),
      named_array("integers", integers), named_array("nothing", std::span<const double>{}, 0)};
  for (std::size_t count = 1; count <= arrays.size(); ++count) {
    const std::string name = std::to_string(count);
    save(root, name, "");
    if (!write_checkpoint_file((root / name).string(), std::span(arrays).first(count)))
      std::fprintf(stderr, "fuzz_seeds: a checkpoint cannot be written\n");
  }
}

void save_reduced(const fs::path& root) {
  const Eigen::MatrixXd basis = Eigen::MatrixXd::Constant(6, 2, 0.5);
  if (const Result<std::string> bytes = basis_matrix_bytes(basis)) save(root, "basis", *bytes);
  const BasisData data = testing::tiny_basis();
  for (const bool linear : {false, true}) {
    const std::vector<double> none;
    const Result<std::string> bytes = cub_bytes(
        reduced_forces(data.lambda, linear ? none : data.cubic, linear ? none : data.quartic));
    if (bytes) save(root, linear ? "linear-forces" : "forces", *bytes);
  }
}

void save_surfaces(const fs::path& root) {
  const auto text = [](const std::vector<std::byte>& bytes) {
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  SurfaceFile file;
  file.unit = "metres";
  file.format = "Wavefront OBJ";
  file.notes = {"2 points left out"};
  RenderSurface& surface = file.surface;
  surface.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  surface.triangles = {{0, 1, 2}, {1, 2, 3}};
  surface.objects = {"a", "b"};
  surface.materials = {"wood"};
  surface.object_of = {0, 1};
  surface.material_of = {0, 0};
  save(root, "plain", text(encode_surface(file)));
  surface.normals.assign(4, Eigen::Vector3f(0, 0, 1));
  surface.uvs.assign(4, Eigen::Vector2f(0.25F, 0.5F));
  surface.colours.assign(4, Colour{255, 128, 0, 255});
  save(root, "full", text(encode_surface(file)));
  save(root, "refusal", text(encode_refusal("no triangles")));
}

void save_texts(const fs::path& root) {
  int number = 0;
  for (const char* text :
       {"x<0.01", "y>=1.2", "box:0,0,0,1,1,1", "vertex:1,2", "file:a", "none", "foot", "unused",
        " z <= +1e-3 ", "x<10%", "sphere:0,0,0,1", "plane:0,0,0,1,0,0", "near:0,0,0,2",
        "colour:red", "colour:#FF8000,0.2", "set:foot", "x<1 and y<1 and foot"})
    save(root / "selector", std::to_string(number++), text);
  for (const char* text :
       {"OFF\n4 1 0\n0 0 0\n1 0 0 # b\n1 1 0\n\n0 1 0\n# face\n4 0 1 2 3 255 0 0\n",
        "STCNOFF 3 2 0\n0 0 0 0 0 1 1 0 0 1 0 1\n1 0 0 0 0 1 1 0 0 1 0 1\n"
        "0 1 0 0 0 1 1 0 0 0 1\n3 0 1 2\n3 0 2 1 0.5 0.5 0.5 1\n",
        "OFF3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2"})
    save(root / "off", std::to_string(number++), text);
  for (const char* text : {"0 1 2\n", "1,2,3 # a comment\n4\n", "999"})
    save(root / "ids", std::to_string(number++), text);
  for (const char* text :
       {"t,value\n0,0\n0.1,1\n0.2,0\n", "0 1 # one\n1e-3\t-2\n\n2e-3 0", "\"t\"\n"})
    save(root / "signal", std::to_string(number++), text);
  for (const char* text : {"step,t,q0,q1,p0,p1\n0,0,0,0,0,0\n1,0.003,1e-3,-2e-3,0.5,0.25\n2,0.0",
                           "t,p1,q1,p0,q0,\"ux 3\"\r\n0.01,4,3,2,1,\r\n", "t,q0,q1,q2\n"})
    save(root / "state", std::to_string(number++), text);
  const fs::path scenes = fs::path(TREMOLO_SOURCE_DIR) / "assets/scenes";
  if (fs::exists(scenes))
    for (const fs::directory_entry& entry : fs::directory_iterator(scenes))
      if (entry.path().extension() == ".toml")
        for (const char* target : {"scene", "world"})
          save(root / target, entry.path().filename().string(), file_contents(entry.path()));
  save(root / "scene", "all",
       "[a]\nmodel = \"a.tremolo\"\nintegrator = 'ep4'\nstep = 3e-3\nduration = 1\nmodes = 0\n"
       "linear = true\nload = \"sine\"\nat = 3\nforce = \"1,2,3\"\nprobe = [1, 2]\n"
       "coordinate = 0\nevery = 10\nplot = false\nsurface-format = \"obj\"\n[b]\nmodel='/m'\n");
  save(root / "world", "all",
       "step = 1e-3\nduration = 2\ngravity = [[0, 0, 0, -9], [1, 0, 0, 0]]\nevery = 2\n"
       "[[bodies]]\nname = 'a'\nmodel = 'a.tremolo'\nkind = 'driven'\nposition = [1, 2, 3]\n"
       "turn = [0, 0, 1, 90]\nload = 'sine'\nat = 3\nforce = [1, 2, 3]\n"
       "[[bodies.motion]]\nkind = 'shake'\namplitude = [1, 0, 0]\nfrequency = 2\nduration = 3\n"
       "[[bodies.motion]]\nkind = 'spin'\naxis = [0, 0, 1]\nrate = 2\nstop = 1\n"
       "[[bodies.motion]]\nkind = 'fall'\nacceleration = [0, 0, -9]\nstop = 1\n"
       "[[bodies.motion]]\nkind = 'keyframes'\njumps = 'smooth'\n"
       "keys = [[0, 0, 0, 0], [1, 1, 0, 0], [1, 2, 0, 0], [2, 0, 0, 0, 0, 1, 0, 0]]\n"
       "[[bodies]]\nname = 'b'\nmodel = '/m'\nkind = 'free'\nquaternion = [1, 0, 0, 0]\n"
       "velocity = [0, 0, 1]\nspin = [1, 0, 0]\n");
  save(root / "world", "contact",
       "[[bodies]]\nname = 'a'\nmodel = 'a.tremolo'\nkind = 'free'\ncontact = true\n"
       "contact-points = 9\ncontact-margin = 0.01\ncontact-stiffness = 3\n"
       "[[colliders]]\nname = 'f'\nshape = 'plane'\nfriction = 0.1\nrestitution = 1\n"
       "[[colliders]]\nname = 's'\nshape = 'sphere'\nradius = 1\nposition = [0, 0, 3]\n"
       "[[colliders.motion]]\nkind = 'glide'\nvelocity = [0, 1, 0]\n"
       "[[colliders]]\nname = 'c'\nshape = 'capsule'\nradius = 1\nhalf-length = 0\n"
       "[[colliders]]\nname = 'b'\nshape = 'box'\nhalf-extents = [1, 2, 3]\n"
       "[[colliders]]\nname = 'y'\nshape = 'cylinder'\nradius = 1\nhalf-length = 2\n"
       "[[colliders]]\nname = 'm'\nshape = 'mesh'\nfile = 'm.collider'\nmade-by = 'x'\n"
       "[[hands]]\nbody = 'a'\nat = 3\nstiffness = 9\ndamping = 1\nposition = [1, 2, 3]\n"
       "from = 1\nuntil = 2\n[[hands.motion]]\nkind = 'shake'\namplitude = [1, 0, 0]\n");
}

}  // namespace
}  // namespace tremolo

int main(int count, char** words) {
  if (count != 2) {
    std::fprintf(stderr, "usage: fuzz_seeds DIR\n");
    return 2;
  }
  tremolo::save_meshes(words[1]);
  tremolo::save_bases(std::filesystem::path(words[1]) / "basis");
  tremolo::save_bases(std::filesystem::path(words[1]) / "model");
  tremolo::save_colliders(std::filesystem::path(words[1]) / "collider");
  tremolo::save_checkpoints(std::filesystem::path(words[1]) / "checkpoint");
  tremolo::save_reduced(std::filesystem::path(words[1]) / "reduced");
  tremolo::save_surfaces(std::filesystem::path(words[1]) / "surface");
  tremolo::save_texts(words[1]);
  return 0;
}
