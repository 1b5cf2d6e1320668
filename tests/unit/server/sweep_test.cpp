#include "server/studies/sweep.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "proto/contract/scene_text.h"

namespace granary::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

v1::StudySpec spec_with(const std::function<void(v1::Sweep&)>& fill) {
  v1::StudySpec spec;
  *spec.mutable_scene() =
      parse_scene(
          "discharge { particles { count: 20 diameter_min_m: 0.01 density_kg_per_m3: 2200 } "
          "friction_pp_deg: 30 friction_pw_deg: 20 rotation_rad_per_s: 10 }",
          "test")
          ->scene;
  fill(*spec.mutable_sweep());
  return spec;
}

void vary(v1::Sweep& sweep, const std::string& path, const std::vector<std::string>& values) {
  v1::Sweep::Variable& variable = *sweep.add_vary();
  variable.set_path(path);
  for (const std::string& value : values) variable.add_values(value);
}

std::vector<std::string> labels(StudyGenerator& generator, std::size_t limit = 1000) {
  std::vector<std::string> out;
  for (const TrialProposal& proposal : generator.ask(limit)) out.push_back(proposal.label);
  return out;
}

std::unique_ptr<StudyGenerator> made(const v1::StudySpec& spec) {
  auto generator = make_sweep(spec);
  EXPECT_TRUE(generator.ok()) << generator.error().message;
  return std::move(*generator);
}

v1::StudySpec grid_spec() {
  return spec_with([](v1::Sweep& sweep) {
    vary(sweep, "seed", {"1", "2"});
    vary(sweep, "discharge.rotation_rad_per_s", {"8", "9", "10"});
  });
}

TEST(Sweep, a_grid_is_every_combination_the_last_variable_changing_fastest) {
  auto generator = made(grid_spec());
  EXPECT_EQ(generator->planned(), 6u);
  const auto proposals = generator->ask(100);
  ASSERT_EQ(proposals.size(), 6u);
  EXPECT_EQ(proposals[0].scene.seed(), 1u);
  EXPECT_EQ(proposals[0].scene.discharge().rotation_rad_per_s(), 8);
  EXPECT_EQ(proposals[1].scene.discharge().rotation_rad_per_s(), 9);
  EXPECT_EQ(proposals[3].scene.seed(), 2u);
  EXPECT_EQ(proposals[5].inputs.at("discharge.rotation_rad_per_s"), "10");
  EXPECT_TRUE(generator->done());
}

TEST(Sweep, a_list_takes_the_values_together) {
  auto spec = spec_with([](v1::Sweep& sweep) {
    sweep.set_design(v1::Sweep::LIST);
    vary(sweep, "seed", {"1", "2"});
    vary(sweep, "discharge.friction_pp_deg", {"20", "30"});
  });
  EXPECT_THAT(labels(*made(spec)),
              ElementsAre("friction_pp_deg=20 seed=1", "friction_pp_deg=30 seed=2"));
}

TEST(Sweep, a_latin_hypercube_has_one_point_in_every_stratum) {
  constexpr std::uint32_t kSamples = 50;
  auto spec = spec_with([](v1::Sweep& sweep) {
    sweep.set_design(v1::Sweep::LATIN_HYPERCUBE);
    sweep.set_samples(kSamples);
    for (const char* path : {"discharge.rotation_rad_per_s", "discharge.friction_pp_deg"}) {
      v1::Sweep::Variable& variable = *sweep.add_vary();
      variable.set_path(path);
      variable.set_minimum(10);
      variable.set_maximum(20);
    }
    vary(sweep, "seed", {"1", "2", "3", "4", "5"});
  });
  auto generator = made(spec);
  std::map<std::string, std::set<int>> strata;
  std::map<std::string, int> seeds;
  for (const TrialProposal& proposal : generator->ask(1000)) {
    for (const char* path : {"discharge.rotation_rad_per_s", "discharge.friction_pp_deg"})
      strata[path].insert(
          static_cast<int>((std::stod(proposal.inputs.at(path)) - 10) / 10 * kSamples));
    ++seeds[proposal.inputs.at("seed")];
  }
  for (const auto& [path, hit] : strata) EXPECT_EQ(hit.size(), kSamples) << path;
  for (const auto& [seed, count] : seeds) EXPECT_EQ(count, 10) << seed;
}

TEST(Sweep, the_same_seed_gives_the_same_hypercube_and_another_seed_another) {
  auto spec = spec_with([](v1::Sweep& sweep) {
    sweep.set_design(v1::Sweep::LATIN_HYPERCUBE);
    sweep.set_samples(5);
    v1::Sweep::Variable& variable = *sweep.add_vary();
    variable.set_path("discharge.rotation_rad_per_s");
    variable.set_minimum(1);
    variable.set_maximum(2);
  });
  const auto first = labels(*made(spec));
  EXPECT_EQ(first, labels(*made(spec)));
  spec.set_seed(2);
  EXPECT_NE(first, labels(*made(spec)));
}

TEST(Sweep, continues_from_its_saved_state) {
  auto whole = made(grid_spec());
  const auto expected = labels(*whole);
  auto generator = made(grid_spec());
  std::vector<std::string> got = labels(*generator, 2);
  const std::string state = generator->save();
  generator = made(grid_spec());
  generator->restore(state);
  while (!generator->done())
    for (std::string& label : labels(*generator, 1)) got.push_back(std::move(label));
  EXPECT_EQ(got, expected);
  EXPECT_THROW(generator->restore("7 1 1"), std::runtime_error);
  EXPECT_THROW(generator->restore("not a state"), std::runtime_error);
}

TEST(Sweep, refuses_what_cannot_run_and_says_which_trial) {
  struct Case {
    std::function<void(v1::Sweep&)> fill;
    const char* message;
  };
  const std::vector<Case> cases = {
      {[](v1::Sweep&) {}, "vary: is empty"},
      {[](v1::Sweep& s) { vary(s, "discharge.rotation", {"1"}); }, "rotation_rad_per_s"},
      {[](v1::Sweep& s) {
         vary(s, "seed", {"1", "x"});
       },
       "not a whole number"},
      {[](v1::Sweep& s) {
         vary(s, "discharge.friction_pp_deg", {"20", "120"});
       },
       "trial 2"},
      {[](v1::Sweep& s) { vary(s, "seed", {}); }, "values: is empty"},
      {[](v1::Sweep& s) { vary(s, "seed", {"1"}), vary(s, "seed", {"2"}); }, "varied twice"},
      {[](v1::Sweep& s) { vary(s, "seed", {"1"}), s.set_samples(3); }, "LATIN_HYPERCUBE"},
      {[](v1::Sweep& s) {
         s.set_design(v1::Sweep::LIST), vary(s, "seed", {"1", "2"}), vary(s, "threads", {"1"});
       },
       "as many values"},
      {[](v1::Sweep& s) { s.set_design(v1::Sweep::LATIN_HYPERCUBE), vary(s, "seed", {"1"}); },
       "samples"},
  };
  for (const Case& each : cases) {
    const auto made = make_sweep(spec_with(each.fill));
    ASSERT_FALSE(made.ok()) << each.message;
    EXPECT_EQ(made.error().code, ErrorCode::invalid_argument);
    EXPECT_THAT(made.error().message, HasSubstr(each.message));
  }
}

TEST(Sweep, refuses_more_trials_than_the_queue_should_hold) {
  std::vector<std::string> thousand;
  for (int i = 0; i < 1000; ++i) thousand.push_back(std::to_string(i));
  const auto made = make_sweep(spec_with([&](v1::Sweep& sweep) {
    vary(sweep, "seed", thousand);
    vary(sweep, "replicates", thousand);
  }));
  ASSERT_FALSE(made.ok());
  EXPECT_THAT(made.error().message, HasSubstr("100000"));
}

}  // namespace
}  // namespace granary::server
