#include "unlatch/model/subjects.h"

#include "kernel/elements/kinds/kinds.h"
#include "kernel/laws/law_steps.h"
#include "kernel/math/index.h"

namespace unlatch {
namespace {

// Gathers the indices that a kind of element passes to shift().
class SubjectLister {
 public:
  SubjectLister(const Model& model, Subjects& to) : model_(model), to_(to) {}

  void shift_body(int& body) const {
    if (body >= 0) to_.bodies.push_back(body);
  }
  void shift_bodies(int& base, int& follower) const {
    shift_body(base);
    shift_body(follower);
  }
  void shift_joint(int& joint) const { add(SubjectOf::kJoint, joint); }
  void shift_surface(int& surface) const { add(SubjectOf::kSurface, surface); }
  void shift_channel(int& channel) const {
    if (channel >= 0) to_.channels.push_back(channel);
  }
  void shift_law(int& law) const {
    if (law >= 0) to_.laws.push_back(law);
  }

 private:
  void add(SubjectOf of, int subject) const {
    if (subject < 0) return;
    for (int body : list_subject_bodies(model_, of, subject)) shift_body(body);
  }

  const Model& model_;
  Subjects& to_;
};

template <class Scaled>
void add_channels(const Scaled& own, Subjects& to) {
  for (const int channel : {own.scale_channel, own.offset_channel})
    if (channel != kNone) to.channels.push_back(channel);
}

std::vector<int> leave_out_ground(std::initializer_list<int> bodies) {
  std::vector<int> list;
  for (const int body : bodies)
    if (body != kGround) list.push_back(body);
  return list;
}

}  // namespace

std::vector<Subjects> list_element_subjects(const Model& model) {
  std::vector<Subjects> list;
  for_each_kind([&](auto kind) {
    for (auto item : kind.of(model)) {
      kind.shift(item, SubjectLister(model, list.emplace_back()));
      list.back().reads_speed = kind.reads_speed(item);
    }
  });
  return list;
}

Subjects list_law_subjects(const Model& model, const Law& law) {
  Subjects subjects;
  add_channels(law, subjects);
  for (const LawStep& step : law.steps) switch (get_operands(step.kind).of) {
      case LawSubject::kQuantity:
        subjects.quantities.push_back(step.subject);
        break;
      case LawSubject::kChannel:
        subjects.channels.push_back(step.subject);
        break;
      case LawSubject::kTable:
        add_channels(model.tables[at(step.subject)], subjects);
        break;
      case LawSubject::kUnknown:
      case LawSubject::kNothing:
      case LawSubject::kExponent:
        break;
    }
  return subjects;
}

std::vector<int> list_subject_bodies(const Model& model, SubjectOf of, int subject) {
  switch (of) {
    case SubjectOf::kNothing:
    case SubjectOf::kSignal:
    case SubjectOf::kChannel:
    case SubjectOf::kEvent:
    case SubjectOf::kLaw:
      return {};
    case SubjectOf::kBody:
    case SubjectOf::kMassLaw:
      return leave_out_ground({subject});
    case SubjectOf::kJoint:
      return leave_out_ground({model.joints[at(subject)].base, model.joints[at(subject)].follower});
    case SubjectOf::kSurface:
      return leave_out_ground({model.surfaces[at(subject)].body});
    case SubjectOf::kContact: {
      const Contact& contact = model.contacts[at(subject)];
      return leave_out_ground({model.surfaces[at(contact.base)].body, model.surfaces[at(contact.follower)].body});
    }
    case SubjectOf::kElement:
      return list_element_bodies(model, subject);
    case SubjectOf::kOneSided:
    case SubjectOf::kCord: {
      const ElementTraits traits = OneSidedKind::describe(model, model.one_sided[at(subject)]);
      return leave_out_ground({traits.base, traits.follower});
    }
  }
  return {};
}

std::vector<int> list_action_bodies(const Model& model, const Action& action) {
  switch (action.kind) {
    case Action::Kind::kSetMode:
      return list_subject_bodies(model, SubjectOf::kJoint, action.subject);
    case Action::Kind::kSwitch:
    case Action::Kind::kRamp:
      return list_subject_bodies(model, SubjectOf::kElement, action.subject);
    case Action::Kind::kImpulse:
      return {model.impulses[at(action.subject)].body};
    case Action::Kind::kRaise:   // who waits for it reads it as part of his guard
    case Action::Kind::kEngage:  // by the element's own two bodies
      return {};
  }
  return {};
}

}  // namespace unlatch
