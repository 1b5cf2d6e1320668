#include "server/studies/gradual_deformation.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <numbers>

namespace granary::server {
namespace {

using nlohmann::json;

constexpr std::uint32_t kDefaultLineEvaluations = 6;  // narrows the bracket to 0.618^5 = 9 %
// Keeps the normal variable of a coordinate on the edge of the box finite.
constexpr double kEdge = 1e-6;

double to_normal(double share) {
  return boost::math::quantile(boost::math::normal(), std::clamp(share, kEdge, 1 - kEdge));
}
double from_normal(double normal) {
  return boost::math::cdf(boost::math::normal(), normal);
}

json optional_json(const std::optional<double>& value) {
  return value ? json(*value) : json(nullptr);
}
std::optional<double> optional_from(const json& value) {
  return value.is_null() ? std::nullopt : std::optional(value.get<double>());
}

}  // namespace

GradualDeformation::GradualDeformation(const v1::Optimize::GradualDeformation& settings,
                                       const SearchSetup& setup)
    : mixing_(settings.mixing()),
      line_evaluations_(settings.has_line_evaluations() ? settings.line_evaluations()
                                                        : kDefaultLineEvaluations),
      parallel_(std::max(settings.parallel(), 1u)),
      random_(setup.seed),
      present_(setup.start) {
  begin_line();
}

Point GradualDeformation::draw() {
  Point point(present_.size());
  for (double& coordinate : point) coordinate = random_.uniform();
  return point;
}

void GradualDeformation::begin_line() {
  end_ = draw();
  end_merit_.reset();
  line_.clear();
  bracket_ = golden_section(mixing_ == v1::Optimize::GradualDeformation::GAUSSIAN ? -1 : 0, 1);
}

// t = 0 is the present point, t = 1 the random one (the paper counts the other way round).
Point GradualDeformation::mixture(double t) const {
  Point point(present_.size());
  const double cosine = std::cos(std::numbers::pi / 2 * t),
               sine = std::sin(std::numbers::pi / 2 * t);
  for (std::size_t i = 0; i < point.size(); ++i)
    point[i] = mixing_ == v1::Optimize::GradualDeformation::GAUSSIAN
                   ? from_normal(to_normal(present_[i]) * cosine + to_normal(end_[i]) * sine)
                   : (1 - t) * present_[i] + t * end_[i];
  return point;
}

std::vector<Point> GradualDeformation::next_batch() {
  std::vector<Point> batch;
  if (!present_merit_) batch.push_back(present_);
  if (!end_merit_ && batch.size() < parallel_) batch.push_back(end_);
  const std::size_t room = std::min(parallel_ - batch.size(), line_evaluations_ - line_.size());
  asked_ = room > 0 ? next_points(bracket_, line_, room) : std::vector<double>{};
  for (const double t : asked_) batch.push_back(mixture(t));
  return batch;
}

void GradualDeformation::take(const std::vector<Scored>& batch) {
  std::size_t next = 0;
  const std::size_t ends = batch.size() - asked_.size();
  if (!present_merit_ && next < ends) present_merit_ = batch[next++].merit;
  if (!end_merit_ && next < ends) end_merit_ = batch[next++].merit;
  for (const double t : asked_) line_[t] = batch[next++].merit;
  asked_.clear();
  // Narrow as far as the known points reach.
  while (line_.count(bracket_.left) > 0 && line_.count(bracket_.right) > 0)
    bracket_ = narrowed(bracket_, line_.at(bracket_.left) >= line_.at(bracket_.right));
  if (end_merit_ && line_.size() >= line_evaluations_) end_line();
}

// The present point stays unless something is better: ties change nothing.
void GradualDeformation::end_line() {
  const auto best = std::max_element(
      line_.begin(), line_.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  double merit = *present_merit_;
  Point next = present_;
  if (*end_merit_ > merit) {
    merit = *end_merit_;
    next = end_;
  }
  if (best->second > merit) {
    merit = best->second;
    next = mixture(best->first);
  }
  present_ = next;
  present_merit_ = merit;
  begin_line();
}

json GradualDeformation::save() const {
  json line = json::array();
  for (const auto& [t, merit] : line_) line.push_back({t, merit});
  return {{"random", random_.state()},
          {"present", present_},
          {"present_merit", optional_json(present_merit_)},
          {"end", end_},
          {"end_merit", optional_json(end_merit_)},
          {"line", line},
          {"bracket", {bracket_.low, bracket_.high, bracket_.left, bracket_.right}},
          {"asked", asked_}};
}

void GradualDeformation::restore(const json& state) {
  random_.set_state(state.at("random").get<RandomStream::State>());
  present_ = state.at("present").get<Point>();
  present_merit_ = optional_from(state.at("present_merit"));
  end_ = state.at("end").get<Point>();
  end_merit_ = optional_from(state.at("end_merit"));
  line_.clear();
  for (const json& point : state.at("line"))
    line_[point.at(0).get<double>()] = point.at(1).get<double>();
  const auto b = state.at("bracket").get<std::array<double, 4>>();
  bracket_ = {b[0], b[1], b[2], b[3]};
  asked_ = state.at("asked").get<std::vector<double>>();
}

}  // namespace granary::server
