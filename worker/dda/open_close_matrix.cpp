#include "worker/dda/open_close_matrix.h"

#include <Eigen/Dense>
#include <algorithm>
#include <numeric>

namespace granary::dda {
namespace {

constexpr double kPcgTolerance =
    1e-8;  // relative residual of a Newton step, which the next one mends
constexpr int kPcgIterations = 2000;

}  // namespace

OpenCloseMatrix::OpenCloseMatrix(std::size_t block_count, std::span<const BlockPair> contacts,
                                 LinearSolver linear)
    : contacts_(contacts.begin(), contacts.end()), linear_(linear) {
  build_pattern(block_count);
}

// Column 3 i + a holds rows a..2 of the diagonal block, then three rows for each contact that block
// i has with a later block, in ascending order.
void OpenCloseMatrix::build_pattern(std::size_t block_count) {
  std::vector<std::vector<std::pair<std::int32_t, std::size_t>>> later(block_count);
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const auto [low, high] = std::minmax(contacts_[k].first, contacts_[k].second);
    if (low != kWall) later[static_cast<std::size_t>(low)].emplace_back(high, k);
  }
  offset_.assign(contacts_.size(), 0);
  const auto size = static_cast<Eigen::Index>(3 * block_count);
  std::vector<int> column_start{0}, rows;
  for (std::size_t i = 0; i < block_count; ++i) {
    std::sort(later[i].begin(), later[i].end());
    for (int a = 0; a < 3; ++a) {
      for (int b = a; b < 3; ++b) rows.push_back(static_cast<int>(3 * i) + b);
      for (const auto& [block, contact] : later[i])
        for (int b = 0; b < 3; ++b) rows.push_back(3 * block + b);
      column_start.push_back(static_cast<int>(rows.size()));
    }
    for (std::size_t rank = 0; rank < later[i].size(); ++rank)
      offset_[later[i][rank].second] = static_cast<std::int32_t>(3 * rank);
  }
  const std::vector<double> zeros(rows.size(), 0.0);
  lower_ = Eigen::Map<const Eigen::SparseMatrix<double>>(
      size, size, static_cast<Eigen::Index>(rows.size()), column_start.data(), rows.data(),
      zeros.data());
}

void OpenCloseMatrix::clear(std::span<const Eigen::Vector3d> mass) {
  std::fill_n(lower_.valuePtr(), lower_.nonZeros(), 0.0);
  for (std::size_t i = 0; i < mass.size(); ++i)
    for (int a = 0; a < 3; ++a)
      lower_.valuePtr()[lower_.outerIndexPtr()[3 * i + static_cast<std::size_t>(a)]] = mass[i][a];
}

void OpenCloseMatrix::add(std::size_t contact, double stiffness,
                          const ContactDirection& direction) {
  const auto [first, second] = contacts_[contact];
  double* values = lower_.valuePtr();
  const auto add_diagonal = [&](std::int32_t block, const Eigen::Vector3d& d) {
    for (int a = 0; a < 3; ++a) {
      double* column = values + lower_.outerIndexPtr()[3 * block + a];
      for (int b = a; b < 3; ++b) column[b - a] += stiffness * d[a] * d[b];
    }
  };
  if (first != kWall) add_diagonal(first, direction.first);
  if (second != kWall) add_diagonal(second, direction.second);
  if (first == kWall || second == kWall) return;
  const bool ordered = first < second;
  const std::int32_t low = ordered ? first : second;
  const Eigen::Vector3d& d_low = ordered ? direction.first : direction.second;
  const Eigen::Vector3d& d_high = ordered ? direction.second : direction.first;
  for (int a = 0; a < 3; ++a) {
    double* block = values + lower_.outerIndexPtr()[3 * low + a] + (3 - a) + offset_[contact];
    for (int b = 0; b < 3; ++b) block[b] += stiffness * d_low[a] * d_high[b];
  }
}

bool OpenCloseMatrix::solve(const Eigen::VectorXd& right, Eigen::VectorXd& unknowns) {
  if (linear_ == LinearSolver::pcg) return solve_pcg(right, unknowns);
  if (!analysed_) factor_.analyzePattern(lower_);
  analysed_ = true;
  factor_.factorize(lower_);
  if (factor_.info() != Eigen::Success) return false;
  unknowns = factor_.solve(right);
  return unknowns.allFinite();
}

// Conjugate gradients with the inverse of the 3 x 3 diagonal blocks as preconditioner.
bool OpenCloseMatrix::solve_pcg(const Eigen::VectorXd& right, Eigen::VectorXd& unknowns) {
  const Eigen::Index blocks = lower_.cols() / 3;
  std::vector<Eigen::Matrix3d> inverse(static_cast<std::size_t>(blocks));
  for (Eigen::Index i = 0; i < blocks; ++i) {
    Eigen::Matrix3d block;
    for (int a = 0; a < 3; ++a)
      for (int b = a; b < 3; ++b)
        block(a, b) = block(b, a) = lower_.valuePtr()[lower_.outerIndexPtr()[3 * i + a] + (b - a)];
    inverse[static_cast<std::size_t>(i)] = block.inverse();
  }
  const auto precondition = [&](const Eigen::VectorXd& r) {
    Eigen::VectorXd z(r.size());
    for (Eigen::Index i = 0; i < blocks; ++i)
      z.segment<3>(3 * i) = inverse[static_cast<std::size_t>(i)] * r.segment<3>(3 * i);
    return z;
  };
  const auto matrix = lower_.selfadjointView<Eigen::Lower>();
  Eigen::VectorXd residual = right - matrix * unknowns;
  Eigen::VectorXd direction = precondition(residual);
  double square = residual.dot(direction);
  const double limit = kPcgTolerance * kPcgTolerance * right.dot(precondition(right));
  for (int k = 0; k < kPcgIterations && square > limit; ++k, ++linear_iterations_) {
    const Eigen::VectorXd image = matrix * direction;
    const double step = square / direction.dot(image);
    unknowns += step * direction;
    residual -= step * image;
    const Eigen::VectorXd z = precondition(residual);
    const double next = residual.dot(z);
    direction = z + (next / square) * direction;
    square = next;
  }
  return square <= limit && unknowns.allFinite();
}

}  // namespace granary::dda
