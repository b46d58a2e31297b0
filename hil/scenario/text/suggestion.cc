#include "hil/scenario/text/suggestion.h"

#include <algorithm>

namespace unlatch::hil {
namespace {

// Levenshtein distance.
std::size_t calc_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row[b.size()];
}

}  // namespace

std::string to_lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + ('a' - 'A'));
  return text;
}

const std::string* find_nearest(const std::string& wrong, const std::vector<std::string>& known, std::size_t limit) {
  if (known.empty() || wrong.size() > 64) return nullptr;
  const auto nearest = std::min_element(known.begin(), known.end(), [&](const auto& a, const auto& b) {
    return calc_distance(wrong, a) < calc_distance(wrong, b);
  });
  return calc_distance(wrong, *nearest) <= limit ? &*nearest : nullptr;
}

std::string suggest(const std::string& wrong, const std::vector<std::string>& known) {
  constexpr std::size_t kListed = 96;  // listed names; the rest is counted
  if (known.empty()) return "there are none";
  const std::string* const nearest = find_nearest(wrong, known, std::max<std::size_t>(2, wrong.size() / 3));
  std::string text = nearest ? "did you mean '" + *nearest + "'? known: " : "known: ";
  for (std::size_t i = 0; i < std::min(known.size(), kListed); ++i) text += (i > 0 ? ", " : "") + known[i];
  if (known.size() > kListed) text += " and " + std::to_string(known.size() - kListed) + " more";
  return text;
}

}  // namespace unlatch::hil
