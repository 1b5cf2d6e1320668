#include "tests/physics/papers/chute_means.h"

#include <cmath>
#include <ctime>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "worker/scene/chute.h"

namespace granary::tests {
namespace {

constexpr double kHalfWindow = 0.015 + 1e-9;  // five cells of 6 mm
constexpr double kHalfSensor = 0.0125;        // five cells of 5 mm

double cpu_now() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

std::span<const double> column(const core::Table& table, const std::string& name) {
  for (const core::Column& c : table.columns) {
    if (c.name == name) return c.as<double>();
  }
  throw std::runtime_error(table.name + " has no column " + name);
}

}  // namespace

ChuteMeans ChuteMeans::of_run(const v1::Scene& resolved) {
  const double start = cpu_now();
  const auto simulation = scene::make_chute(resolved);
  const auto outcome =
      simulation->advance(resolved.chute().duration_s(), std::numeric_limits<std::uint64_t>::max());
  if (outcome.status != core::AdvanceStatus::finished) {
    throw std::runtime_error(resolved.name() + ": " +
                             (outcome.rejection ? outcome.rejection->reason : "not finished"));
  }
  ChuteMeans means;
  means.observation_ = simulation->observe();
  means.particle_steps_ = static_cast<double>(simulation->progress().particle_steps);
  means.ledger_remainder_ = simulation->ledger().remainder_ratio();
  means.cpu_seconds_ = cpu_now() - start;
  return means;
}

Mean ChuteMeans::value(const std::string& name) const {
  for (const core::ObservedValue& v : observation_.values) {
    if (v.name == name) return {v.value.value_or(std::nan("")), v.error.value_or(0)};
  }
  throw std::runtime_error("no value " + name);
}

const core::Table& ChuteMeans::field(const std::string& name) const {
  for (const core::Table& table : observation_.fields) {
    if (table.name == name) return table;
  }
  throw std::runtime_error("no field " + name);
}

double ChuteMeans::mean_over_cells(const std::string& name, double x, double low_y,
                                   double high_y) const {
  const core::Table& table = field("surface_velocity");
  const auto xs = column(table, "x_m"), ys = column(table, "y_m"), values = column(table, name);
  double sum = 0, cells = 0;
  for (std::size_t k = 0; k < xs.size(); ++k) {
    if (std::abs(xs[k] - x) > kHalfWindow || ys[k] < low_y || ys[k] >= high_y) continue;
    sum += values[k];
    ++cells;
  }
  return sum / cells;
}

double ChuteMeans::surface_velocity(double x, double low_y, double high_y) const {
  return mean_over_cells("streamwise_m_per_s", x, low_y, high_y);
}

double ChuteMeans::spanwise_velocity(double x, double low_y, double high_y) const {
  return mean_over_cells("spanwise_m_per_s", x, low_y, high_y);
}

double ChuteMeans::bed_height(double x, double y) const {
  const core::Table& table = field("bed_height");
  const auto xs = column(table, "x_m"), ys = column(table, "y_m");
  const auto height = column(table, "height_m");
  double sum = 0, cells = 0;
  for (std::size_t k = 0; k < xs.size(); ++k) {
    if (std::abs(xs[k] - x) > kHalfWindow || std::abs(ys[k] - y) > kHalfSensor) continue;
    sum += height[k];
    ++cells;
  }
  return sum / cells;
}

std::vector<ChuteMeans::DepthBin> ChuteMeans::depth_profile() const {
  const core::Table& table = field("depth_profile");
  const auto x = column(table, "x_m"), height = column(table, "height_m");
  const auto speed = column(table, "streamwise_m_per_s"), solid = column(table, "solid_fraction");
  std::vector<DepthBin> bins;
  for (std::size_t k = 0; k < x.size(); ++k) {
    bins.push_back({x[k], height[k], speed[k], solid[k]});
  }
  return bins;
}

std::vector<CsvRow> read_csv(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  const auto cells = [](const std::string& line) {
    std::vector<std::string> parts;
    std::stringstream in(line.substr(0, line.find_last_not_of('\r') + 1));
    for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
    return parts;
  };
  std::string line;
  std::getline(file, line);
  const std::vector<std::string> names = cells(line);
  std::vector<CsvRow> rows;
  while (std::getline(file, line)) {
    CsvRow row;
    const std::vector<std::string> values = cells(line);
    for (std::size_t k = 0; k < names.size() && k < values.size(); ++k) {
      char* end = nullptr;
      const double number = std::strtod(values[k].c_str(), &end);
      row[names[k]] = end == values[k].c_str() ? std::nan("") : number;
    }
    rows.push_back(row);
  }
  return rows;
}

}  // namespace granary::tests
