#include "server/studies/objective.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace granary::server {
namespace {

double sign_of(const v1::Optimize::Term& term) {
  return term.goal() == v1::Optimize::MINIMISE ? -1 : 1;
}

// How far a bound is missed, relative to the bound: 0.90 against >= 0.95 is 0.053.
double missed(double by, double bound) {
  return by <= 0 ? 0 : by / std::max(std::abs(bound), 1e-9);
}

}  // namespace

std::optional<Reading> Objective::read(const v1::Result& result) const {
  Reading reading;
  const auto find = [&](const std::string& name) -> const v1::Quantity* {
    const auto found = result.values().find(name);
    return found == result.values().end() || !found->second.has_value() ? nullptr : &found->second;
  };
  for (const v1::Optimize::Term& term : settings_.objective()) {
    const v1::Quantity* quantity = find(term.value());
    if (quantity == nullptr) return {};
    reading.terms.push_back(quantity->value());
    reading.errors.push_back(quantity->has_error() ? quantity->error()
                                                   : std::numeric_limits<double>::quiet_NaN());
  }
  for (const v1::Optimize::Constraint& constraint : settings_.constraint()) {
    const v1::Quantity* quantity = find(constraint.value());
    if (quantity == nullptr) return {};
    if (constraint.has_minimum())
      reading.violation += missed(constraint.minimum() - quantity->value(), constraint.minimum());
    if (constraint.has_maximum())
      reading.violation += missed(quantity->value() - constraint.maximum(), constraint.maximum());
  }
  return reading;
}

void Objective::set_scale(const Reading& at_start) {
  scale_.clear();
  for (std::size_t i = 0; i < size(); ++i) {
    const v1::Optimize::Term& term = settings_.objective(static_cast<int>(i));
    const bool normalise = !term.has_normalise() || term.normalise();
    const double scale = std::max(std::abs(at_start.terms[i]), term.floor());
    scale_.push_back(normalise && scale > 0 ? scale : 1);
  }
}

double Objective::factor(std::size_t i) const {
  const v1::Optimize::Term& term = settings_.objective(static_cast<int>(i));
  const double weight = term.has_weight() ? term.weight() : 1;
  return sign_of(term) * weight / (scale_.empty() ? 1 : scale_[i]);
}

double Objective::merit(const std::vector<double>& terms) const {
  double sum = 0;
  for (std::size_t i = 0; i < size(); ++i) sum += factor(i) * terms[i];
  return sum;
}

std::vector<double> Objective::directed(const std::vector<double>& terms) const {
  std::vector<double> out(terms);
  for (std::size_t i = 0; i < size(); ++i)
    out[i] *= sign_of(settings_.objective(static_cast<int>(i))) / (scale_.empty() ? 1 : scale_[i]);
  return out;
}

std::optional<double> Objective::merit_error(const std::vector<double>& errors) const {
  double squares = 0;
  for (std::size_t i = 0; i < size(); ++i) {
    if (factor(i) == 0) continue;
    if (std::isnan(errors[i])) return {};
    squares += factor(i) * errors[i] * factor(i) * errors[i];
  }
  return std::sqrt(squares);
}

}  // namespace granary::server
