// What an optimization wants, applied to one result: Eq. 12 of the bucket-elevator paper, with
// weights over any values and constraints on any values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "granary/v1/result.pb.h"
#include "granary/v1/study.pb.h"

namespace granary::server {

// One run seen through the objective. `terms` are the raw values, in the order of the spec.
struct Reading {
  std::vector<double> terms;
  std::vector<double> errors;  // half-widths of the 95 % intervals; NaN = unknown
  double violation = 0;        // sum over the constraints of how far they are missed, relative
};

class Objective {
 public:
  explicit Objective(const v1::Optimize& settings) : settings_(settings) {}

  // Nothing when a value that is asked for is unknown: such a run counts as failed.
  std::optional<Reading> read(const v1::Result& result) const;

  // Terms are divided by what they are at x0, at least their floor. Without this call: as they are.
  void set_scale(const Reading& at_start);
  bool has_scale() const { return !scale_.empty(); }
  const std::vector<double>& scale() const { return scale_; }
  void restore_scale(std::vector<double> scale) { scale_ = std::move(scale); }

  // sum of +-weight x term / scale; larger is better.
  double merit(const std::vector<double>& terms) const;
  // Each term by itself, larger is better: what a Pareto front compares.
  std::vector<double> directed(const std::vector<double>& terms) const;
  // Half-width of the 95 % interval of the merit, from independent errors of its terms.
  std::optional<double> merit_error(const std::vector<double>& errors) const;

  std::size_t size() const { return static_cast<std::size_t>(settings_.objective_size()); }

 private:
  double factor(std::size_t term) const;  // +-weight / scale

  v1::Optimize settings_;
  std::vector<double> scale_;
};

}  // namespace granary::server
