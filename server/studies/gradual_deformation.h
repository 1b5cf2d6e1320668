// Gradual deformation (bucket-elevator paper, section 7.2): mix the present point with a random one
// and look for the best mixture by golden sections; the best of everything seen on the way is the
// next present point, so a step never ends worse than both its ends (PHYSICS E.7).
//
// CONVEX mixes as printed, x = t a + (1 - t) b, which can only shrink towards the hull of the
// draws. GAUSSIAN maps each coordinate to a normal variable and mixes z = z_a cos(pi t / 2) + z_b
// sin(pi t / 2), t in [-1, 1], which keeps the distribution (PHYSICS 0, row 13).
#pragma once

#include "server/studies/golden_section.h"
#include "server/studies/random_stream.h"
#include "server/studies/search_method.h"

namespace granary::server {

class GradualDeformation : public SearchMethod {
 public:
  GradualDeformation(const v1::Optimize::GradualDeformation& settings, const SearchSetup& setup);

  std::vector<Point> next_batch() override;
  void take(const std::vector<Scored>& batch) override;
  nlohmann::json save() const override;
  void restore(const nlohmann::json& state) override;

 private:
  Point mixture(double t) const;
  Point draw();
  void begin_line();
  void end_line();

  v1::Optimize::GradualDeformation::Mixing mixing_;
  std::size_t line_evaluations_;
  std::size_t parallel_;
  RandomStream random_;
  Point present_;
  std::optional<double> present_merit_;
  Point end_;
  std::optional<double> end_merit_;
  std::map<double, double> line_;  // t -> merit
  GoldenSection bracket_;
  std::vector<double> asked_;  // t of the last batch, behind the points that are ends
};

}  // namespace granary::server
