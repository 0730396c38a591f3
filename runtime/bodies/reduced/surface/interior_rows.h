// Rows of the vertices inside a solid, in memory or read from a file on demand.
#pragma once

#include <memory>
#include <mutex>
#include <optional>

#include "common/result.h"
#include "formats/basis/basis_data.h"
#include "formats/basis/basis_reader.h"

namespace tremolo {

// The leading `modes` columns of a block, after a check of its shape: `name` is for errors.
// kContent if sizes differ, ids do not ascend or a value is not finite.
Result<VertexBlock> leading_columns(const VertexBlock& block, Eigen::Index modes, const char* name);

// An open file, of which more is read on demand.
struct OpenBasis {
  std::mutex mutex;  // of the reader
  BasisReader reader;
};

class InteriorRows {
 public:
  // response: as in LocalResponse; no columns if there is none.
  InteriorRows(VertexBlock block, BasisRows response)
      : block_(std::move(block)), response_(std::move(response)) {}
  InteriorRows(std::shared_ptr<OpenBasis> file, Eigen::Index modes)
      : file_(std::move(file)), modes_(modes) {}

  // The block, read on first use. Thread-safe; the reference stays valid as long as the object.
  Result<const VertexBlock*> block();
  // The rows of W, read and kept in the same way.
  Result<const BasisRows*> response();

 private:
  std::mutex mutex_;
  std::shared_ptr<OpenBasis> file_;  // gone once the block is there
  Eigen::Index modes_ = 0;
  std::optional<VertexBlock> block_;
  BasisRows response_;
};

}  // namespace tremolo
