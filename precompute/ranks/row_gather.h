// The basis on its way to the file: rows lie with the ranks whose nodes they belong to, rank 0
// writes, and no rank ever holds them all.
#pragma once

#include "formats/basis/basis_writer.h"
#include "precompute/embedding/embedding.h"
#include "precompute/fem/dof_map.h"

namespace tremolo {

// rows: of the part's vertices, 3 a vertex x r (expand_to_vertices). Borrowed, all of it.
struct SpreadBasis {
  const TetMesh& mesh;  // the whole one
  const Embedding& embedding;
  const DofMap& map;
  const LocalDofs& local;
  const BasisRows& rows;
};

// On rank 0: where the writer gets the rows of data's blocks from. Meanwhile all other ranks are in
// serve_rows(). data: ids of the blocks' vertices, the same on all ranks.
RowSources gathered_rows(const SpreadBasis& basis, const BasisData& data);
void serve_rows(const SpreadBasis& basis, const BasisData& data);

// All of them after all, into the blocks of rank 0's data: for those who need to see them at once.
// All ranks call it together.
void collect_rows(const SpreadBasis& basis, BasisData& data);

}  // namespace tremolo
