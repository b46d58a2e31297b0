#include "kernel/compile/join.h"

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "kernel/elements/kinds/kinds.h"
#include "kernel/math/index.h"
#include "unlatch/quantities.h"

namespace unlatch {
namespace {

// Appends models to one. Indices of an appended model are raised by the number of items before its own.
class Joiner {
 public:
  explicit Joiner(std::span<const Model* const> models) : models_(models.begin(), models.end()) {
    joined_.name = models_.front()->name;
    joined_.gravity = models_.front()->gravity;
    joined_.environment = models_.front()->environment;
    joined_.contact_substeps = models_.front()->contact_substeps;
  }

  Model join() && {
    for (number_ = 0; number_ < models_.size(); ++number_) append(complete_events(*models_[number_]));
    return std::move(joined_);
  }

  // Raises indices of an element by those of the models before its own; the ground and "none" stay.
  void shift_body(int& body) const { body = shift(body, bodies_); }
  void shift_bodies(int& base, int& follower) const {
    shift_body(base);
    shift_body(follower);
  }
  void shift_joint(int& joint) const { joint = shift(joint, joints_); }
  void shift_surface(int& surface) const { surface = shift(surface, surfaces_); }
  void shift_channel(int& channel) const { channel = shift(channel, channels_); }
  void shift_law(int& law) const { law = shift(law, laws_); }

 private:
  template <class Item>
  static int count(const std::vector<Item>& list) {
    return static_cast<int>(list.size());
  }
  static int shift(int index, int by) { return index < 0 ? index : index + by; }  // the ground and "none" stay
  std::string rename(const std::string& name) const { return std::to_string(number_) + "." + name; }

  // Appends a list, after `change` to each item.
  template <class Item, class Change>
  static void append(const std::vector<Item>& from, std::vector<Item>& to, const Change& change) {
    for (Item item : from) {
      change(item);
      to.push_back(std::move(item));
    }
  }

  void append(const Model& model) {
    const Model& j = joined_;
    bodies_ = count(j.bodies), joints_ = count(j.joints), surfaces_ = count(j.surfaces), contacts_ = count(j.contacts);
    one_sided_ = count(j.one_sided), channels_ = count(j.channels), signals_ = count(j.signals);
    impulses_ = count(j.impulses), events_ = count(j.events), quantities_ = count(j.quantities);
    tables_ = count(j.tables), laws_ = count(j.laws);
    find_elements(model);
    append_bodies(model);
    append_elements(model);
    append_interfaces(model);
    append_laws(model);
    append(model.events, joined_.events, [&](Event& e) {
      e.name = rename(e.name);
      change(e.when);
      for (Action& action : e.then) change(action);
    });
  }

  // Numbers of the model's elements in the joined model, in which all of one kind follow each other.
  void find_elements(const Model& model) {
    std::array<int, kElementKinds> all{}, before{};
    for (std::size_t m = 0; m < models_.size(); ++m) {
      const std::array<int, kElementKinds> counts = count_elements(*models_[m]);
      for (std::size_t kind = 0; kind < kElementKinds; ++kind) {
        all[kind] += counts[kind];
        if (m < number_) before[kind] += counts[kind];
      }
    }
    elements_.clear();
    const std::array<int, kElementKinds> own = count_elements(model);
    for (std::size_t kind = 0, first = 0; kind < kElementKinds; first += static_cast<std::size_t>(all[kind++]))
      for (int i = 0; i < own[kind]; ++i) elements_.push_back(static_cast<int>(first) + before[kind] + i);
  }

  void append_bodies(const Model& model) {
    append(model.bodies, joined_.bodies, [&](Body& b) {
      b.name = rename(b.name);
      if (b.marker) b.marker->body += bodies_;
    });
    append(model.joints, joined_.joints, [&](Joint& j) {
      j.name = rename(j.name);
      j.base = shift(j.base, bodies_);
      j.follower = shift(j.follower, bodies_);
    });
  }

  void append_elements(const Model& model) {
    append(model.surfaces, joined_.surfaces, [&](Surface& s) {
      s.name = rename(s.name);
      s.body = shift(s.body, bodies_);
    });
    for_each_kind([&](auto kind) {
      append(kind.of(model), kind.of(joined_), [&](auto& item) {
        item.name = rename(item.name);
        kind.shift(item, *this);
      });
    });
  }

  void append_interfaces(const Model& model) {
    append(model.channels, joined_.channels, [&](Channel& c) { c.name = rename(c.name); });
    append(model.signals, joined_.signals, [&](std::string& s) { s = rename(s); });
    append(model.quantities, joined_.quantities, [&](Quantity& q) { change(q); });
    append(model.sensors, joined_.sensors, [&](Sensor& s) {
      s.name = rename(s.name);
      change_subjects(s, s.other);
    });
    append(model.impulses, joined_.impulses, [&](Impulse& i) {
      i.body += bodies_;
      i.channel = shift(i.channel, channels_);
    });
  }

  void append_laws(const Model& model) {
    const auto change_channels = [&](auto& item) {
      shift_channel(item.scale_channel);
      shift_channel(item.offset_channel);
    };
    append(model.tables, joined_.tables, [&](Table& t) {
      t.name = rename(t.name);
      change_channels(t);
    });
    append(model.laws, joined_.laws, [&](Law& l) {
      l.name = rename(l.name);
      change_channels(l);
      for (LawStep& step : l.steps) {
        if (step.kind == LawStep::Kind::kQuantity) step.subject += quantities_;
        if (step.kind == LawStep::Kind::kCommand) step.subject += channels_;
        if (step.kind == LawStep::Kind::kTable) step.subject += tables_;
      }
    });
  }

  // The number by which indices of these subjects are raised; those of elements are not raised by one number.
  int get_shift(SubjectOf of) const {
    switch (of) {
      case SubjectOf::kNothing:
      case SubjectOf::kElement:
        return 0;
      case SubjectOf::kBody:
      case SubjectOf::kMassLaw:
        return bodies_;
      case SubjectOf::kJoint:
        return joints_;
      case SubjectOf::kSurface:
        return surfaces_;
      case SubjectOf::kContact:
        return contacts_;
      case SubjectOf::kOneSided:
      case SubjectOf::kCord:
        return one_sided_;
      case SubjectOf::kSignal:
        return signals_;
      case SubjectOf::kChannel:
        return channels_;
      case SubjectOf::kEvent:
        return events_;
      case SubjectOf::kLaw:
        return laws_;
    }
    return 0;
  }

  void change(Quantity& quantity) const {
    const QuantityTraits& traits = get_traits(quantity.kind);
    quantity.name = rename(quantity.name);
    quantity.subject = traits.of == SubjectOf::kElement ? elements_[at(quantity.subject)]
                                                        : shift(quantity.subject, get_shift(traits.of));
    quantity.other = shift(quantity.other, get_shift(traits.other));
  }

  // Raises the index `subject` of a condition or sensor, and the one of the second surface.
  template <class Item>
  void change_subjects(Item& item, int& other) const {
    if (item.kind == Item::Kind::kQuantity) {
      item.subject += quantities_;
      return;
    }
    const QuantityTraits& traits = get_traits(get_quantity(joined_, item).kind);
    item.subject = shift(item.subject, get_shift(traits.of));
    if (traits.other == SubjectOf::kSurface) other += surfaces_;
  }

  void change(Condition& condition) const {
    change_subjects(condition, condition.axis);
    for (Condition& part : condition.parts) change(part);
  }

  void change(Action& action) const {
    switch (action.kind) {
      case Action::Kind::kSetMode:
        action.subject += joints_;
        break;
      case Action::Kind::kSwitch:
      case Action::Kind::kRamp:
        action.subject = elements_[at(action.subject)];
        break;
      case Action::Kind::kRaise:
        action.subject += signals_;
        break;
      case Action::Kind::kImpulse:
        action.subject += impulses_;
        break;
      case Action::Kind::kEngage:
        action.subject += one_sided_;
        break;
    }
  }

  std::vector<const Model*> models_;
  std::size_t number_ = 0;  // of the model that is being appended
  Model joined_;
  // Numbers of items of the models before it, by which its indices are raised; its elements' numbers in the joined
  // model.
  int bodies_ = 0, joints_ = 0, surfaces_ = 0, contacts_ = 0, one_sided_ = 0, channels_ = 0, signals_ = 0,
      impulses_ = 0, events_ = 0, quantities_ = 0, tables_ = 0, laws_ = 0;
  std::vector<int> elements_;
};

}  // namespace

std::array<int, kElementKinds> count_elements(const Model& model) {
  std::array<int, kElementKinds> counts{};
  std::size_t number = 0;
  for_each_kind([&](auto kind) { counts[number++] = static_cast<int>(kind.of(model).size()); });
  return counts;
}

Model join_models(std::span<const Model* const> models) { return Joiner(models).join(); }

}  // namespace unlatch
