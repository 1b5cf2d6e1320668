#include "worker/run/progress_line.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>

namespace granary::run {
namespace {

constexpr int kBarCells = 24;
constexpr double kPlainLineShare = 0.1;

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  char text[256];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

std::string bar(double fraction) {
  const int filled = static_cast<int>(std::lround(fraction * kBarCells));
  return "[" + std::string(filled, '#') + std::string(kBarCells - filled, '.') + "]";
}

}  // namespace

std::string duration_text(double seconds) {
  if (seconds < 60) return format("%.1f s", seconds);
  const long whole = std::lround(seconds);
  if (whole < 3600) return format("%ld min %02ld s", whole / 60, whole % 60);
  return format("%ld h %02ld min", whole / 3600, whole % 3600 / 60);
}

std::string progress_text(const v1::Progress& progress) {
  std::string text = bar(std::clamp(progress.fraction(), 0.0, 1.0));
  text += format(" %3.0f %%  %s", 100 * progress.fraction(), progress.phase().c_str());
  if (progress.time_s() >= 0) text += format(" t = %.3g", progress.time_s());
  if (progress.time_s() >= 0 && progress.time_s() <= progress.end_time_s())
    text += format(" of %.3g", progress.end_time_s());
  if (progress.time_s() >= 0) text += " s";
  text += format("  %llu particles, %llu contacts",
                 static_cast<unsigned long long>(progress.particles()),
                 static_cast<unsigned long long>(progress.contacts()));
  if (progress.ns_per_particle_step() > 0)
    text += format("  %.3g ns/particle-step", progress.ns_per_particle_step());
  if (progress.replicates() > 1)
    text += format("  replicate %u of %u", progress.replicate() + 1, progress.replicates());
  if (progress.eta_s() > 0) text += "  " + duration_text(progress.eta_s()) + " left";
  return text;
}

ProgressLine::ProgressLine(bool enabled)
    : enabled_(enabled), terminal_(isatty(STDERR_FILENO) == 1) {}

void ProgressLine::show(const v1::Progress& progress) {
  if (!enabled_) return;
  const std::string text = progress_text(progress);
  if (terminal_) {
    const std::string padding(width_ > text.size() ? width_ - text.size() : 0, ' ');
    std::cerr << '\r' << text << padding << std::flush;
    width_ = text.size();
  } else if (progress.fraction() >= next_fraction_) {
    std::cerr << text << '\n';
    next_fraction_ = (std::floor(progress.fraction() / kPlainLineShare) + 1) * kPlainLineShare;
  }
}

void ProgressLine::log(const std::string& line) {
  end();
  std::cerr << line << '\n';
}

void ProgressLine::end() {
  if (width_ > 0) std::cerr << '\n';
  width_ = 0;
}

}  // namespace granary::run
