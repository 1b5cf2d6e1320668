#include "server/studies/price.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "proto/contract/field_path.h"
#include "proto/contract/scene_text.h"
#include "server/studies/ablate.h"

namespace granary::server {
namespace {

v1::StudySpec spec_of(const std::string& scene_text) {
  v1::StudySpec spec;
  auto scene = load_scene(scene_text, "scene.txtpb", {});
  EXPECT_TRUE(scene) << scene.error().message;
  *spec.mutable_scene() = *scene;
  return spec;
}

const char* kDischarge =
    "discharge { particles { count: 50 diameter_min_m: 0.004 density_kg_per_m3: 730 } "
    "friction_pp_deg: 30 friction_pw_deg: 20 rotation_rad_per_s: 9 }";
const char* kChute =
    "chute { inclination_deg: 30 duration_s: 1 particles { diameter_m: 0.003 density_kg_per_m3: "
    "2550 } contact_pp { normal_restitution: 0.9 tangential_restitution: 0.3 friction_coefficient: "
    "0.3 } contact_pw { normal_restitution: 0.9 tangential_restitution: 0.3 friction_coefficient: "
    "0.3 } inlet { feed: NONE } initial_count: 10 }";

// f1 = 2 (1 + 100 dt), exactly first order in the time step, with a little noise.
TrialOutcome run(const TrialProposal& proposal) {
  TrialOutcome outcome;
  outcome.state = v1::COMPLETE;
  outcome.job = "jobs/1";
  double dt = 2e-4;
  if (const auto found = proposal.inputs.find("discharge.time_step_s");
      found != proposal.inputs.end())
    dt = std::stod(found->second);
  v1::Quantity& f1 = (*outcome.result.mutable_values())["f1_m"];
  f1.set_value(2 * (1 + 100 * dt));
  f1.set_error(1e-5);
  outcome.result.mutable_cost()->set_cpu_s(1e-4 / dt);
  outcome.result.mutable_cost()->set_peak_rss_bytes(5e7);
  outcome.result.mutable_ledger()->set_remainder_ratio(dt);
  return outcome;
}

std::vector<TrialProposal> run_all(StudyGenerator& study) {
  std::vector<TrialProposal> all;
  for (std::uint32_t told = 0; !study.done();)
    for (TrialProposal& proposal : study.ask(3)) {
      study.tell(++told, run(proposal));
      all.push_back(std::move(proposal));
    }
  return all;
}

TEST(Price, climbs_step_penalty_and_tolerance_around_the_base_scene) {
  auto study = make_price(spec_of(kDischarge));
  ASSERT_TRUE(study) << study.error().message;
  const auto trials = run_all(**study);
  EXPECT_EQ(trials.size(), (*study)->planned());
  EXPECT_EQ(trials[0].role, "base");
  std::map<std::string, int> rungs;
  for (const TrialProposal& trial : trials) {
    EXPECT_EQ(trial.scene.replicates(), 4u);
    EXPECT_FALSE(trial.scene.has_accuracy());
    for (const auto& [path, value] : trial.inputs) ++rungs[path];
  }
  EXPECT_EQ(rungs["discharge.time_step_s"], 4);
  EXPECT_EQ(rungs["discharge.filling_time_step_s"], 4);
  EXPECT_EQ(rungs["discharge.penalty.stiffness_n_per_m"], 3);
  EXPECT_EQ(rungs["discharge.solver.tolerance"], 3);
}

TEST(Price, finds_the_order_the_limit_and_the_knee) {
  auto study = make_price(spec_of(kDischarge));
  run_all(**study);
  const v1::StudySummary summary = (*study)->summary();
  EXPECT_NEAR(summary.figures().at("order|discharge.time_step_s|f1_m").value(), 1, 0.01);
  EXPECT_NEAR(summary.figures().at("limit|discharge.time_step_s|f1_m").value(), 2, 1e-4);
  EXPECT_EQ(summary.figures().at("order|discharge.solver.tolerance|f1_m").error_basis(),
            "below noise");
  // The error still falls with the step: the finest one is the knee. The penalty does nothing.
  EXPECT_NEAR(summary.figures().at("knee|discharge.time_step_s").value(), 5e-5, 1e-9);
  EXPECT_NE(summary.verdict().find("discharge.time_step_s=5e-05"), std::string::npos)
      << summary.verdict();
}

TEST(Price, says_what_the_finest_rung_bought_beyond_the_base_scene) {
  auto study = make_price(spec_of(kDischarge));
  run_all(**study);
  const v1::StudySummary summary = (*study)->summary();
  EXPECT_NEAR(summary.figures().at("remainder|discharge.time_step_s=5e-05").value(), 5e-5, 1e-12);
  EXPECT_NE(summary.verdict().find("discharge.time_step_s=5e-05 instead of 0.0002: f1_m -0.03"),
            std::string::npos)
      << summary.verdict();
  EXPECT_NE(summary.verdict().find("(shows), ledger remainder 5.0e-05 instead of 2.0e-04, 4.0 "
                                   "times the CPU"),
            std::string::npos)
      << summary.verdict();
  EXPECT_NE(summary.verdict().find("discharge.penalty.stiffness_n_per_m=1e+08 instead of 1e+07: "
                                   "f1_m +0 +- 1e-05 (below noise)"),
            std::string::npos)
      << summary.verdict();
}

TEST(Price, stores_every_rung_with_its_error_and_price) {
  auto study = make_price(spec_of(kDischarge));
  run_all(**study);
  std::map<std::string, PricePoint> points;
  const auto findings = (*study)->findings();
  for (const PricePoint& point : findings->price) points[point.rung] = point;
  const PricePoint& coarsest = points.at("discharge.time_step_s=0.0008");
  EXPECT_EQ(coarsest.observable, "f1_m");
  EXPECT_NEAR(*coarsest.error, 0.16, 1e-3);
  EXPECT_NEAR(*coarsest.cpu_s, 0.125, 1e-9);
  EXPECT_TRUE(points.contains("replicates=8"));
  EXPECT_NEAR(*points.at("replicates=8").error / *points.at("replicates=2").error, 0.5, 1e-9);
}

TEST(Price, goes_on_after_a_restart_where_it_was) {
  auto whole = make_price(spec_of(kDischarge));
  auto first = make_price(spec_of(kDischarge));
  auto second = make_price(spec_of(kDischarge));
  run_all(**whole);
  const auto begun = (*first)->ask(2);
  (*first)->tell(1, run(begun[0]));
  (*second)->restore((*first)->save());
  (*second)->tell(2, run(begun[1]));
  for (std::uint32_t told = 2; !(*second)->done();)
    for (const TrialProposal& proposal : (*second)->ask(5)) (*second)->tell(++told, run(proposal));
  EXPECT_EQ((*second)->save(), (*whole)->save());
  EXPECT_THROW((*second)->restore("nonsense"), std::exception);
}

TEST(Price, scales_both_stiffnesses_of_a_chute_and_its_step_with_them) {
  auto study = make_price(spec_of(kChute));
  ASSERT_TRUE(study) << study.error().message;
  bool found = false;
  for (const TrialProposal& trial : (*study)->ask(100)) {
    const auto pp = trial.inputs.find("chute.contact_pp.normal_stiffness_n_per_m");
    if (pp == trial.inputs.end() || std::stod(pp->second) != 4000) continue;
    found = true;
    EXPECT_EQ(trial.inputs.at("chute.contact_pw.normal_stiffness_n_per_m"), "4000");
    EXPECT_TRUE(trial.inputs.contains("chute.time_step_s"));
  }
  EXPECT_TRUE(found);
}

TEST(Price, refuses_ladders_that_the_scene_does_not_have) {
  v1::StudySpec spec = spec_of(kChute);
  spec.mutable_price()->add_ladder("chute.nonsense");
  const auto study = make_price(spec);
  ASSERT_FALSE(study);
  EXPECT_EQ(study.error().field_path, "price.ladder");
  EXPECT_NE(study.error().message.find("chute.time_step_s"), std::string::npos);
  v1::StudySpec single = spec_of(kChute);
  single.mutable_price()->set_replicates(1);
  EXPECT_EQ(make_price(single).error().field_path, "price.replicates");
}

// ---- ablate

TrialOutcome run_pair(const TrialProposal& proposal) {
  TrialOutcome outcome = run(proposal);
  outcome.result.clear_values();
  v1::Quantity& speed = (*outcome.result.mutable_values())["exit_speed_m_per_s"];
  const bool turned_off = proposal.inputs.contains("effects.particle_rotation");
  const bool smooth = proposal.inputs.contains("chute.contact_pp.friction_coefficient");
  speed.set_value(turned_off ? 2.0 : smooth ? 3.5 : 2.5);
  speed.set_error(0.01);
  outcome.result.mutable_cost()->set_cpu_s(turned_off ? 1 : 2);
  return outcome;
}

TEST(Ablate, gives_difference_interval_and_price_of_each_effect) {
  v1::StudySpec spec = spec_of(kChute);
  spec.mutable_ablate()->add_effect("particle_rotation");
  spec.mutable_ablate()->add_effect("chute.contact_pp.friction_coefficient=0");
  auto study = make_ablate(spec);
  ASSERT_TRUE(study) << study.error().message;
  std::uint32_t told = 0;
  for (const TrialProposal& proposal : (*study)->ask(10)) {
    EXPECT_EQ(proposal.scene.replicates(), 6u);
    (*study)->tell(++told, run_pair(proposal));
  }
  EXPECT_EQ(told, 3u);
  const auto rows = (*study)->findings()->effects;
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].effect, "particle_rotation");
  EXPECT_NEAR(*rows[0].delta, 0.5, 1e-12);  // with minus without
  EXPECT_GT(*rows[0].error, 0.01);
  EXPECT_LT(*rows[0].error, 0.02);
  EXPECT_NEAR(*rows[0].cpu_ratio, 2, 1e-12);
  EXPECT_NEAR(*rows[1].delta, 1, 1e-12);  // its value minus the scene's
  EXPECT_EQ((*study)->summary().figures().at("on|particle_rotation").value(), 1);
  EXPECT_NEAR(
      (*study)->summary().figures().at("relative|particle_rotation|exit_speed_m_per_s").value(),
      0.2, 1e-12);
}

TEST(Ablate, a_changed_setting_brings_the_effect_that_it_calls_for) {
  v1::StudySpec spec = spec_of(kDischarge);
  spec.mutable_ablate()->add_effect("discharge.rolling_friction_coefficient=0.1");
  auto study = make_ablate(spec);
  ASSERT_TRUE(study) << study.error().message;
  const auto trials = (*study)->ask(10);
  ASSERT_EQ(trials.size(), 2u);
  EXPECT_EQ(trials[0].scene.effects().rolling_friction(), v1::Effects::OFF);
  EXPECT_NE(trials[1].scene.effects().rolling_friction(), v1::Effects::OFF);
}

TEST(Ablate, without_a_list_tries_every_effect_and_says_what_is_not_available) {
  auto study = make_ablate(spec_of(kChute));
  ASSERT_TRUE(study);
  const auto trials = (*study)->ask(100);
  EXPECT_EQ((*study)->planned(), trials.size());
  const v1::StudySummary summary = (*study)->summary();
  EXPECT_TRUE(summary.figures().contains("unavailable|gas"));
  EXPECT_NE(summary.figures().at("unavailable|gas").error_basis().find("not available"),
            std::string::npos);
  std::uint32_t told = 0;
  for (const TrialProposal& proposal : trials) (*study)->tell(++told, run_pair(proposal));
  auto again = make_ablate(spec_of(kChute));
  (*again)->restore((*study)->save());
  EXPECT_EQ((*again)->save(), (*study)->save());
  EXPECT_EQ((*again)->findings()->effects.size(), (*study)->findings()->effects.size());
}

TEST(Ablate, refuses_unknown_effects_and_bad_settings) {
  for (const char* effect : {"magic", "chute.contact_pp.friction_coefficient=-1", "nonsense=1"}) {
    v1::StudySpec spec = spec_of(kChute);
    spec.mutable_ablate()->add_effect(effect);
    EXPECT_FALSE(make_ablate(spec)) << effect;
  }
}

}  // namespace
}  // namespace granary::server
