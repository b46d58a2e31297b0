#include "hil/scenario/yaml/scenario_error.h"

#include <algorithm>
#include <set>
#include <tuple>

namespace unlatch::hil {
namespace {

std::string join_lines(const std::vector<ScenarioMistake>& mistakes) {
  std::string text;
  for (const ScenarioMistake& mistake : mistakes) text += (text.empty() ? "" : "\n") + mistake.to_string();
  return text;
}

}  // namespace

std::string ScenarioMistake::to_string() const {
  const std::string place = std::to_string(mark.line) + ":" + std::to_string(mark.column);
  const bool blamed = !override_text.empty() && mark.line > 0;  // the text is correct without that override
  std::string text = file;
  if (!override_text.empty())
    text += ": --set " + override_text;
  else if (mark.line > 0)
    text += ":" + place;
  return text + ": " + what + (blamed ? " (at " + place + ")" : "") + (mend.empty() ? "" : "; " + mend);
}

ScenarioError::ScenarioError(std::vector<ScenarioMistake> mistakes_in)
    : std::runtime_error(join_lines(mistakes_in)), mistakes(std::move(mistakes_in)) {}

int Mistakes::add_file(std::string name) {
  files_.push_back(std::move(name));
  return static_cast<int>(files_.size()) - 1;
}

int Mistakes::add_instance(std::string description) {
  instances_.push_back(std::move(description));
  return static_cast<int>(instances_.size()) - 1;
}

int Mistakes::add_override(std::string text) {
  overrides_.push_back(std::move(text));
  return static_cast<int>(overrides_.size()) - 1;
}

std::string Mistakes::describe(const SourceMark& mark, const SourceMark& from) const {
  const std::string file = mark.file == from.file ? "" : "in " + files_.at(static_cast<std::size_t>(mark.file)) + " ";
  return file + "on line " + std::to_string(mark.line);
}

void Mistakes::add(const SourceMark& mark, std::string what, std::string mend) {
  ScenarioMistake mistake{files_.at(static_cast<std::size_t>(mark.file)), mark, "", std::move(what), std::move(mend)};
  if (mark.override_index >= 0) mistake.override_text = overrides_.at(static_cast<std::size_t>(mark.override_index));
  list_.push_back(std::move(mistake));
}

void Mistakes::throw_if_any() {
  if (list_.empty()) return;
  const auto place = [](const ScenarioMistake& m) {
    return std::make_tuple(m.mark.override_index, m.mark.file, m.mark.line, m.mark.column);
  };
  std::stable_sort(list_.begin(), list_.end(), [&](const auto& a, const auto& b) { return place(a) < place(b); });
  fold_instances();
  fold_repeated();
  throw ScenarioError(list_);
}

// Keeps, for each place in a template, the mistakes of the first instance that has any; the others are counted.
void Mistakes::fold_instances() {
  std::vector<ScenarioMistake> kept;
  for (std::size_t i = 0; i < list_.size();) {
    const SourceMark first = list_[i].mark;
    std::set<int> others;
    const std::size_t begin = kept.size();
    for (; i < list_.size(); ++i) {
      const SourceMark& mark = list_[i].mark;
      if (mark.override_index != first.override_index || mark.file != first.file || mark.line != first.line ||
          mark.column != first.column)
        break;
      if (mark.instance == first.instance)
        kept.push_back(list_[i]);
      else
        others.insert(mark.instance);
    }
    if (first.instance < 0) continue;
    std::string where = " (" + instances_.at(static_cast<std::size_t>(first.instance));
    if (!others.empty()) where += ", and " + std::to_string(others.size()) + " more";
    for (std::size_t k = begin; k < kept.size(); ++k) kept[k].what += where + ")";
  }
  list_ = std::move(kept);
}

// Reports a mistake that several rows of parameters share only once.
void Mistakes::fold_repeated() {
  std::vector<ScenarioMistake> kept;
  std::vector<std::size_t> counts;
  for (ScenarioMistake& mistake : list_) {
    std::size_t same = kept.size();
    for (std::size_t i = kept.size(); i-- > 0 && kept[i].mark.line == mistake.mark.line && same == kept.size();)
      if (kept[i].to_string() == mistake.to_string()) same = i;
    if (same < kept.size()) {
      ++counts[same];
    } else {
      kept.push_back(std::move(mistake));
      counts.push_back(0);
    }
  }
  for (std::size_t i = 0; i < kept.size(); ++i)
    if (counts[i] > 0) kept[i].what += " (and " + std::to_string(counts[i]) + " more)";
  list_ = std::move(kept);
}

}  // namespace unlatch::hil
