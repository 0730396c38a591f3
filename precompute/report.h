// What a run prints when it is done.
#pragma once

#include "common/stage_log.h"
#include "precompute/pipeline.h"
#include "precompute/ranks/rank_table.h"

namespace tremolo {

// One object on stdout (docs/reference.md).
void print_json(const PrecomputeResult& result, const StageLog& log, const RankTable& ranks);

// Frequencies, and the step below which explicit methods are stable, on stderr.
void print_spectrum(const BasisData& data);

// Time and peak memory of all stages, and of each of several ranks, on stderr.
void print_total(const StageLog& log, const RankTable& ranks);

}  // namespace tremolo
