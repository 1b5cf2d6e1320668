#include "server/studies/pagmo_search.h"

#include <algorithm>
#include <map>
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/cmaes.hpp>
#include <pagmo/algorithms/nsga2.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <sstream>
#include <stdexcept>

namespace granary::server {
namespace {

using nlohmann::json;

// A tenth of the box: the start is a guess, but budgets are some ten generations, too few to shrink
// a wider cloud (tests/physics/design/README.md).
constexpr double kFirstStep = 0.1;

// What stands between pagmo's fitness calls and our batches.
struct Ledger {
  std::map<Point, std::vector<double>> known;  // pagmo minimises
  std::vector<Point> asked;
  bool recording = false;
};

struct BoxProblem {
  std::shared_ptr<Ledger> ledger = std::make_shared<Ledger>();
  std::size_t dimensions = 1;
  std::size_t terms = 1;

  pagmo::vector_double fitness(const pagmo::vector_double& point) const {
    if (ledger->recording) {
      ledger->asked.push_back(point);
      return pagmo::vector_double(terms, 0);
    }
    return ledger->known.at(point);
  }
  std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    return {pagmo::vector_double(dimensions, 0), pagmo::vector_double(dimensions, 1)};
  }
  pagmo::vector_double::size_type get_nobj() const { return terms; }
  template <typename Archive>
  void serialize(Archive&, unsigned) {}  // pagmo demands it; problems are never stored
};

pagmo::algorithm make_algorithm(v1::Optimize::Method method, unsigned seed) {
  if (method == v1::Optimize::NSGA_II)
    return pagmo::algorithm(pagmo::nsga2(1, 0.95, 10, 0.1, 20, seed));
  // No early stop: the budget decides. Adapted parameters are kept between generations.
  return pagmo::algorithm(pagmo::cmaes(1, -1, -1, -1, -1, kFirstStep, 0, 0, /*memory=*/true,
                                       /*force_bounds=*/true, seed));
}

std::vector<double> to_minimise(const Scored& scored, std::size_t terms) {
  if (terms == 1) return {-scored.merit};
  std::vector<double> negated;
  for (const double term : scored.terms) negated.push_back(-term);
  return negated;
}

}  // namespace

struct PagmoSearch::State {
  State(v1::Optimize::Method which, const SearchSetup& setup)
      : method(which),
        terms(method == v1::Optimize::NSGA_II ? setup.terms : 1),
        size(setup.population),
        problem{std::make_shared<Ledger>(), setup.start.size(), terms},
        random(setup.seed),
        algorithm(make_algorithm(method, static_cast<unsigned>(setup.seed))),
        population(pagmo::problem(problem), 0u, static_cast<unsigned>(setup.seed)),
        start(setup.start) {}

  // NSGA-II wants variety, CMA-ES a cloud of the size of its first step.
  double first_coordinate(double start) {
    if (method == v1::Optimize::NSGA_II) return random.uniform();
    return std::clamp(start + kFirstStep * random.normal(), 0.0, 1.0);
  }

  v1::Optimize::Method method;
  std::size_t terms;
  std::size_t size;
  BoxProblem problem;
  RandomStream random;  // of the first generation
  pagmo::algorithm algorithm;
  pagmo::population population;
  Point start;
  std::vector<Point> asked;  // the batch that is out
};

PagmoSearch::PagmoSearch(v1::Optimize::Method method, const SearchSetup& setup)
    : state_(std::make_unique<State>(method, setup)) {}
PagmoSearch::~PagmoSearch() = default;

std::vector<Point> PagmoSearch::next_batch() {
  State& s = *state_;
  if (s.population.size() == 0) {
    s.asked.assign(s.size, s.start);
    for (std::size_t i = 1; i < s.size; ++i)
      for (double& coordinate : s.asked[i]) coordinate = s.first_coordinate(coordinate);
    return s.asked;
  }
  Ledger& ledger = *s.problem.ledger;
  ledger.recording = true;
  ledger.asked.clear();
  pagmo::algorithm rehearsal = s.algorithm;
  rehearsal.evolve(s.population);
  ledger.recording = false;
  s.asked = ledger.asked;
  return s.asked;
}

void PagmoSearch::take(const std::vector<Scored>& batch) {
  State& s = *state_;
  Ledger& ledger = *s.problem.ledger;
  ledger.known.clear();
  for (std::size_t i = 0; i < batch.size(); ++i)
    ledger.known[s.asked[i]] = to_minimise(batch[i], s.terms);
  if (s.population.size() == 0)
    for (std::size_t i = 0; i < batch.size(); ++i)
      s.population.push_back(s.asked[i], ledger.known.at(s.asked[i]));
  else
    s.population = s.algorithm.evolve(s.population);
  s.asked.clear();
}

json PagmoSearch::save() const {
  const State& s = *state_;
  std::ostringstream bytes;
  {
    boost::archive::binary_oarchive archive(bytes);
    archive << s.algorithm;
  }
  const std::string text = bytes.str();
  return {{"algorithm", json::binary(std::vector<std::uint8_t>(text.begin(), text.end()))},
          {"points", s.population.get_x()},
          {"fitness", s.population.get_f()},
          {"random", s.random.state()},
          {"asked", s.asked}};
}

void PagmoSearch::restore(const json& state) {
  State& s = *state_;
  const auto& bytes = state.at("algorithm").get_binary();
  std::istringstream in(std::string(bytes.begin(), bytes.end()));
  boost::archive::binary_iarchive archive(in);
  archive >> s.algorithm;
  s.random.set_state(state.at("random").get<RandomStream::State>());
  s.asked = state.at("asked").get<std::vector<Point>>();
  const auto points = state.at("points").get<std::vector<Point>>();
  const auto fitness = state.at("fitness").get<std::vector<std::vector<double>>>();
  s.population = pagmo::population(pagmo::problem(s.problem), 0u, 1u);
  for (std::size_t i = 0; i < points.size(); ++i) s.population.push_back(points[i], fitness[i]);
}

}  // namespace granary::server
