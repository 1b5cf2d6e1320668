#include "worker/measure/chute_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace granary::measure {
namespace {

// The highest grains of one cell, highest first.
struct TopGrains {
  struct Entry {
    double top, streamwise, spanwise;
  };
  std::array<Entry, ChuteSurface::kTopGrains> entries;
  std::size_t kept = 0;

  void offer(const Entry& entry) {
    if (kept == entries.size()) {
      if (entry.top <= entries[kept - 1].top) return;
      --kept;
    }
    std::size_t place = kept++;
    for (; place > 0 && entries[place - 1].top < entry.top; --place) {
      entries[place] = entries[place - 1];
    }
    entries[place] = entry;
  }
};

ChuteSurface::Cell cell_of(const TopGrains& top) {
  ChuteSurface::Cell cell;
  if (top.kept == 0) return cell;
  cell.height = top.entries[0].top;
  cell.has_velocity = top.kept >= ChuteSurface::kFewestGrains;
  if (!cell.has_velocity) return cell;
  for (std::size_t k = 0; k < top.kept; ++k) {
    cell.streamwise += top.entries[k].streamwise;
    cell.spanwise += top.entries[k].spanwise;
  }
  cell.streamwise /= static_cast<double>(top.kept);
  cell.spanwise /= static_cast<double>(top.kept);
  return cell;
}

std::size_t cells_over(double extent, double size) {
  return static_cast<std::size_t>(std::max(1.0, std::ceil(extent / size - 1e-9)));
}

}  // namespace

ChuteSurface::ChuteSurface(double length, double width)
    : along_(cells_over(length, kCellLength)),
      across_(cells_over(width, kCellWidth)),
      length_(length),
      width_(width),
      frame_(along_ * across_),
      height_sum_(frame_.size()),
      streamwise_sum_(frame_.size()),
      spanwise_sum_(frame_.size()),
      velocity_frames_(frame_.size()) {}

void ChuteSurface::look(const dem::GrainTable& grains) {
  std::vector<TopGrains> tops(frame_.size());
  for (std::size_t k = 0; k < grains.size(); ++k) {
    const core::Vec3& p = grains.position[k];
    if (grains.carried[k] || p.x < 0 || p.x >= length_ || p.y < 0 || p.y >= width_) continue;
    const auto ix = static_cast<std::size_t>(p.x / kCellLength);
    const auto iy = static_cast<std::size_t>(p.y / kCellWidth);
    tops[index(ix, iy)].offer(
        {p.z + grains.radius[k], grains.velocity[k].x, grains.velocity[k].y});
  }
  std::transform(tops.begin(), tops.end(), frame_.begin(), cell_of);
}

void ChuteSurface::accumulate() {
  ++frames_;
  for (std::size_t k = 0; k < frame_.size(); ++k) {
    height_sum_[k] += frame_[k].height;
    if (!frame_[k].has_velocity) continue;
    streamwise_sum_[k] += frame_[k].streamwise;
    spanwise_sum_[k] += frame_[k].spanwise;
    ++velocity_frames_[k];
  }
}

ChuteSurface::Cell ChuteSurface::mean_cell(std::size_t cell) const {
  Cell mean;
  if (frames_ > 0) mean.height = height_sum_[cell] / static_cast<double>(frames_);
  mean.has_velocity = velocity_frames_[cell] > 0;
  if (!mean.has_velocity) return mean;
  const auto count = static_cast<double>(velocity_frames_[cell]);
  mean.streamwise = streamwise_sum_[cell] / count;
  mean.spanwise = spanwise_sum_[cell] / count;
  return mean;
}

// The five cells whose middle one holds the point; fewer at the ends.
ChuteSurface::Range ChuteSurface::five_along(double x) const {
  const auto middle = static_cast<std::ptrdiff_t>(x / kCellLength);
  return {static_cast<std::size_t>(std::max<std::ptrdiff_t>(middle - 2, 0)),
          std::min(static_cast<std::size_t>(middle + 3), along_)};
}

ChuteSurface::Range ChuteSurface::five_across(double y) const {
  const auto middle = static_cast<std::ptrdiff_t>(y / kCellWidth);
  return {static_cast<std::size_t>(std::max<std::ptrdiff_t>(middle - 2, 0)),
          std::min(static_cast<std::size_t>(middle + 3), across_)};
}

template <typename CellAt>
double ChuteSurface::streamwise_over(double x, CellAt cell_at) const {
  double sum = 0;
  std::size_t count = 0;
  const Range along = five_along(x);
  for (std::size_t ix = along.first; ix < along.end; ++ix) {
    for (std::size_t iy = 0; iy < across_; ++iy) {
      const Cell cell = cell_at(index(ix, iy));
      if (!cell.has_velocity) continue;
      sum += cell.streamwise;
      ++count;
    }
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

template <typename CellAt>
double ChuteSurface::height_over(double x, double y, CellAt cell_at) const {
  double sum = 0;
  std::size_t count = 0;
  const Range along = five_along(x);
  const Range across = five_across(y);
  for (std::size_t ix = along.first; ix < along.end; ++ix) {
    for (std::size_t iy = across.first; iy < across.end; ++iy) {
      sum += cell_at(index(ix, iy)).height;
      ++count;
    }
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

double ChuteSurface::streamwise_at(double x) const {
  return streamwise_over(x, [&](std::size_t cell) { return frame_[cell]; });
}

double ChuteSurface::sensor_height(double x, double y) const {
  return height_over(x, y, [&](std::size_t cell) { return frame_[cell]; });
}

double ChuteSurface::mean_streamwise_at(double x) const {
  return streamwise_over(x, [&](std::size_t cell) { return mean_cell(cell); });
}

double ChuteSurface::mean_sensor_height(double x, double y) const {
  return height_over(x, y, [&](std::size_t cell) { return mean_cell(cell); });
}

core::Table ChuteSurface::velocity_table() const {
  std::vector<double> x, y, u, v;
  for (std::size_t ix = 0; ix < along_; ++ix) {
    for (std::size_t iy = 0; iy < across_; ++iy) {
      const Cell mean = mean_cell(index(ix, iy));
      if (!mean.has_velocity) continue;
      x.push_back((static_cast<double>(ix) + 0.5) * kCellLength);
      y.push_back((static_cast<double>(iy) + 0.5) * kCellWidth);
      u.push_back(mean.streamwise);
      v.push_back(mean.spanwise);
    }
  }
  return {"surface_velocity",
          {core::make_column<double>("x_m", "m", x), core::make_column<double>("y_m", "m", y),
           core::make_column<double>("streamwise_m_per_s", "m/s", u),
           core::make_column<double>("spanwise_m_per_s", "m/s", v)}};
}

core::Table ChuteSurface::height_table() const {
  std::vector<double> x, y, height;
  for (std::size_t ix = 0; frames_ > 0 && ix < along_; ++ix) {
    for (std::size_t iy = 0; iy < across_; ++iy) {
      x.push_back((static_cast<double>(ix) + 0.5) * kCellLength);
      y.push_back((static_cast<double>(iy) + 0.5) * kCellWidth);
      height.push_back(mean_cell(index(ix, iy)).height);
    }
  }
  return {"bed_height",
          {core::make_column<double>("x_m", "m", x), core::make_column<double>("y_m", "m", y),
           core::make_column<double>("height_m", "m", height)}};
}

core::Table ChuteSurface::spanwise_table(const std::vector<double>& stations) const {
  std::vector<double> x, y, u, v;
  for (const double station : stations) {
    const Range along = five_along(station);
    for (std::size_t iy = 0; iy < across_; ++iy) {
      double streamwise = 0;
      double spanwise = 0;
      double count = 0;
      for (std::size_t ix = along.first; ix < along.end; ++ix) {
        const Cell mean = mean_cell(index(ix, iy));
        if (!mean.has_velocity) continue;
        streamwise += mean.streamwise;
        spanwise += mean.spanwise;
        ++count;
      }
      if (count == 0) continue;
      x.push_back(station);
      y.push_back((static_cast<double>(iy) + 0.5) * kCellWidth);
      u.push_back(streamwise / count);
      v.push_back(spanwise / count);
    }
  }
  return {"spanwise_profile",
          {core::make_column<double>("x_m", "m", x), core::make_column<double>("y_m", "m", y),
           core::make_column<double>("streamwise_m_per_s", "m/s", u),
           core::make_column<double>("spanwise_m_per_s", "m/s", v)}};
}

void ChuteSurface::save(core::State& state) const {
  state.put_scalar("surface.frames", "1", frames_);
  state.put("surface.height_sum_m", "m", height_sum_);
  state.put("surface.streamwise_sum_m_per_s", "m/s", streamwise_sum_);
  state.put("surface.spanwise_sum_m_per_s", "m/s", spanwise_sum_);
  state.put("surface.velocity_frames", "1", velocity_frames_);
}

void ChuteSurface::load(const core::State& state) {
  const auto height = state.get<double>("surface.height_sum_m");
  if (height.size() != frame_.size()) throw std::runtime_error("state: surface of another chute");
  height_sum_ = height;
  frames_ = state.get_scalar<std::uint64_t>("surface.frames");
  streamwise_sum_ = state.get<double>("surface.streamwise_sum_m_per_s");
  spanwise_sum_ = state.get<double>("surface.spanwise_sum_m_per_s");
  velocity_frames_ = state.get<std::uint64_t>("surface.velocity_frames");
}

}  // namespace granary::measure
