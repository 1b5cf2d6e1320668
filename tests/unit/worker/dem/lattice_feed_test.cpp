#include "worker/dem/lattice_feed.h"

#include <gtest/gtest.h>

namespace granary::dem {
namespace {

LatticeFeedSetup base_feed(double sluice_height) {
  LatticeFeedSetup setup;
  setup.sluice_height = sluice_height;
  setup.classes = {GrainClass{0.0015, 2550}};
  setup.mass_fractions = {1};
  return setup;
}

// PHYSICS section A6, table.
TEST(LatticeFeed, counts_and_speeds_follow_from_the_sluice_height) {
  struct Row {
    double height;
    std::size_t grains;
    double speed;
  };
  for (const Row& row : {Row{.020, 225, .683}, Row{.025, 293, .525}, Row{.030, 360, .427},
                         Row{.035, 428, .359}, Row{.040, 495, .311}, Row{.045, 563, .2731},
                         Row{.050, 630, .244}}) {
    const LatticeFeed feed(base_feed(row.height));
    EXPECT_EQ(feed.grains_per_period(), row.grains) << row.height;
    EXPECT_NEAR(feed.speed(), row.speed, 6e-4) << row.height;
  }
  EXPECT_NEAR(2 * LatticeFeed(base_feed(.045)).layer_interval(), 12.69e-3, 1e-5);
}

TEST(LatticeFeed, neighbouring_layers_touch_and_do_not_overlap) {
  const LatticeFeed feed(base_feed(.045));
  const auto first = feed.layer(0, 0);
  const auto second = feed.layer(1, 0);
  double nearest = 1;
  for (const Grain& b : second) nearest = std::min(nearest, norm(b.position - first[0].position));
  EXPECT_NEAR(nearest, 0.003, 1e-12);
}

TEST(LatticeFeed, mass_set_free_follows_the_flow_to_one_layer) {
  const LatticeFeed feed(base_feed(.045));
  const double grain_mass = GrainClass{0.0015, 2550}.mass();
  double mass = 0;
  for (std::int64_t layer = 0; layer < 1000; ++layer) {
    const double layer_mass = static_cast<double>(feed.layer(layer, 0).size()) * grain_mass;
    mass += layer_mass;
    EXPECT_NEAR(mass, 1.6 * feed.arrival_time(layer), 1.1 * layer_mass);
  }
}

TEST(LatticeFeed, mixture_keeps_mass_flow_and_fractions) {
  LatticeFeedSetup setup = base_feed(.045);
  setup.classes = {GrainClass{0.0015, 2550}, GrainClass{0.001, 1500}};
  setup.mass_fractions = {0.7, 0.3};
  const LatticeFeed feed(setup);
  const double span = 400 * feed.layer_interval();
  double mass = 0;
  double coarse = 0;
  for (std::int64_t layer = 0; layer < 400; ++layer) {
    for (const Grain& grain : feed.layer(layer, 0)) {
      const double grain_mass = setup.classes[grain.grain_class].mass();
      mass += grain_mass;
      if (grain.grain_class == 0) coarse += grain_mass;
    }
  }
  // 112600 independent draws: relative spread of the sums below 0.5 %.
  EXPECT_NEAR(mass / (1.6 * span), 1, 0.01);
  EXPECT_NEAR(coarse / mass, 0.7, 0.01);
}

}  // namespace
}  // namespace granary::dem
