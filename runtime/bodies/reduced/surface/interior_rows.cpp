#include "runtime/bodies/reduced/surface/interior_rows.h"

#include <string>
#include <utility>

namespace tremolo {

Result<VertexBlock> leading_columns(const VertexBlock& block, Eigen::Index modes,
                                    const char* name) {
  const auto bad = [name](const std::string& what) {
    return content_error(std::string("the ") + name + " vertices: " + what);
  };
  const std::size_t count = block.vertex_ids.size();
  if (block.rest.size() != count || block.rows.rows() != static_cast<Eigen::Index>(3 * count) ||
      (count > 0 && block.rows.cols() < modes))
    return bad("ids, rest positions and basis rows differ in size");
  for (std::size_t v = 0; v < count; ++v) {
    if (block.vertex_ids[v] < 0 || (v > 0 && block.vertex_ids[v] <= block.vertex_ids[v - 1]))
      return bad("id " + std::to_string(block.vertex_ids[v]) + " does not ascend");
    if (!block.rest[v].allFinite())
      return bad("the rest position of " + std::to_string(block.vertex_ids[v]) + " is not finite");
  }
  VertexBlock leading{block.vertex_ids, block.rest, BasisRows(block.rows.rows(), modes), {}};
  if (block.column_scales.size() >= modes) leading.column_scales = block.column_scales.head(modes);
  if (count > 0) leading.rows = block.rows.leftCols(modes);
  if (!leading.rows.allFinite()) return bad("a basis row is not finite");
  return leading;
}

Result<const VertexBlock*> InteriorRows::block() {
  const std::scoped_lock lock(mutex_);
  if (!block_) {
    const std::scoped_lock reading(file_->mutex);
    BasisReader& reader = file_->reader;
    if (!reader.has(basis_layout::kInteriorIds)) {
      block_.emplace();
    } else {
      const Result<VertexBlock> all = reader.vertex_block(
          basis_layout::kInteriorIds, basis_layout::kInteriorRest, basis_layout::kInteriorBasis);
      if (!all) return all.error();
      Result<VertexBlock> leading = leading_columns(*all, modes_, "interior");
      if (!leading) return leading.error();
      if (reader.has(basis_layout::kResponseAt))
        if (Status s = take(response_, read_response_inside(reader)); !s) return s.error();
      block_ = std::move(*leading);
    }
  }
  file_.reset();
  return &*block_;
}

Result<const BasisRows*> InteriorRows::response() {
  if (const auto there = block(); !there) return there.error();
  return &response_;
}

}  // namespace tremolo
