#include "hil/study/sampling/sobol.h"

#include <stdexcept>

#include "hil/study/sampling/sampling.h"

#ifdef UNLATCH_BOOST
#include <boost/random/sobol.hpp>
#endif

namespace unlatch::hil {

#ifdef UNLATCH_BOOST

bool has_sobol() { return true; }

std::vector<std::uint64_t> calc_sobol(std::size_t dimensions, std::uint64_t index) {
  boost::random::sobol sequence(dimensions);  // its first number belongs to element 1; the 0th is the origin
  std::vector<std::uint64_t> words(dimensions);
  if (index == 0) return words;
  sequence.seed(index - 1);
  for (std::uint64_t& word : words) word = sequence();
  return words;
}

#else

bool has_sobol() { return false; }

std::vector<std::uint64_t> calc_sobol(std::size_t, std::uint64_t) {
  throw std::runtime_error("this program was built without Boost, which has the Sobol' sequence");
}

#endif

}  // namespace unlatch::hil
