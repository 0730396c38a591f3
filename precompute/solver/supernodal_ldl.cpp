#include "precompute/solver/supernodal_ldl.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/parallel.h"
#include "precompute/system/blas_threads.h"

extern "C" {
// BLAS, Fortran interface: B <- B op(A)^-1 for a triangular A on the right.
// NOLINTNEXTLINE(readability-identifier-naming)
void dtrsm_(const char* side, const char* uplo, const char* trans, const char* diag, const int* m,
            const int* n, const double* alpha, const double* a, const int* lda, double* b,
            const int* ldb);
// C <- alpha op(A) op(B) + beta C.
// NOLINTNEXTLINE(readability-identifier-naming)
void dgemm_(const char* trans_a, const char* trans_b, const int* m, const int* n, const int* k,
            const double* alpha, const double* a, const int* lda, const double* b, const int* ldb,
            const double* beta, double* c, const int* ldc);
}

namespace tremolo {
namespace {

constexpr double kOne = 1.0, kZero = 0.0, kMinusOne = -1.0;

// State of a left-looking factorisation: panels and lists of pending updates.
struct Factorisation {
  const Supernodes& f;
  const SparseRows& a;
  const int* order;
  std::vector<int> inverse_order;  // inverse of order
  std::vector<int> node_of;        // supernode of each column
  std::vector<int> parent;         // in the elimination tree; -1: root
  std::vector<int> first_pending,
      next_pending;           // linked lists, for each supernode, of panels that update it next
  std::vector<int> next_row;  // of each panel: its first row whose update is still pending
  double* values;

  int columns(int s) const { return f.first_column[s + 1] - f.first_column[s]; }
  int rows(int s) const { return f.first_row[s + 1] - f.first_row[s]; }
  const int* row(int s) const { return f.row + f.first_row[s]; }
  double* panel(int s) const { return values + f.panel[s]; }
};

// Buffers of one thread.
struct PanelScratch {
  std::vector<int> at;         // row of the factor -> row of the current panel
  std::vector<double> scaled;  // L D of the rows that are columns of the panel
  std::vector<double> product;
};

void assemble_panel(const Factorisation& w, int s, PanelScratch& scratch) {
  const int rows = w.rows(s), first = w.f.first_column[s];
  double* panel = w.panel(s);
  std::fill(panel, panel + static_cast<std::size_t>(rows) * w.columns(s), 0.0);
  for (int i = 0; i < rows; ++i) scratch.at[w.row(s)[i]] = i;
  for (int c = 0; c < w.columns(s); ++c) {
    double* column = panel + static_cast<std::size_t>(c) * rows;
    const int source = w.order[first + c];
    for (int at = w.a.start[source]; at < w.a.start[source + 1]; ++at) {
      const int row = w.inverse_order[w.a.column[at]];
      if (row >= first + c) column[scratch.at[row]] = w.a.value[at];
    }
  }
}

// Subtracts L_d D_d L_d^T from panel s, where the next rows of panel d are columns of s.
void update_from(const Factorisation& w, int s, int d, PanelScratch& scratch) {
  const int rows = w.rows(d), columns = w.columns(d), begin = w.next_row[d];
  const int* row = w.row(d);
  int end = begin;
  while (end < rows && row[end] < w.f.first_column[s + 1]) ++end;
  const int width = end - begin, depth = rows - begin;
  const double* source = w.panel(d) + begin;
  scratch.scaled.resize(static_cast<std::size_t>(width) * columns);
  scratch.product.resize(static_cast<std::size_t>(depth) * width);
  for (int k = 0; k < columns; ++k) {
    const double pivot = w.panel(d)[static_cast<std::size_t>(k) * rows + k];
    for (int i = 0; i < width; ++i)
      scratch.scaled[static_cast<std::size_t>(k) * width + i] =
          pivot * source[static_cast<std::size_t>(k) * rows + i];
  }
  dgemm_("N", "T", &depth, &width, &columns, &kOne, source, &rows, scratch.scaled.data(), &width,
         &kZero, scratch.product.data(), &depth);
  const int target_rows = w.rows(s);
  for (int c = 0; c < width; ++c) {
    double* target =
        w.panel(s) + static_cast<std::size_t>(row[begin + c] - w.f.first_column[s]) * target_rows;
    const double* from = scratch.product.data() + static_cast<std::size_t>(c) * depth;
    for (int i = c; i < depth; ++i) target[scratch.at[row[begin + i]]] -= from[i];
  }
}

// Computes L D L^T of a dense trapezoid in place, in blocks of columns.
void factorise_panel(double* panel, int rows, int columns, PanelScratch& scratch) {
  constexpr int kWidth = 48;
  const auto at = [&](int i, int c) -> double& {
    return panel[static_cast<std::size_t>(c) * rows + i];
  };
  for (int first = 0; first < columns; first += kWidth) {
    const int width = std::min(kWidth, columns - first), end = first + width;
    for (int c = first; c < end; ++c)
      for (int k = c + 1; k < end; ++k) {
        const double factor = at(k, c) / at(c, c);
        for (int i = k; i < end; ++i) at(i, k) -= at(i, c) * factor;
      }
    for (int c = first; c < end; ++c)
      for (int i = c + 1; i < end; ++i) at(i, c) /= at(c, c);
    const int below = rows - end, later = columns - end;
    if (below == 0) continue;
    dtrsm_("R", "L", "T", "U", &below, &width, &kOne, &at(first, first), &rows, &at(end, first),
           &rows);
    // The rows below the block now hold L D.
    scratch.scaled.resize(static_cast<std::size_t>(later) * width);
    for (int c = first; c < end; ++c) {
      const double pivot = at(c, c);
      for (int i = 0; i < later; ++i)
        scratch.scaled[static_cast<std::size_t>(c - first) * later + i] = at(end + i, c);
      for (int i = end; i < rows; ++i) at(i, c) /= pivot;
    }
    if (later > 0)
      dgemm_("N", "T", &below, &later, &width, &kMinusOne, &at(end, first), &rows,
             scratch.scaled.data(), &later, &kOne, &at(end, end), &rows);
  }
}

void compute_supernode(Factorisation& w, int s, PanelScratch& scratch) {
  assemble_panel(w, s, scratch);
  for (int d = w.first_pending[s]; d >= 0;) {
    const int next = w.next_pending[d];
    update_from(w, s, d, scratch);
    d = next;
  }
  factorise_panel(w.panel(s), w.rows(s), w.columns(s), scratch);
}

// Advances panel d past the columns of supernode `last` and returns the supernode it updates next;
// -1 if there is none.
int next_target(Factorisation& w, int d, int last) {
  while (w.next_row[d] < w.rows(d) && w.row(d)[w.next_row[d]] < w.f.first_column[last + 1])
    ++w.next_row[d];
  return w.next_row[d] < w.rows(d) ? w.node_of[w.row(d)[w.next_row[d]]] : -1;
}

// Computes supernodes first..last in order. Returns the panels whose next update is beyond `last`.
std::vector<int> compute_range(Factorisation& w, int first, int last, PanelScratch& scratch) {
  std::vector<int> outgoing;
  scratch.at.resize(w.node_of.size());
  const auto queue_update = [&](int d, int done) {
    const int next = next_target(w, d, done);
    if (next > last) outgoing.push_back(d);
    if (next < 0 || next > last) return;
    w.next_pending[d] = w.first_pending[next];
    w.first_pending[next] = d;
  };
  for (int s = first; s <= last; ++s) {
    compute_supernode(w, s, scratch);
    for (int d = w.first_pending[s]; d >= 0;) {
      const int next = w.next_pending[d];
      queue_update(d, s);
      d = next;
    }
    w.next_row[s] = w.columns(s);
    queue_update(s, s);
  }
  return outgoing;
}

// A range of the postorder that is one subtree. Subtrees are chosen small enough to balance the
// threads; the remaining supernodes form the top of the tree.
struct Range {
  int first, last;
};
std::vector<Range> independent_subtrees(const Factorisation& w) {
  const int count = static_cast<int>(w.f.count);
  std::vector<double> work(w.f.count, 0.0);
  std::vector<int> first(w.f.count);
  double total = 0;
  for (int s = 0; s < count; ++s) first[s] = s;
  for (int s = 0; s < count; ++s) {
    const double own = static_cast<double>(w.rows(s)) * w.rows(s) * w.columns(s);
    work[s] += own;
    total += own;
    if (w.parent[s] < 0) continue;
    work[w.parent[s]] += work[s];
    first[w.parent[s]] = std::min(first[w.parent[s]], first[s]);
  }
  // Largest share of the work in a subtree; each thread gets several, so that threads finish
  // together.
  constexpr double kShare = 1.0 / 16.0;
  std::vector<Range> ranges;
  for (int s = 0; s < count; ++s) {
    const bool small = work[s] <= kShare * total;
    const bool whole = w.parent[s] < 0 || work[w.parent[s]] > kShare * total;
    if (small && whole) ranges.push_back({first[s], s});
  }
  return ranges;
}

LdlReport examine(const Factorisation& w) {
  LdlReport report;
  std::vector<double> magnitude(w.node_of.size(), 0.0);
  for (int s = 0; s < static_cast<int>(w.f.count); ++s)
    for (int c = 0; c < w.columns(s); ++c) {
      const double* column = w.panel(s) + static_cast<std::size_t>(c) * w.rows(s);
      const double pivot = column[c];
      if (pivot < 0) ++report.negative;
      magnitude[w.row(s)[c]] += std::abs(pivot);
      for (int i = c + 1; i < w.rows(s); ++i)
        magnitude[w.row(s)[i]] += column[i] * column[i] * std::abs(pivot);
    }
  for (std::size_t i = 0; i < magnitude.size(); ++i) {
    const int source = w.order[i];
    double diagonal = 0;
    for (int at = w.a.start[source]; at < w.a.start[source + 1]; ++at)
      if (w.a.column[at] == source) diagonal = std::abs(w.a.value[at]);
    const double growth = magnitude[i] / diagonal;
    // NaN counts as infinite growth.
    if (!(growth <= report.growth)) report.growth = growth;
    if (std::isnan(growth)) report.growth = std::numeric_limits<double>::infinity();
  }
  return report;
}

Factorisation prepare(const Supernodes& pattern, const int* order, const SparseRows& a,
                      double* values) {
  const int count = static_cast<int>(pattern.count);
  const std::size_t size = a.rows;
  Factorisation w{pattern, a, order, {}, {}, {}, {}, {}, {}, values};
  w.inverse_order.resize(size);
  w.node_of.resize(size);
  for (std::size_t i = 0; i < size; ++i) w.inverse_order[order[i]] = static_cast<int>(i);
  for (int s = 0; s < count; ++s)
    std::fill(w.node_of.begin() + pattern.first_column[s],
              w.node_of.begin() + pattern.first_column[s + 1], s);
  for (int s = 0; s < count; ++s)
    w.parent.push_back(w.columns(s) < w.rows(s) ? w.node_of[w.row(s)[w.columns(s)]] : -1);
  w.first_pending.assign(pattern.count, -1);
  w.next_pending.assign(pattern.count, -1);
  w.next_row.assign(pattern.count, 0);
  return w;
}

// Queues panel d as one that updates supernode `next`; -1: it updates none any more.
void queue_update_of(Factorisation& w, int d, int next) {
  if (next < 0) return;
  w.next_pending[d] = w.first_pending[next];
  w.first_pending[next] = d;
}

// Computes independent subtrees in parallel and queues the panels that reach beyond theirs.
void compute_subtrees(Factorisation& w, const std::vector<Range>& ranges, unsigned threads) {
  std::vector<std::vector<int>> outgoing(ranges.size());
  const BlasThreads single(1);
  parallel_for(ranges.size(), threads, [&](std::size_t i) {
    PanelScratch scratch;
    outgoing[i] = compute_range(w, ranges[i].first, ranges[i].last, scratch);
  });
  for (const std::vector<int>& panels : outgoing)
    for (int d : panels) queue_update_of(w, d, w.node_of[w.row(d)[w.next_row[d]]]);
}

// Computes the supernodes above the subtrees in order; BLAS shares the large ones.
void compute_top(Factorisation& w, const std::vector<Range>& ranges, unsigned threads) {
  // Small panels are not worth sharing, since the threads would mostly wait for each other.
  constexpr int kWorthwhile = 1500;  // rows
  const BlasThreads shared(w.f.most_rows < kWorthwhile ? 1 : static_cast<int>(threads));
  PanelScratch scratch;
  scratch.at.resize(w.a.rows);
  std::size_t range = 0;
  for (int s = 0; s < static_cast<int>(w.f.count); ++s) {
    if (range < ranges.size() && s == ranges[range].first) {
      s = ranges[range++].last;
      continue;
    }
    compute_supernode(w, s, scratch);
    for (int d = w.first_pending[s]; d >= 0;) {
      const int after = w.next_pending[d];
      queue_update_of(w, d, next_target(w, d, s));
      d = after;
    }
    w.next_row[s] = w.columns(s);
    queue_update_of(w, s, next_target(w, s, s));
  }
}

}  // namespace

LdlReport factorise_ldl(const Supernodes& pattern, const int* order, const SparseRows& a,
                        double* values, unsigned threads) {
  Factorisation w = prepare(pattern, order, a, values);
  const std::vector<Range> ranges = independent_subtrees(w);
  compute_subtrees(w, ranges, threads);
  compute_top(w, ranges, threads);
  return examine(w);
}

}  // namespace tremolo
