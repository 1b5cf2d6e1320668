#include "worker/storage/history_file.h"

#include "worker/storage/hdf5_file_writer.h"

namespace granary::storage {
namespace {

// A number or name in a path of our own: scene paths hold dots and brackets, never slashes.
void write_numbers(hdf5::FileWriter& file, const std::string& group,
                   const std::vector<HistoryNumbers>& columns) {
  for (const HistoryNumbers& column : columns) {
    const auto bytes = core::make_column<double>(column.name, column.unit, column.values);
    file.write_column(group + "/" + column.name, core::view_of(bytes));
  }
}

void write_texts(hdf5::FileWriter& file, const std::string& group,
                 const std::vector<HistoryTexts>& columns) {
  for (const HistoryTexts& column : columns)
    file.write_texts(group + "/" + column.name, column.values);
}

void write_content(hdf5::FileWriter& file, const HistoryContent& content) {
  for (const char* group : {"/study", "/trials", "/inputs", "/values", "/errors"})
    file.create_group(group);
  file.set_attribute("/study", "name", content.study);
  file.set_attribute("/study", "kind", content.kind);
  file.set_attribute("/study", "state", content.state);
  file.set_attribute("/study", "verdict", content.verdict);
  file.write_text("/study/spec", content.spec_text);
  write_numbers(file, "/trials", content.trial_numbers);
  write_texts(file, "/trials", content.trial_texts);
  write_numbers(file, "/inputs", content.inputs);
  write_texts(file, "/inputs", content.input_texts);
  write_numbers(file, "/values", content.values);
  write_numbers(file, "/errors", content.errors);
}

}  // namespace

void write_history(const Path& path, const HistoryContent& content) {
  FileSystem& files = real_file_system();
  const Path temporary = path.string() + ".tmp";
  hdf5::FileWriter file(temporary);
  write_content(file, content);
  file.finish();
  files.sync_file(temporary);
  files.rename(temporary, path);
}

}  // namespace granary::storage
