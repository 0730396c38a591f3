// The basis file: header, table, every section.
#include "formats/basis/basis_reader.h"
#include "tests/fuzz/harness.h"

void tremolo::fuzz::read_input(std::string_view bytes) {
  Result<BasisReader> reader =
      BasisReader::from_memory(std::as_bytes(std::span(bytes.data(), bytes.size())));
  check_error(reader);
  if (!reader) return;
  if (!reader->verify_all()) finding("a checksum was compared");
  const Result<BasisData> data = read_basis(*reader);
  check_error(data);
  if (!data) return;
  if (!data->lambda.allFinite() || !data->surface.rows.allFinite() ||
      !data->interior.rows.allFinite())
    finding("a number that is not finite");
  if (data->render)
    for (const Triangle& triangle : data->render->surface.triangles)
      for (VertexId v : triangle)
        if (v < 0 || static_cast<std::size_t>(v) >= data->render->surface.vertices.size())
          finding("a drawn triangle of a vertex that is not there");
  for (const Triangle& triangle : data->triangles)
    for (VertexId v : triangle)
      if (v < 0 || static_cast<std::size_t>(v) >= data->surface.vertex_ids.size())
        finding("a triangle of a vertex that is not there");
}
