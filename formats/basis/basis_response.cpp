// Reads the body's response to forces at points from a basis file.
#include "formats/basis/basis_reader.h"

namespace tremolo {
namespace {

using namespace basis_layout;

Result<std::vector<VertexId>> read_places(BasisReader& reader) {
  const auto ids = reader.indices(kResponseAt, std::uint64_t{kDefaultLoadPlace} + 1);
  if (!ids) return ids.error();
  const auto refuse = [](std::size_t i, const char* what) {
    return content_error("section 'response_at': place " + std::to_string(i) + " " + what);
  };
  std::vector<VertexId> places;
  for (std::size_t i = 0; i < ids->size(); ++i) {
    const std::uint32_t id = (*ids)[i];
    if (id == kDefaultLoadPlace) {
      if (i > 0) return refuse(i, "is that of the default load, which comes first");
      if (!reader.has(kLoadIds)) return refuse(i, "is that of a default load, which is not there");
      places.push_back(kAtDefaultLoad);
      continue;
    }
    if (id >= reader.dimensions().vertices) return refuse(i, "is no vertex");
    places.push_back(static_cast<VertexId>(id));
    if (i > 0 && places[i - 1] >= places[i]) return refuse(i, "does not ascend");
  }
  return places;
}

// 3 a vertex x 3p.
Result<BasisRows> read_response_rows(BasisReader& reader, std::string_view name,
                                     std::size_t places) {
  const auto values = reader.doubles(name);
  if (!values) return values.error();
  const Eigen::Index columns = 3 * places;
  return BasisRows(
      Eigen::Map<const BasisRows>(values->data(), std::ssize(*values) / columns, columns));
}

}  // namespace

Result<LocalResponse> read_response(BasisReader& reader) {
  LocalResponse response;
  if (!reader.has(kResponseAt)) return response;
  if (Status s = take(response.at, read_places(reader)); !s) return s.error();
  const std::size_t places = response.at.size();
  if (Status s = take(response.surface, read_response_rows(reader, kResponseSurface, places)); !s)
    return s.error();
  if (!reader.has(kRenderRest)) return response;
  if (Status s = take(response.render, read_response_rows(reader, kResponseRender, places)); !s)
    return s.error();
  return response;
}

Result<BasisRows> read_response_inside(BasisReader& reader) {
  const auto at = reader.indices(kResponseAt, std::uint64_t{kDefaultLoadPlace} + 1);
  if (!at) return at.error();
  return read_response_rows(reader, kResponseInterior, at->size());
}

}  // namespace tremolo
