#include "kernel/elements/kinds/kinds.h"

#include <stdexcept>

namespace unlatch {
namespace {

// Result of `use(kind, item)` for the element with this number.
template <class Result, class Use>
Result visit(const ElementLists& lists, int element, const Use& use) {
  std::size_t index = static_cast<std::size_t>(element);
  std::optional<Result> found;
  for_each_kind([&](auto kind) {
    const auto& list = kind.of(lists);
    if (!found && element >= 0 && index < list.size()) found = use(kind, list[index]);
    index -= list.size();
  });
  if (!found) throw std::out_of_range("element " + std::to_string(element));
  return *found;
}

}  // namespace

int ElementLists::element_count() const {
  std::size_t count = 0;
  for_each_kind([&](auto kind) { count += kind.of(*this).size(); });
  return static_cast<int>(count);
}

const std::string& ElementLists::element_name(int element) const {
  return *visit<const std::string*>(*this, element, [](auto, const auto& item) { return &item.name; });
}

ElementTraits describe_element(const Model& model, int element) {
  return visit<ElementTraits>(model, element, [&](auto kind, const auto& item) {
    ElementTraits traits = kind.describe(model, item);
    traits.on = item.on;
    return traits;
  });
}

std::vector<int> list_element_bodies(const Model& model, int element) {
  const ElementTraits traits = describe_element(model, element);
  std::vector<int> bodies;
  for (const int body : {traits.base, traits.follower})
    if (body != kGround) bodies.push_back(body);
  return bodies;
}

ElementStart calc_element_start(const Model& model, int element) {
  return visit<ElementStart>(model, element, [&](auto kind, const auto& item) { return kind.start(model, item); });
}

}  // namespace unlatch
