#include "server/studies/search_method.h"

#include "server/studies/gradual_deformation.h"
#include "server/studies/pagmo_search.h"
#include "server/studies/random_search.h"

namespace granary::server {

std::unique_ptr<SearchMethod> make_search(const v1::Optimize& settings, const SearchSetup& setup) {
  switch (settings.method()) {
    case v1::Optimize::CMA_ES:
    case v1::Optimize::NSGA_II:
      return std::make_unique<PagmoSearch>(settings.method(), setup);
    case v1::Optimize::RANDOM_SEARCH:
      return std::make_unique<RandomSearch>(setup);
    default:
      return std::make_unique<GradualDeformation>(settings.gradual_deformation(), setup);
  }
}

}  // namespace granary::server
