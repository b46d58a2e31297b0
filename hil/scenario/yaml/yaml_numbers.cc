#include "hil/scenario/yaml/yaml_numbers.h"

#include <unordered_map>

namespace unlatch::hil {
namespace {

bool names_a_constant(const YamlNode& node) {
  try {
    (void)evaluate_expression(node.text, {});
    return false;
  } catch (const ExpressionError&) {
    return true;
  }
}

class Walker {
 public:
  explicit Walker(const Mistakes& mistakes) {
    for (const NumberRead& number : mistakes.numbers()) read_.emplace(number.node, &number);
  }

  void walk(const YamlNode& node, const std::string& path) {
    if (const auto at = read_.find(&node); at != read_.end() && !names_a_constant(node))
      found_.push_back({path, at->second->unit, at->second->value});
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      const std::string& key = node.is_mapping() ? node.keys[i].text : "";
      walk(node.items[i], node.is_sequence() ? path + "[" + std::to_string(i) + "]"
                          : path.empty()     ? key
                                             : path + "." + key);
    }
  }
  std::vector<WrittenNumber> take() { return std::move(found_); }

 private:
  std::unordered_map<const YamlNode*, const NumberRead*> read_;
  std::vector<WrittenNumber> found_;
};

}  // namespace

std::vector<WrittenNumber> list_written_numbers(const YamlNode& root, const Mistakes& mistakes) {
  Walker walker(mistakes);
  walker.walk(root, "");
  return walker.take();
}

}  // namespace unlatch::hil
