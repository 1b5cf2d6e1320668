#include "worker/dda/pair_search.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace granary::dda {
namespace {

// A torus narrower than four cells would make a cell its own neighbour.
constexpr std::uint32_t kFewestColumns = 4;
// Share of the disks that looks into adjacent cells only.
constexpr double kUsualShare = 0.85;
constexpr double kNoSpeed2 = 1e-30;  // m2/s2, instead of a division by zero
constexpr double kWide = std::numeric_limits<double>::quiet_NaN();  // is near to nothing

}  // namespace

// Smallest distance within half a horizon before and after, within the two reaches?
bool PairSearch::comes_near(const Path& a, const Path& b, double half_horizon) {
  const double dx = b.x - a.x, dy = b.y - a.y, reach = a.reach + b.reach;
  const double ux = b.vx - a.vx, uy = b.vy - a.vy;
  const double nearest = -(dx * ux + dy * uy) / (ux * ux + uy * uy + kNoSpeed2);
  const double until_end = nearest < half_horizon ? nearest : half_horizon;
  const double time = until_end > -half_horizon ? until_end : -half_horizon;
  const double x = dx + time * ux, y = dy + time * uy;
  return x * x + y * y < reach * reach;
}

std::uint32_t PairSearch::column_of(double x) const {
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(std::floor(x * inverse_cell_))) &
         (columns_ - 1);
}

std::uint32_t PairSearch::row_of(double y) const {
  return column_of(y) * columns_;
}

void PairSearch::choose_cells(std::span<const SearchDisk> disks) {
  spans_.resize(disks.size());
  for (std::size_t k = 0; k < disks.size(); ++k) spans_[k] = disks[k].reach + disks[k].sweep;
  const auto usual = spans_.begin() + static_cast<std::ptrdiff_t>(
                                          kUsualShare * static_cast<double>(disks.size() - 1));
  std::nth_element(spans_.begin(), usual, spans_.end());
  base_span_ = *usual;
  inverse_cell_ = 1 / (2 * base_span_);
  const auto side = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(disks.size())));
  columns_ = std::max(kFewestColumns, std::bit_ceil(side));
}

void PairSearch::sort_into_cells(std::span<const SearchDisk> disks) {
  start_.assign(columns_ * columns_ + 1, 0);
  cell_of_.resize(disks.size());
  for (std::size_t k = 0; k < disks.size(); ++k) {
    cell_of_[k] = row_of(disks[k].y) + column_of(disks[k].x);
    ++start_[cell_of_[k] + 1];
  }
  for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
  sorted_.resize(disks.size());
  path_.resize(disks.size());
  sorted_cell_.resize(disks.size());
  // Counting down from the end of each cell keeps the order of the input; start_[c + 1] ends up as
  // the start of cell c.
  for (std::size_t k = disks.size(); k-- > 0;) {
    const SearchDisk& d = disks[k];
    const double span = d.reach + d.sweep;
    const std::uint32_t place = --start_[cell_of_[k] + 1];
    sorted_[place] = {d.x, d.y, span, span > base_span_ ? kWide : span};
    path_[place] = {d.x, d.y, d.vx, d.vy, d.reach, d.index};
    sorted_cell_[place] = cell_of_[k];
  }
  std::rotate(start_.begin(), start_.begin() + 1, start_.end());
  start_.back() = static_cast<std::uint32_t>(disks.size());
}

// Pairs of `one` with those of [begin, end) that it has to find: usual ones with each other in the
// order of the cells; a wide one with all usual ones and with less wide ones. Without branches: half
// of those that are looked at are near.
template <bool kIsWide>
void PairSearch::look_into(std::size_t one, std::size_t begin, std::size_t end) {
  const Sorted a = sorted_[one];
  if (near_.size() < near_count_ + (end - begin)) near_.resize(2 * near_.size() + (end - begin));
  DiskPair* out = near_.data();
  std::size_t count = near_count_;
  for (std::size_t k = begin; k < end; ++k) {
    const Sorted& b = sorted_[k];
    const bool narrower = kIsWide && ((b.span < a.span) | ((b.span == a.span) & (k < one)));
    const double dx = b.x - a.x, dy = b.y - a.y;
    const double span = a.span + (narrower ? b.span : b.usual_span);
    out[count] = {static_cast<std::int32_t>(one), static_cast<std::int32_t>(k)};
    count += dx * dx + dy * dy < span * span;
  }
  near_count_ = count;
}

void PairSearch::look_around(std::size_t one) {
  const std::uint32_t cell = sorted_cell_[one];
  const std::uint32_t column = cell & (columns_ - 1), row = cell - column;
  const std::uint32_t east = (column + 1) & (columns_ - 1), west = (column - 1) & (columns_ - 1);
  const std::uint32_t above = (row + columns_) & (columns_ * columns_ - 1);
  if (west < east) {  // the three columns are next to each other in memory
    look_into<false>(one, one + 1, start_[row + east + 1]);
    look_into<false>(one, start_[above + west], start_[above + east + 1]);
    return;
  }
  look_into<false>(one, one + 1, start_[cell + 1]);
  look_into<false>(one, start_[row + east], start_[row + east + 1]);
  for (const std::uint32_t c : {west, column, east})
    look_into<false>(one, start_[above + c], start_[above + c + 1]);
}

void PairSearch::look_far(std::size_t one) {
  const Sorted& a = sorted_[one];
  const double range = 2 * a.span;
  const auto cells = static_cast<std::uint32_t>(2 * range * inverse_cell_) + 2;
  const std::uint32_t across = std::min(cells, columns_);
  const std::uint32_t first_column = column_of(a.x - range), first_row = column_of(a.y - range);
  for (std::uint32_t r = 0; r < across; ++r) {
    const std::uint32_t row = ((first_row + r) & (columns_ - 1)) * columns_;
    const std::uint32_t last = first_column + across;  // may run over the seam of the torus
    look_into<true>(one, start_[row + first_column], start_[row + std::min(last, columns_)]);
    if (last > columns_) look_into<true>(one, start_[row], start_[row + last - columns_]);
  }
}

void PairSearch::find(std::span<const SearchDisk> disks, double horizon,
                      std::vector<DiskPair>& pairs) {
  pairs.clear();
  near_count_ = 0;
  if (disks.empty()) return;
  choose_cells(disks);
  sort_into_cells(disks);
  for (std::size_t k = 0; k < sorted_.size(); ++k)
    std::isnan(sorted_[k].usual_span) ? look_far(k) : look_around(k);
  pairs.resize(near_count_);
  std::size_t count = 0;
  for (std::size_t p = 0; p < near_count_; ++p) {
    const Path& a = path_[static_cast<std::size_t>(near_[p].first)];
    const Path& b = path_[static_cast<std::size_t>(near_[p].second)];
    pairs[count] = {std::min(a.index, b.index), std::max(a.index, b.index)};
    count += comes_near(a, b, horizon / 2);
  }
  pairs.resize(count);
}

}  // namespace granary::dda
