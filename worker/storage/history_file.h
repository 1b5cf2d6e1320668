// The history of a study as an HDF5 file: one row per trial, in order.
//   /study                attributes name, kind, state, verdict; /study/spec its text
//   /trials/*             number, candidate, feasible, pareto, objective, objective_error,
//                         best_objective, cpu_s and the texts job, state, role
//   /inputs/<scene path>  what was varied; numbers, or texts when not every value is a number
//   /values/<key>, /errors/<key>   what came out; NaN = unknown
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "worker/storage/file_system.h"

namespace granary::storage {

struct HistoryNumbers {
  std::string name;
  std::string unit;
  std::vector<double> values;
};
struct HistoryTexts {
  std::string name;
  std::vector<std::string> values;
};

struct HistoryContent {
  std::string study, kind, state, verdict;
  std::string spec_text;
  std::vector<HistoryNumbers> trial_numbers;
  std::vector<HistoryTexts> trial_texts;
  std::vector<HistoryNumbers> inputs;
  std::vector<HistoryTexts> input_texts;
  std::vector<HistoryNumbers> values;
  std::vector<HistoryNumbers> errors;
};

// Replaces the file, by a rename once it is whole. Throws StorageError.
void write_history(const Path& path, const HistoryContent& content);

}  // namespace granary::storage
