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
  AlignedVector<double> impulses;
  SweepSums sums;
};

Outcome solve(const Kernels& variant) {
  Heap heap;
  const ContactTerms terms{2e-4, 1 / (1e7 * 4e-8), 0.7, 2, 1.3, 0.15, 0.5, 0.02};
  ActiveContacts active;
  active.reserve(heap.candidates.size());
  std::vector<std::uint8_t> touched(heap.disks.count() + 1);
  const CandidateArrays candidates{
      heap.candidates.first.data(),        heap.candidates.second.data(),
      heap.candidates.normal_force.data(), heap.candidates.tangential_force.data(),
      heap.candidates.colour_start.data(), heap.candidates.colour_start.size() - 1};
  const ContactArrays arrays = arrays_of(active);
  std::size_t count = 0;
  active.size =
      variant.select_pairs(candidates, heap.disks.pose.data(), heap.disks.motion.data(),
                           heap.disks.rest_index(), terms, arrays, touched.data(), &count);
  EXPECT_GT(count, 300u);
  Outcome outcome;
  variant.apply_impulses(arrays, active.size, terms.spin_factor, heap.disks.motion.data());
  for (int k = 0; k < 5; ++k)
    variant.sweep(arrays, active.size, terms, heap.disks.motion.data(), &outcome.sums);
  outcome.motion = heap.disks.motion;
  outcome.impulses = active.impulse_n;
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

TEST(Kernels, sweeps_conserve_momentum_and_leave_the_resting_record_alone) {
  Heap heap;
  double before_x = 0, after_x = 0;
  for (std::size_t k = 0; k < heap.disks.count(); ++k)
    before_x += heap.disks.motion[k].vx / heap.disks.motion[k].inverse_mass;
  const Outcome outcome = solve(kernels());
  for (std::size_t k = 0; k < heap.disks.count(); ++k)
    after_x += outcome.motion[k].vx / outcome.motion[k].inverse_mass;
  EXPECT_NEAR(after_x, before_x, 1e-12);
  const DiskMotion& rest = outcome.motion.back();
  EXPECT_EQ(rest.vx, 0);
  EXPECT_EQ(rest.vy, 0);
  EXPECT_EQ(rest.surface_speed, 0);
}

}  // namespace
}  // namespace granary::dda
