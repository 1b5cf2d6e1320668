#include "worker/run/recovery.h"

#include <gtest/gtest.h>

#include "tests/support/toy_simulation.h"

namespace granary::run {
namespace {

using core::Cause;
using core::Remedy;
using granary::testing::ToySimulation;

class Patient : public ToySimulation {
 public:
  explicit Patient(std::vector<Remedy> known) : ToySimulation({}), known_(std::move(known)) {}
  bool knows(Remedy remedy) const override {
    return std::find(known_.begin(), known_.end(), remedy) != known_.end();
  }

 private:
  std::vector<Remedy> known_;
};

const Patient& discharge() {
  static const Patient patient(
      {Remedy::halve_time_step, Remedy::tighten_tolerance, Remedy::raise_penalty});
  return patient;
}

TEST(Recovery, tries_the_remedies_of_a_cause_one_after_the_other) {
  std::vector<Recovery> before;
  const std::vector<Remedy> expected = {Remedy::halve_time_step, Remedy::tighten_tolerance,
                                        Remedy::raise_penalty, Remedy::raise_penalty};
  for (const Remedy remedy : expected) {
    EXPECT_EQ(next_remedy(Cause::overlap, before, discharge()), remedy);
    before.push_back({Cause::overlap, remedy});
  }
  EXPECT_FALSE(next_remedy(Cause::overlap, before, discharge()));
}

TEST(Recovery, counts_every_cause_for_itself_up_to_a_bound_in_all) {
  std::vector<Recovery> before(4, {Cause::speed, Remedy::halve_time_step});
  EXPECT_FALSE(next_remedy(Cause::speed, before, discharge()));
  EXPECT_TRUE(next_remedy(Cause::not_finite, before, discharge()));
  before.push_back({Cause::not_finite, Remedy::halve_time_step});
  ASSERT_EQ(before.size(), kMostRecoveries);
  EXPECT_FALSE(next_remedy(Cause::not_finite, before, discharge()));
}

TEST(Recovery, passes_over_what_the_engine_does_not_know) {
  const Patient chute({Remedy::halve_time_step});
  const std::vector<Recovery> once = {{Cause::overlap, Remedy::halve_time_step}};
  EXPECT_EQ(next_remedy(Cause::energy, {}, chute), Remedy::halve_time_step);
  EXPECT_FALSE(next_remedy(Cause::overlap, once, chute));
  EXPECT_FALSE(next_remedy(Cause::overlap, {}, Patient({})));
}

TEST(Recovery, knows_no_remedy_without_a_cause) {
  EXPECT_FALSE(next_remedy(Cause::other, {}, discharge()));
}

TEST(Recovery, starting_over_forgets_all_but_the_raised_penalty) {
  const std::vector<Recovery> recoveries = {{Cause::overlap, Remedy::halve_time_step},
                                            {Cause::overlap, Remedy::raise_penalty},
                                            {Cause::speed, Remedy::halve_time_step},
                                            {Cause::overlap, Remedy::raise_penalty},
                                            {Cause::speed, Remedy::halve_time_step}};
  EXPECT_EQ(active_remedies(recoveries),
            (std::vector<Remedy>{Remedy::raise_penalty, Remedy::raise_penalty,
                                 Remedy::halve_time_step}));
}

TEST(Recovery, note_says_what_happened_and_what_was_done) {
  const RecoveryNote note =
      note_of({0.5, "overlap of 0.7 radii", {}, "", Cause::overlap},
              {"chute.time_step_s", 1e-5, 5e-6}, Remedy::halve_time_step, 0.41);
  EXPECT_EQ(note.path, "chute.time_step_s");
  EXPECT_EQ(note.value, 5e-6);
  EXPECT_EQ(note.evidence,
            "overlap of 0.7 radii: went back to t = 0.41 s and halved it (from 1e-05)");
}

}  // namespace
}  // namespace granary::run
