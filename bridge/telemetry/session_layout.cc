#include "bridge/telemetry/session_layout.h"

#include <algorithm>

#include "hil/scenario/text/utf8.h"
#include "unlatch/model.h"

namespace unlatch::bridge {
namespace {

std::size_t at(hil::CatalogKind kind) { return static_cast<std::size_t>(kind); }

// Entries of a part, of a list that is cut into parts of `whole`.
std::size_t count_in_part(std::size_t count, std::size_t whole, int part) {
  const std::size_t first = static_cast<std::size_t>(part) * whole;
  return count > first ? std::min(count - first, whole) : 0;
}
int count_parts(std::size_t count, std::size_t whole) { return static_cast<int>((count + whole - 1) / whole); }

// Text from outside: control characters and bytes that are not UTF-8 become '?'.
std::string clean(std::span<const std::uint8_t> from) {
  std::string text(hil::get_name(from));
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = hil::get_utf8_length(text, i);
    if (length == 0 || static_cast<unsigned char>(text[i]) < ' ' || text[i] == 0x7f) text[i] = '?';
    i += std::max<std::size_t>(1, length);
  }
  return text;
}

}  // namespace

std::string SessionLayout::get_scenario() const { return clean(hello_.scenario); }

const std::vector<LayoutItem>& SessionLayout::list(hil::CatalogKind kind) const { return items_[at(kind)]; }

bool SessionLayout::is_complete() const { return hello_.session != 0 && missing_ == 0; }

bool SessionLayout::hear(const hil::Message& message) {
  if (message.kind == hil::MessageKind::kHello) {
    const bool is_new = message.hello.session != hello_.session;
    hello_ = message.hello;
    if (is_new) expect();
    return is_new;
  }
  if (message.kind != hil::MessageKind::kCatalog || message.catalog.session != hello_.session) return false;
  const hil::CatalogMessage& item = message.catalog;
  std::vector<LayoutItem>& list = items_[static_cast<std::size_t>(item.kind)];  // in range: is_well_formed()
  const auto index = static_cast<std::size_t>(item.index);
  if (index >= list.size() || hil::get_name(item.name).empty()) return false;
  if (list[index].name.empty()) --missing_;
  list[index] = {clean(item.name), clean(item.unit)};
  return false;
}

bool SessionLayout::take_modes(const Model& model) {
  const std::vector<LayoutItem>& joints = list(hil::CatalogKind::kJoint);
  // A name that is too long for a message is there in part.
  if (!std::ranges::equal(joints, model.joints, [](const LayoutItem& item, const Joint& joint) {
        return !item.name.empty() && joint.name.starts_with(item.name);
      }))
    return false;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    modes_[i].clear();
    for (const auto& mode : model.joints[i].modes) modes_[i].push_back(mode.name);
  }
  return true;
}

void SessionLayout::expect() {
  const std::int32_t counts[] = {hello_.body_count,   hello_.joint_count,  hello_.channel_count,
                                 hello_.sensor_count, hello_.signal_count, hello_.participant_count};
  missing_ = 0;
  modes_.clear();
  for (std::size_t i = 0; i < items_.size(); ++i) {
    items_[i].assign(static_cast<std::size_t>(counts[i]), {});
    missing_ += items_[i].size();
  }
}

int SessionLayout::count_state_parts() const {
  return std::max({1, count_parts(items_[at(hil::CatalogKind::kBody)].size(), hil::kBodiesPerPart),
                   count_parts(items_[at(hil::CatalogKind::kSensor)].size(), hil::kSensorsPerPart),
                   count_parts(items_[at(hil::CatalogKind::kJoint)].size(), hil::kJointsPerPart)});
}

int SessionLayout::count_reaction_parts() const {
  return count_parts(6 * items_[at(hil::CatalogKind::kJoint)].size(), hil::kReactionsPerPart);
}

std::size_t SessionLayout::count_valid(hil::MessageKind kind, std::string_view field, int part) const {
  const auto count = [&](hil::CatalogKind of, std::size_t each, std::size_t whole) {
    return count_in_part(each * items_[at(of)].size(), whole, part);
  };
  if (kind == hil::MessageKind::kReactions) return count(hil::CatalogKind::kJoint, 6, hil::kReactionsPerPart);
  if (field == "bodies") return count(hil::CatalogKind::kBody, 1, hil::kBodiesPerPart);
  if (field == "sensors") return count(hil::CatalogKind::kSensor, 1, hil::kSensorsPerPart);
  return count(hil::CatalogKind::kJoint, 1, hil::kJointsPerPart);
}

}  // namespace unlatch::bridge
