#include "hil/study/sampling/sobol.h"

#include <boost/random/sobol.hpp>

namespace unlatch::hil {

std::vector<std::uint64_t> calc_sobol(std::size_t dimensions, std::uint64_t index) {
  boost::random::sobol sequence(dimensions);  // its first number belongs to element 1; the 0th is the origin
  std::vector<std::uint64_t> words(dimensions);
  if (index == 0) return words;
  sequence.seed(index - 1);
  for (std::uint64_t& word : words) word = sequence();
  return words;
}

}  // namespace unlatch::hil
