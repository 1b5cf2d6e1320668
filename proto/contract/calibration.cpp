#include "proto/contract/calibration.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace granary {
namespace {

constexpr double kLongestMemory = 30;    // runs; older ones fade
constexpr double kShippedSpread = 0.55;  // of the logarithm, host to host: a factor of 3 at 95 %
constexpr double kLeastSpread = 0.1;     // scenes of one kind differ by that much at least
constexpr double kShippedWeight = 2;     // runs that the shipped spread counts for
constexpr double kTwoSided95 = 1.96;

bool is_plausible(const SpeedRatio& ratio) {
  return std::isfinite(ratio.runs) && std::isfinite(ratio.log_mean) &&
         std::isfinite(ratio.log_variance) && ratio.runs > 0 && ratio.log_variance >= 0 &&
         std::abs(ratio.log_mean) < 7;
}

}  // namespace

std::string Calibration::default_path() {
  if (const char* path = std::getenv("GRANARY_CALIBRATION")) return path;
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache != '\0')
    return std::string(cache) + "/granary/calibration";
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0')
    return std::string(home) + "/.cache/granary/calibration";
  return "";
}

Calibration Calibration::load(const std::string& path) {
  Calibration calibration;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string engine;
    SpeedRatio ratio;
    if (words >> engine >> ratio.runs >> ratio.log_mean >> ratio.log_variance &&
        is_plausible(ratio))
      calibration.ratios_[engine] = ratio;
  }
  return calibration;
}

const SpeedRatio* Calibration::find(const std::string& engine) const {
  const auto found = ratios_.find(engine);
  return found == ratios_.end() ? nullptr : &found->second;
}

// The shipped spread is worth kShippedWeight runs, so that two lucky runs do not promise too much.
double Calibration::log_half_width(const std::string& engine) const {
  const SpeedRatio* ratio = find(engine);
  if (ratio == nullptr) return kTwoSided95 * kShippedSpread;
  const double variance =
      (kShippedWeight * kShippedSpread * kShippedSpread + ratio->runs * ratio->log_variance) /
      (kShippedWeight + ratio->runs);
  const double spread = std::max(kLeastSpread, std::sqrt(variance * (1 + 1 / ratio->runs)));
  return kTwoSided95 * spread;
}

void Calibration::note(const std::string& engine, double measured_over_predicted) {
  if (!(measured_over_predicted > 0) || !std::isfinite(measured_over_predicted)) return;
  SpeedRatio& ratio = ratios_[engine];
  const double log_ratio = std::clamp(std::log(measured_over_predicted), -5.0, 5.0);
  const double runs = std::min(ratio.runs, kLongestMemory - 1);
  const double step = (log_ratio - ratio.log_mean) / (runs + 1);
  ratio.log_variance = (runs * ratio.log_variance + runs * (runs + 1) * step * step) / (runs + 1);
  ratio.log_mean += step;
  ratio.runs = runs + 1;
}

bool Calibration::save(const std::string& path) const {
  if (path.empty()) return false;
  std::error_code error;
  const std::filesystem::path target(path);
  std::filesystem::create_directories(target.parent_path(), error);
  const std::string temporary = path + "." + std::to_string(::getpid());
  {
    std::ofstream file(temporary);
    file.precision(10);
    for (const auto& [engine, ratio] : ratios_)
      file << engine << ' ' << ratio.runs << ' ' << ratio.log_mean << ' ' << ratio.log_variance
           << '\n';
    if (!file.flush()) return false;
  }
  std::filesystem::rename(temporary, target, error);
  if (!error) return true;
  std::filesystem::remove(temporary, error);
  return false;
}

}  // namespace granary
