#include "library/c/catalogue.h"

#include <algorithm>
#include <cstring>

#include "hil/scenario/measurable.h"
#include "hil/scenario/quantities.h"
#include "library/c/errors.h"

namespace unlatch::library {

Catalogue::Catalogue(const hil::Scenario& scenario) {
  const Model& model = scenario.model;
  const auto name_body = [&](int body) {
    return body == kGround ? std::string("ground") : model.bodies[static_cast<std::size_t>(body)].name;
  };
  for (const Body& body : model.bodies) add(UNLATCH_BODY, body.name, "", "");
  for (const Joint& joint : model.joints) {
    unlatch_item& item = add(UNLATCH_JOINT, joint.name, "", name_body(joint.base) + " – " + name_body(joint.follower));
    item.width = static_cast<std::int32_t>(joint.modes.size());
    item.a = joint.base;
    item.b = joint.follower;
    std::vector<std::string>& names = modes_.emplace_back();
    for (const JointMode& mode : joint.modes) names.push_back(mode.name);
  }
  for (const Channel& channel : model.channels) {
    unlatch_item& item = add(UNLATCH_CHANNEL, channel.name, channel.unit, "");
    item.initial = channel.initial;
    item.minimum = channel.minimum;
    item.maximum = channel.maximum;
    item.safe = channel.safe;
    item.width = 1;
  }
  std::int32_t first = 0;
  for (const Sensor& sensor : model.sensors) {
    unlatch_item& item = add(UNLATCH_SENSOR, sensor.name, hil::get_unit(model, sensor), "");
    item.first = first;
    item.width = sensor_width(sensor.kind);
    first += item.width;
  }
  for (const std::string& signal : model.signals) add(UNLATCH_SIGNAL, signal, "1", "");
  for (const Event& event : model.events) add(UNLATCH_EVENT_KIND, event.name, "s", event.subject);
  for (const hil::Requirement& requirement : scenario.requirements) {
    unlatch_item& item = add(UNLATCH_REQUIREMENT, requirement.id, requirement.unit, requirement.text);
    item.minimum = requirement.least;
    item.maximum = requirement.most;
  }
  for (const hil::ClearancePair& pair : scenario.clearance) {
    unlatch_item& item = add(UNLATCH_CLEARANCE, pair.a.name + " – " + pair.b.name, "m", "");
    item.a = pair.a.body;
    item.b = pair.b.body;
  }
  for (const hil::Measurable& quantity : hil::list_measurables(scenario))
    add(UNLATCH_QUANTITY, quantity.name, quantity.unit, quantity.text);
  for (const hil::NamedConstant& constant : scenario.constants)
    add(UNLATCH_CONSTANT, constant.name, hil::describe_unit(constant.value.dimension), "constants." + constant.name)
        .initial = constant.value.value;
  for (const hil::WrittenNumber& number : scenario.numbers)
    add(UNLATCH_NUMBER, number.path, number.unit, "").initial = number.value;
}

unlatch_item& Catalogue::add(std::int32_t kind, std::string name, std::string unit, std::string text) {
  const Texts& texts =
      *texts_.emplace_back(std::make_unique<Texts>(Texts{std::move(name), std::move(unit), std::move(text)}));
  unlatch_item item{};
  item.size = sizeof item;
  item.name = texts.name.c_str();
  item.unit = texts.unit.c_str();
  item.text = texts.text.c_str();
  item.a = item.b = -1;
  return items_[static_cast<std::size_t>(kind)].emplace_back(item);
}

int Catalogue::find(std::int32_t kind, const std::string& name) const {
  const std::vector<unlatch_item>& items = get(kind);
  int found = -1;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (kind == UNLATCH_EVENT_KIND && name == std::string(items[i].name) + ":" + items[i].text)
      return static_cast<int>(i);
    if (name == items[i].name) found = found == -1 ? static_cast<int>(i) : -2;
  }
  return found;
}

unlatch_status Catalogue::count(std::int32_t kind, std::size_t* count) const {
  if (count == nullptr) return fail(UNLATCH_ERROR_ARGUMENT, "null: the place for the number of items");
  if (!is_kind(kind)) return fail(UNLATCH_ERROR_ARGUMENT, "a kind of items that is unknown: " + std::to_string(kind));
  *count = get(kind).size();
  return UNLATCH_OK;
}

unlatch_status Catalogue::describe(std::int32_t kind, std::size_t index, unlatch_item* item) const {
  if (item == nullptr) return fail(UNLATCH_ERROR_ARGUMENT, "null: the place for the item");
  if (!is_kind(kind)) return fail(UNLATCH_ERROR_ARGUMENT, "a kind of items that is unknown: " + std::to_string(kind));
  if (item->size < offsetof(unlatch_item, text))
    return fail(UNLATCH_ERROR_ARGUMENT, "unlatch_item::size is not set; set it to sizeof(unlatch_item)");
  if (index >= get(kind).size()) {
    return fail(UNLATCH_ERROR_RANGE, "item " + std::to_string(index) + " of " + std::to_string(get(kind).size()));
  }
  const std::size_t size = item->size;
  std::memcpy(item, &get(kind)[index], std::min(size, sizeof(unlatch_item)));
  item->size = size;
  return UNLATCH_OK;
}

}  // namespace unlatch::library
