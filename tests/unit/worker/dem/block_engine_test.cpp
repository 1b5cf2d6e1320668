#include "worker/dem/block_engine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tests/support/dem_cases.h"
#include "worker/core/random.h"

namespace granary::dem {
namespace {

using core::Vec3;

template <typename Engine>
class Sentinels : public ::testing::Test {};
TYPED_TEST_SUITE(Sentinels, tests::DemEngines);

constexpr double kLength = 0.3;
constexpr std::uint64_t kSteps = 700;

struct Flow {
  double rpm = 16;
  ContactEffects effects = {};
  bool is_mixture = true;
  unsigned threads = 1;
};

// A short stream between side walls that runs out at the end.
EngineSetup flow_setup(const Flow& flow) {
  EngineSetup setup = tests::base_setup(1e-5);
  if (flow.is_mixture) setup.classes.push_back({0.001, 1500});
  setup.grain_grain.rolling_friction = 0.02;
  setup.grain_wall.rolling_friction = 0.01;
  setup.grain_grain.cohesion_bond = setup.grain_wall.cohesion_bond = 2;  // where the effect is on
  setup.effects = flow.effects;
  setup.walls = {tests::floor_plane(), {{0, 0, 0}, {0, 1, 0}}, {{0, 0.03, 0}, {0, -1, 0}}};
  setup.motion.gravity = tests::gravity_on_slope(30);
  setup.motion.omega = tests::chute_omega(flow.rpm, 30);
  setup.motion.axis_point = {0.1, 0.015, 0};
  setup.outlet_x = kLength;
  setup.threads = flow.threads;
  return setup;
}

// Loose rows, four deep, dropping and meeting within milliseconds; the rearmost are still carried.
std::vector<Grain> flow_grains(const EngineSetup& setup) {
  std::vector<Grain> grains;
  const auto random = [&](std::uint64_t stream) {
    return core::random_uniform(3, stream, grains.size()) - 0.5;
  };
  for (double x = 0.002; x < kLength; x += 0.0032) {
    for (double z = 0.0016; z < 0.014; z += 0.0031) {
      for (double y = 0.0016; y < 0.029; y += 0.0032) {
        Grain grain;
        grain.position = {x + 1e-4 * random(1), y + 1e-4 * random(2), z + 1e-4 * random(3)};
        grain.velocity = {1 + 0.4 * random(4), 0.4 * random(5), 0.4 * random(6)};
        grain.spin = {100 * random(7), 100 * random(8), 100 * random(9)};
        grain.grain_class = setup.classes.size() > 1 && random(10) > 0.2 ? 1 : 0;
        grain.carried = x < 0.005;
        grains.push_back(grain);
      }
    }
  }
  return grains;
}

void insert_flow(Engine& engine) {
  const std::vector<Grain> grains = flow_grains(engine.setup());
  engine.insert(grains);
}

// Everything a run can show, to the bit.
std::vector<double> outcome(Engine& engine) {
  std::vector<double> all;
  const auto put = [&](const Vec3& v) { all.insert(all.end(), {v.x, v.y, v.z}); };
  const GrainTable table = engine.grains();
  for (std::size_t k = 0; k < table.size(); ++k) {
    all.push_back(static_cast<double>(table.id[k]));
    put(table.position[k]);
    put(table.velocity[k]);
    put(table.spin[k]);
  }
  for (const Leaver& leaver : engine.take_leavers()) {
    all.insert(all.end(), {leaver.time, static_cast<double>(leaver.id)});
    put(leaver.position);
    put(leaver.velocity);
  }
  const core::EnergyLedger ledger = engine.ledger();
  all.insert(all.end(), ledger.channels_j.begin(), ledger.channels_j.end());
  all.insert(all.end(), {ledger.stored_j(), ledger.throughput_j, engine.largest_overlap_ratio(),
                         static_cast<double>(engine.particle_steps()),
                         static_cast<double>(engine.contact_count())});
  return all;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

std::vector<double> run_flow(const Flow& flow, const Kernels& kernels) {
  BlockEngine engine(flow_setup(flow), kernels);
  insert_flow(engine);
  engine.advance(kSteps / 2);
  engine.release(0, 1 << 30);
  engine.advance(kSteps - kSteps / 2);
  EXPECT_FALSE(engine.trouble().has_value());
  return outcome(engine);
}

// No job depends on the processor it ran on: neither job keys nor resumes have to know it.
TEST(BlockEngine, vector_paths_give_the_same_bits) {
  ASSERT_GE(available_kernels().size(), 1U);
  for (const EffectCombination& row : kEffectCombinations) {
    for (const double rpm : {0.0, 16.0}) {
      const Flow flow = {.rpm = rpm, .effects = row.effects, .is_mixture = rpm > 0};
      const std::vector<double> portable = run_flow(flow, *available_kernels().front());
      for (const Kernels* kernels : available_kernels()) {
        EXPECT_TRUE(same_bits(portable, run_flow(flow, *kernels)))
            << row.name << ", " << kernels->name << ", " << rpm << " rpm";
      }
    }
  }
}

TEST(BlockEngine, threads_do_not_change_a_bit) {
  const std::vector<double> alone = run_flow({}, kernels());
  for (const unsigned threads : {2U, 4U, 8U}) {
    EXPECT_TRUE(same_bits(alone, run_flow({.threads = threads}, kernels()))) << threads;
  }
}

TEST(BlockEngine, resumes_bitwise_at_any_step_with_other_threads_and_paths) {
  BlockEngine whole(flow_setup({}));
  insert_flow(whole);
  whole.advance(kSteps);
  const std::vector<double> expected = outcome(whole);
  for (const std::uint64_t stop : {0U, 1U, 23U, 24U, 25U, 310U, 699U}) {
    BlockEngine first(flow_setup({}));
    insert_flow(first);
    first.advance(stop);
    BlockEngine second(flow_setup({.threads = 1 + static_cast<unsigned>(stop) % 3}),
                       *available_kernels()[stop % available_kernels().size()]);
    second.restore(first.snapshot());
    second.advance(kSteps - stop);
    EXPECT_TRUE(same_bits(expected, outcome(second))) << stop;
  }
}

// The plain engine is the oracle. Floats round overlaps of 3 mm spheres to 1.5 ulp of 3 mm, 3.5e-10
// m, which k_n / m turns into 0.01 m/s2 (three times that for the light class); over the 2 ms that
// disturbances need to grow by e, the paths of the two engines part by at most e 1/2 a t^2 = 1.6e-7
// m.
TEST(BlockEngine, follows_the_plain_engine_within_rounding) {
  for (const EffectCombination& row : kEffectCombinations) {
    EngineSetup setup = flow_setup({.effects = row.effects});
    setup.outlet_x = 1;  // leavers are taken out at other times
    BlockEngine block(setup);
    PlainEngine plain(setup);
    for (Engine* engine : {static_cast<Engine*>(&block), static_cast<Engine*>(&plain)}) {
      insert_flow(*engine);
      engine->advance(200);
    }
    const GrainTable a = block.grains(), b = plain.grains();
    ASSERT_EQ(a.size(), b.size());
    std::vector<std::size_t> row_of(a.size());
    for (std::size_t k = 0; k < b.size(); ++k) row_of[static_cast<std::size_t>(b.id[k])] = k;
    double farthest = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
      const std::size_t other = row_of[static_cast<std::size_t>(a.id[k])];
      farthest = std::max(farthest, norm(a.position[k] - b.position[other]));
    }
    EXPECT_LT(farthest, 1.6e-7) << row.name;
    EXPECT_GT(farthest, 0) << row.name;
    EXPECT_EQ(block.contact_count(), plain.contact_count()) << row.name;
    EXPECT_NEAR(block.ledger()[core::EnergyChannel::friction],
                plain.ledger()[core::EnergyChannel::friction],
                4.0 / (42 * 42) * plain.ledger()[core::EnergyChannel::friction])
        << row.name;
    EXPECT_LT(block.ledger().remainder_ratio(), 1e-4) << row.name;
    EXPECT_LT(plain.ledger().remainder_ratio(), 1e-4) << row.name;
  }
}

// Inner lists hold what may touch within their horizon. Pairs found too late would be contacts that
// the law missed for a few steps.
TEST(BlockEngine, lists_miss_no_contact_in_a_flow) {
  BlockEngine engine(flow_setup({}));
  insert_flow(engine);
  engine.advance(2000);
  EXPECT_GT(engine.order_rebuilds(), 2U);
  EXPECT_LT(static_cast<double>(engine.late_contacts()),
            1e-4 * static_cast<double>(engine.effect_counts().spin));
}

TEST(BlockEngine, effects_that_are_off_are_never_evaluated) {
  BlockEngine off(flow_setup({.rpm = 0, .effects = {false, false, false}}));
  insert_flow(off);
  off.advance(100);
  EXPECT_EQ(off.effect_counts().tangential_history, 0U);
  EXPECT_EQ(off.effect_counts().rolling_friction, 0U);
  EXPECT_EQ(off.effect_counts().spin, 0U);
  EXPECT_EQ(off.effect_counts().rotating_frame, 0U);
  BlockEngine on(flow_setup({}));
  insert_flow(on);
  on.advance(100);
  EXPECT_GT(on.effect_counts().tangential_history, 0U);
  EXPECT_GT(on.effect_counts().rolling_friction, 0U);
  EXPECT_GT(on.effect_counts().spin, 0U);
  EXPECT_GT(on.effect_counts().rotating_frame, 0U);
}

// Fine grains around a coarse one, 1:50: cells are as large as the coarse one needs.
TEST(BlockEngine, handles_a_size_ratio_of_fifty) {
  EngineSetup setup = tests::base_setup(1);
  setup.classes = {{0.0015, 2550}, {0.00003, 2550}};
  setup.walls = {tests::floor_plane()};
  setup.motion.gravity = {0, 0, -tests::kGravity};
  setup.time_step = 0.3 * stable_time_step(setup);
  std::vector<Grain> grains = {tests::grain_at({0, 0, 0.00151}, {0, 0, -0.05})};
  for (int x = -9; x <= 9; ++x) {
    for (int y = -9; y <= 9; ++y) {
      Grain fine = tests::grain_at({6.5e-5 * x, 6.5e-5 * y + 1e-6 * (x % 3), 3.05e-5});
      fine.grain_class = 1;
      if (norm(fine.position - grains[0].position) > 0.00153) grains.push_back(fine);
    }
  }
  ASSERT_GT(grains.size(), 200U);
  BlockEngine block(setup);
  PlainEngine plain(setup);
  for (Engine* engine : {static_cast<Engine*>(&block), static_cast<Engine*>(&plain)}) {
    engine->insert(grains);
    engine->advance(400);
    ASSERT_FALSE(engine->trouble().has_value());
    EXPECT_LT(engine->ledger().remainder_ratio(), 1e-4);
  }
  EXPECT_EQ(block.contact_count(), plain.contact_count());
  EXPECT_EQ(block.late_contacts(), 0U);
}

// A step far beyond what the contacts bear must end in words, never in numbers.
TEST(BlockEngine, sentinel_stops_a_run_that_tears_itself_apart) {
  EngineSetup setup = flow_setup({});
  BlockEngine engine(setup);
  std::vector<Grain> grains = flow_grains(setup);
  for (Grain& grain : grains) grain.velocity = grain.velocity * 60.0;
  engine.insert(grains);
  engine.advance(5000);
  ASSERT_TRUE(engine.trouble().has_value());
  EXPECT_FALSE(engine.trouble()->reason.empty());
}

// Faster than half a radius in a step a grain could pass a wall of triangles untouched.
TYPED_TEST(Sentinels, grain_that_outruns_the_step_is_told) {
  EngineSetup setup = tests::base_setup(1e-5);
  setup.triangles = {{{0, -1, -1}, {0, 1, -1}, {0, 0, 1}}};
  const double fastest = 0.5 * 0.0015 / 1e-5;  // m/s
  for (const double speed : {0.9 * fastest, 6 * fastest}) {
    TypeParam engine(setup);
    tests::insert_one(engine, tests::grain_at({-0.5, 0, 0}, {speed, 0, 0}));
    tests::insert_one(engine, tests::grain_at({-0.5, 0.1, 0}, {0, 0, 0}));
    engine.advance(100);
    if (speed < fastest) {
      EXPECT_FALSE(engine.trouble().has_value());
      continue;
    }
    ASSERT_TRUE(engine.trouble().has_value());
    EXPECT_EQ(engine.trouble()->cause, core::Cause::speed);
    EXPECT_EQ(engine.trouble()->ids, std::vector<std::int64_t>{0});
    EXPECT_EQ(engine.trouble()->suggestion, "a smaller chute.time_step_s");
  }
}

}  // namespace
}  // namespace granary::dem
