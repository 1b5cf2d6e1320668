// Feeds a fuzz target the files of a folder and random mutations of them, the same ones each time:
//   fuzz_NAME --rounds N CORPUS
// Finds what a moment finds; the search that learns from coverage is libFuzzer's (tests/long.sh).
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Random = std::mt19937_64;

std::vector<std::string> corpus_of(const std::string& folder) {
  std::vector<std::string> inputs{""};
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream in(entry.path(), std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    inputs.push_back(text.str());
  }
  std::sort(inputs.begin(), inputs.end());  // the order of a folder is not ours
  return inputs;
}

std::size_t below(Random& random, std::size_t end) { return end == 0 ? 0 : random() % end; }

std::string mutated(std::string input, const std::string& other, Random& random) {
  static const std::vector<std::string> kTokens = {"-1", "nan", "inf", "1e308", "1e-308", "0", "\"", "{", "}",
                                                   "[",  "]",   ":",   "\0",    "\xff\xff", "18446744073709551616"};
  for (std::size_t edits = 1 + below(random, 4); edits > 0; --edits) {
    const std::size_t at = below(random, input.size() + 1);
    switch (random() % 5) {
      case 0: if (!input.empty()) input[below(random, input.size())] = static_cast<char>(random()); break;
      case 1: input.insert(at, kTokens[below(random, kTokens.size())]); break;
      case 2: input.erase(at, 1 + below(random, 20)); break;
      case 3: input.insert(at, other.substr(below(random, other.size() + 1), 1 + below(random, 60))); break;
      default: input.insert(at, input.substr(below(random, input.size() + 1), 1 + below(random, 60)));
    }
  }
  return input;
}

void run(const std::string& input) {
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4 || std::string(argv[1]) != "--rounds") {
    std::fprintf(stderr, "usage: %s --rounds N CORPUS\n", argv[0]);
    return 2;
  }
  const std::vector<std::string> corpus = corpus_of(argv[3]);
  for (const std::string& input : corpus) run(input);
  Random random(1);
  const long rounds = std::atol(argv[2]);
  for (long i = 0; i < rounds; ++i)
    run(mutated(corpus[below(random, corpus.size())], corpus[below(random, corpus.size())], random));
  std::printf("%ld inputs\n", rounds + static_cast<long>(corpus.size()));
  return 0;
}
