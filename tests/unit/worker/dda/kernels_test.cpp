#include "worker/dda/kernels.h"

#include <gtest/gtest.h>

#include <cstring>

#include "worker/core/random.h"
#include "worker/dda/narrow_phase.h"
#include "worker/dda/step.h"

namespace granary::dda {
namespace {

// A loose heap: random disks, every near pair a candidate with some force in it.
struct Heap {
  Disks disks;
  CandidateList candidates;
  static constexpr int kSide = 20;

  Heap() {
    const auto random = [](std::uint64_t stream, int k) {
      return core::random_uniform(5, stream, k);
    };
    for (int k = 0; k < kSide * kSide; ++k)
      disks.add({0.004 * (k % kSide) + 2e-4 * random(1, k),
                 0.004 * (k / kSide) + 2e-4 * random(2, k), 0.002, 0},
                {random(3, k) - 0.5, random(4, k) - 0.5, random(6, k) - 0.5, 100 + random(7, k)},
                0);
    std::vector<NewContact> contacts;
    for (int k = 0; k < kSide * kSide; ++k) {
      if (k % kSide + 1 < kSide) contacts.push_back({k, k + 1, random(8, k), 0.1 * random(9, k)});
      if (k + kSide < kSide * kSide) contacts.push_back({k, k + kSide, 0, 0});
    }
    colour_contacts(contacts, true, disks.rest_index(), disks.rest_index(), candidates);
  }
};

struct Outcome {
  AlignedVector<DiskMotion> motion;
  AlignedVector<DiskShift> shift;
  AlignedVector<double> impulses, gaps;
  SweepSums sums;
  SmallStepSums small_sums;
  ContactSums contact_sums;
  double dissipation = 0;
};

ContactTerms terms_of_heap() {
  const double h = 5e-5, stiffness = 1e7, damping = 300;
  return {.time_step = 2e-4,
          .small_step = h,
          .stiffness = stiffness,
          .damping_n = damping,
          .damping_t = damping / 2,
          .compliance = 1 / (stiffness * h * h),
          .compliance_n = 1 / (stiffness * h * h + damping * h),
          .compliance_t = 1 / (stiffness * h * h + damping * h / 2),
          .friction = 0.7,
          .rolling = 0.1,
          .cohesion = 0.5,
          .cohesion_range = 4e-5,
          .spin_factor = 2,
          .relaxation = 1.2,
          .weight_n = 0,
          .weight_t = 0,
          .normal_time = 1e-4,
          .restitution = 0.5,
          .restitution_threshold = 0.02};
}

struct SelectedHeap : Heap {
  ActiveContacts active;
  ContactTerms terms = terms_of_heap();

  explicit SelectedHeap(const Kernels& variant, double small_step = terms_of_heap().small_step) {
    terms.small_step = small_step;  // as long as the step: for one solve
    active.reserve(candidates.size() + kGroupSize * candidates.colour_start.size());
    std::vector<std::uint8_t> touched(disks.count() + 1);
    std::vector<std::int32_t> picked(candidates.size() + kGroupSize);
    AlignedVector<DiskPose> ahead = disks.pose;
    for (std::size_t k = 0; k < disks.count(); ++k) {
      ahead[k].x += terms.time_step * disks.motion[k].vx;
      ahead[k].y += terms.time_step * disks.motion[k].vy;
      ahead[k].radius *= 1.1;
    }
    const CandidateArrays arrays{
        candidates.first.data(),        candidates.second.data(),
        candidates.normal_force.data(), candidates.tangential_force.data(),
        candidates.colour_start.data(), candidates.colour_start.size() - 1};
    std::size_t count = 0;
    active.size = variant.select_pairs(arrays, disks.pose.data(), disks.motion.data(), ahead.data(),
                                       disks.rest_index(), terms, arrays_of(active), touched.data(),
                                       picked.data(), &count);
    EXPECT_GT(count, 300u);
  }
};

Outcome solve(const Kernels& variant) {
  SelectedHeap heap(variant, terms_of_heap().time_step);
  const ContactArrays arrays = arrays_of(heap.active);
  DiskMotion* motion = heap.disks.motion.data();
  Outcome outcome;
  variant.laws({}).apply_impulses(arrays, heap.active.size, heap.terms.spin_factor, motion);
  for (int k = 0; k < 5; ++k)
    variant.laws({}).sweep(arrays, heap.active.size, heap.terms, motion, &outcome.sums);
  outcome.motion = heap.disks.motion;
  outcome.impulses = heap.active.impulse_n;
  return outcome;
}

Outcome solve_by_small_steps(const Kernels& variant) {
  SelectedHeap heap(variant);
  const ContactArrays arrays = arrays_of(heap.active);
  const std::size_t count = heap.active.size;
  AlignedVector<DiskMotion> before = heap.disks.motion;
  std::vector<double> mass;
  std::vector<std::uint32_t> index;
  for (std::size_t k = 0; k < heap.disks.count(); ++k) {
    mass.push_back(1 / heap.disks.motion[k].inverse_mass);
    index.push_back(static_cast<std::uint32_t>(k));
  }
  Outcome outcome;
  outcome.shift.resize(heap.disks.count() + 1);
  variant.laws({}).apply_impulses(arrays, count, heap.terms.spin_factor, heap.disks.motion.data());
  for (int s = 0; s < 4; ++s) {
    SmallStep small{s * heap.terms.small_step, true, s > 0, true};
    for (int k = 0; k < 2; ++k, small.first_sweep = false)
      variant.laws({}).small_sweep_pairs(arrays, count, heap.terms, small, outcome.shift.data(),
                                         heap.disks.motion.data(), before.data(),
                                         &outcome.small_sums);
    outcome.dissipation +=
        variant.advance_disks(index.data(), index.size(), heap.terms.small_step, true, mass.data(),
                              heap.disks.motion.data(), before.data(), outcome.shift.data());
  }
  variant.laws({}).close_pairs(arrays, count, heap.terms, {heap.terms.time_step, true, true, true},
                               outcome.shift.data(), &outcome.small_sums, &outcome.contact_sums);
  outcome.motion = before;
  outcome.impulses = heap.active.impulse_n;
  outcome.gaps = heap.active.gap_now;
  return outcome;
}

template <typename Vector>
bool same_bits(const Vector& a, const Vector& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}

TEST(Kernels, every_instruction_set_gives_the_same_bits) {
  const Kernels* list[3] = {};
  const std::size_t count = available_kernels(list, 3);
  const Outcome reference = solve(*list[0]);
  EXPECT_GT(reference.sums.total, 0);
  for (std::size_t k = 1; k < count; ++k) {
    const Outcome outcome = solve(*list[k]);
    EXPECT_TRUE(same_bits(outcome.motion, reference.motion)) << list[k]->name;
    EXPECT_TRUE(same_bits(outcome.impulses, reference.impulses)) << list[k]->name;
    EXPECT_EQ(outcome.sums.change, reference.sums.change) << list[k]->name;
  }
}

TEST(Kernels, small_steps_have_the_same_bits_on_every_instruction_set) {
  const Kernels* list[3] = {};
  const std::size_t count = available_kernels(list, 3);
  const Outcome reference = solve_by_small_steps(*list[0]);
  EXPECT_GT(reference.small_sums.spring_loss.total(), 0);
  EXPECT_GT(reference.dissipation, 0);
  for (std::size_t k = 1; k < count; ++k) {
    const Outcome outcome = solve_by_small_steps(*list[k]);
    EXPECT_TRUE(same_bits(outcome.motion, reference.motion)) << list[k]->name;
    EXPECT_TRUE(same_bits(outcome.shift, reference.shift)) << list[k]->name;
    EXPECT_TRUE(same_bits(outcome.impulses, reference.impulses)) << list[k]->name;
    EXPECT_EQ(std::memcmp(&outcome.small_sums, &reference.small_sums, sizeof(SmallStepSums)), 0);
    EXPECT_EQ(std::memcmp(&outcome.contact_sums, &reference.contact_sums, sizeof(ContactSums)), 0);
    EXPECT_EQ(outcome.dissipation, reference.dissipation) << list[k]->name;
  }
}

TEST(Kernels, sweeps_conserve_momentum_and_leave_the_resting_record_alone) {
  Heap heap;
  double before_x = 0;
  for (std::size_t k = 0; k < heap.disks.count(); ++k)
    before_x += heap.disks.motion[k].vx / heap.disks.motion[k].inverse_mass;
  for (const Outcome& outcome : {solve(kernels()), solve_by_small_steps(kernels())}) {
    double after_x = 0;
    for (std::size_t k = 0; k < heap.disks.count(); ++k)
      after_x += outcome.motion[k].vx / outcome.motion[k].inverse_mass;
    EXPECT_NEAR(after_x, before_x, 1e-12);
    const DiskMotion& rest = outcome.motion.back();
    EXPECT_EQ(rest.vx, 0);
    EXPECT_EQ(rest.vy, 0);
    EXPECT_EQ(rest.surface_speed, 0);
  }
}

}  // namespace
}  // namespace granary::dda
