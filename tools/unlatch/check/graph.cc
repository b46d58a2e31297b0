#include "tools/unlatch/check/graph.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <set>

#include "tools/common/alike.h"
#include "tools/common/text.h"
#include "tools/unlatch/results/redundancy.h"
#include "unlatch/quantities.h"
#include "unlatch/readings.h"

namespace unlatch::tools {
namespace {

constexpr std::size_t kShownElements = 6;
const char* const kGrey = "#5f6b7a";

std::string escape(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (static_cast<unsigned char>(c) >= 0x20)
      out += c;
  }
  return out;
}

std::string small(const std::string& text) {
  return "<font point-size=\"9\" color=\"" + std::string(kGrey) + "\">" + text + "</font>";
}

std::string row(const std::string& text) { return "<tr><td align=\"left\">" + text + "</td></tr>"; }

// --- Structure ------------------------------------------------------------------------------------------------------

// A few names in a box, and how many more there are.
std::string list_elements(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kShownElements); ++i) text += row(small(names[i]));
  if (names.size() > kShownElements)
    text += row(small("and " + std::to_string(names.size() - kShownElements) + " more"));
  return text;
}

// Bodies and joints of which many are alike, as templates make them, share a box.
class Structure {
 public:
  Structure(const Model& model, const Plan& plan)
      : model_(model), loops_(plan.get_loops().begin(), plan.get_loops().end()) {
    for (const TreeNode& node : plan.get_tree())
      if (node.parent == kNone) roots_.insert(node.body);
    list_elements_of_bodies();
    group_bodies();
    group_joints();
  }

  std::string describe() const { return describe_bodies() + describe_joints() + describe_springs(); }

 private:
  using Texts = std::map<int, std::vector<std::string>>;

  void list_elements_of_bodies() {
    for (const Load& load : model_.loads) {
      std::string text = load.name + (load.on ? "" : " (off)");
      if (load.channel != kNone) text += " · " + model_.channels[static_cast<std::size_t>(load.channel)].name;
      loads_[load.body].push_back((load.kind == Load::Kind::kForce ? "→ " : "↻ ") + text);
    }
    for (int i = 0; i < model_.element_count(); ++i) {
      const ElementTraits traits = describe_element(model_, i);
      if (traits.joint == kNone) continue;
      springs_[traits.joint].push_back("~ " + model_.element_name(i) + (traits.angular ? " about " : " along ") +
                                       "xyz"[traits.axis % 3] + describe_note(traits) + (traits.on ? "" : " (off)"));
    }
  }

  static std::string describe_note(const ElementTraits& traits) {
    return *traits.note == 0 ? "" : std::string(" (") + traits.note + ")";
  }

  static std::string join(const Texts& texts, std::size_t of) {
    const auto found = texts.find(static_cast<int>(of));
    std::string text;
    if (found != texts.end())
      for (const std::string& part : found->second) text += part + "\n";
    return text;
  }

  void group_bodies() {
    std::vector<std::string> keys;
    for (std::size_t i = 0; i < model_.bodies.size(); ++i) {
      const Body& body = model_.bodies[i];
      keys.push_back(without_numbers(body.name + "\n" + join(loads_, i)) + to_short_text(body.mass) +
                     (roots_.count(static_cast<int>(i)) > 0 ? " root" : ""));
    }
    bodies_ = group_alike(keys);
    for (const auto& group : bodies_)
      for (const std::size_t body : group) drawn_body_[static_cast<int>(body)] = group.front();
  }

  void group_joints() {
    std::vector<std::string> keys;
    for (std::size_t i = 0; i < model_.joints.size(); ++i) {
      const Joint& joint = model_.joints[i];
      keys.push_back(without_numbers(joint.name + "\n" + join(springs_, i)) + get_node(joint.base) + "," +
                     get_node(joint.follower) + list_modes(joint) + (is_loop(i) ? " loop" : ""));
    }
    joints_ = group_alike(keys);
  }

  bool is_loop(std::size_t joint) const { return loops_.count(static_cast<std::int32_t>(joint)) > 0; }

  std::string get_node(int body) const {
    return body == kGround ? "ground" : "b" + std::to_string(drawn_body_.at(body));
  }

  static std::string list_modes(const Joint& joint) {
    std::string modes;
    for (std::size_t m = 0; m < joint.modes.size(); ++m) {
      const std::string name =
          static_cast<int>(m) == joint.mode ? "<b>" + joint.modes[m].name + "</b>" : joint.modes[m].name;
      modes += row(name + " " + small(list_rows(joint.modes[m].rows, "no rows")));
    }
    return modes;
  }

  // Elements of a group: those of its first, with # for the numbers.
  static std::string list_elements_of(const Texts& texts, const std::vector<std::size_t>& group) {
    const auto found = texts.find(static_cast<int>(group.front()));
    if (found == texts.end()) return "";
    std::vector<std::string> names = found->second;
    if (group.size() > 1)
      for (std::string& name : names) name = without_numbers(name);
    return list_elements(names);
  }

  template <typename Items>
  static std::string name_of(const std::vector<std::size_t>& group, const Items& items) {
    const std::string& first = items[group.front()].name;
    if (group.size() == 1) return "<b>" + first + "</b>";
    return "<b>" + first + " … " + items[group.back()].name + "</b>";
  }

  std::string describe_bodies() const {
    std::string dot;
    for (const auto& group : bodies_) {
      const Body& body = model_.bodies[group.front()];
      const bool root = roots_.count(static_cast<int>(group.front())) > 0;
      const std::string mass = (group.size() > 1 ? std::to_string(group.size()) + " of " : "") +
                               to_short_text(body.mass) + " kg" + (root ? ", root" : "");
      dot += "  b" + std::to_string(group.front()) + " [shape=box style=\"rounded,filled\" fillcolor=\"" +
             (root ? "#cfe0f5" : "#eef3f9") + "\" label=<<table border=\"0\" cellspacing=\"1\">" +
             row(name_of(group, model_.bodies)) + row(small(mass)) + list_elements_of(loads_, group) + "</table>>]\n";
    }
    return dot;
  }

  // A loop's joint hangs from both of its bodies; its edges have no say in the ranks, but it has one in the order.
  std::string describe_joints() const {
    std::string dot;
    bool grounded = false;
    for (const auto& group : joints_) {
      const Joint& joint = model_.joints[group.front()];
      const bool loop = is_loop(group.front());
      const std::string id = "j" + std::to_string(group.front());
      dot += "  " + id +
             " [shape=plain label=<<table border=\"1\" color=\"#c58f2a\" bgcolor=\"#fdf6e7\" cellborder=\"0\" "
             "cellspacing=\"1\" style=\"rounded\">" +
             row(name_of(group, model_.joints)) + (group.size() > 1 ? row(small(count(group.size(), "joint"))) : "") +
             (loop ? row(small(group.size() > 1 ? "each closes a loop" : "closes a loop")) : "") + list_modes(joint) +
             list_elements_of(springs_, group) + "</table>>]\n";
      grounded = grounded || joint.base == kGround;
      const std::string style = loop ? " [style=dashed]" : "";
      dot += "  " + get_node(joint.base) + " -> " + id + style + "\n  " + id + " -> " + get_node(joint.follower) +
             (loop ? " [style=dashed constraint=false]" : "") + "\n";
    }
    if (grounded) dot += "  ground [shape=box style=filled fillcolor=\"#d8d8d8\" label=\"ground\"]\n";
    return dot;
  }

  // Springs between bodies, those of one pair on one line.
  std::string describe_springs() const {
    std::map<std::pair<std::string, std::string>, std::vector<std::string>> pairs;
    for (int i = 0; i < model_.element_count(); ++i) {
      const ElementTraits traits = describe_element(model_, i);
      if (traits.joint != kNone || !traits.has_coordinate) continue;
      pairs[{get_node(traits.base), get_node(traits.follower)}].push_back(model_.element_name(i) +
                                                                          describe_note(traits));
    }
    std::string dot;
    std::size_t number = 0;
    for (const auto& [pair, names] : pairs) {
      // A box of its own: the label of an edge would be laid over other boxes.
      const std::string id = "s" + std::to_string(number++);
      dot += "  " + id +
             " [shape=plain label=<<table border=\"1\" color=\"#4a8f5c\" style=\"rounded\" cellborder=\"0\" "
             "cellspacing=\"1\">" +
             list_elements(fold(names)) + "</table>>]\n  " + pair.first + " -> " + id +
             " [color=\"#4a8f5c\" style=dotted arrowhead=none]\n  " + id + " -> " + pair.second +
             " [color=\"#4a8f5c\" style=dotted]\n";
    }
    return dot;
  }

  static std::vector<std::string> fold(const std::vector<std::string>& names) {
    std::vector<std::string> keys, folded;
    for (const std::string& name : names) keys.push_back(without_numbers(name));
    for (const auto& group : group_alike(keys)) folded.push_back(name_group(group, names));
    return folded;
  }

  const Model& model_;
  const std::set<std::int32_t> loops_;
  std::set<int> roots_;
  Texts loads_, springs_;  // of bodies, of joints
  std::vector<std::vector<std::size_t>> bodies_, joints_;
  std::map<int, std::size_t> drawn_body_;  // the first of the body's group
};

// --- Phases ---------------------------------------------------------------------------------------------------------

// Joints whose numbers alone differ share a picture: names in it have # for the number.
class Phases {
 public:
  explicit Phases(const Model& model) : model_(model) {}

  std::string describe() {
    std::map<std::string, std::vector<std::size_t>> alike;  // joints by their picture
    std::vector<std::string> order;
    for (std::size_t i = 0; i < model_.joints.size(); ++i) {
      if (model_.joints[i].modes.size() < 2) continue;
      const std::string picture = describe_machine(i);
      if (alike[picture].empty()) order.push_back(picture);
      alike[picture].push_back(i);
    }
    std::string dot;
    for (std::size_t k = 0; k < order.size(); ++k) {
      const std::vector<std::size_t>& joints = alike[order[k]];
      full_names_ = joints.size() == 1;
      dot += describe_cluster(k, joints, describe_machine(joints[0]));
    }
    return dot + describe_other_events();
  }

 private:
  std::string name(const std::string& text) const { return full_names_ ? text : without_numbers(text); }

  std::string describe_cluster(std::size_t k, const std::vector<std::size_t>& joints, std::string picture) const {
    std::string title;
    for (std::size_t i = 0; i < std::min<std::size_t>(joints.size(), 6); ++i)
      title += (i > 0 ? ", " : "") + model_.joints[joints[i]].name;
    if (joints.size() > 1) title += joints.size() > 6 ? "" : " (#: its number)";
    if (joints.size() > 6) title += " and " + std::to_string(joints.size() - 6) + " more";
    const std::string prefix = "m" + std::to_string(k) + "_";
    for (std::size_t at = 0; (at = picture.find('@', at)) != std::string::npos;) picture.replace(at, 1, prefix);
    return "  subgraph cluster_" + prefix + " { style=rounded color=\"#c58f2a\" labeljust=l label=<<b>modes of " +
           title + "</b>>\n" + picture + "  }\n";
  }

  // Nodes are @0 …: '@' becomes the cluster's prefix.
  std::string describe_machine(std::size_t index) const {
    const Joint& joint = model_.joints[index];
    std::string dot = "    @start [shape=point width=0.12]\n    @start -> @" + std::to_string(joint.mode) + "\n";
    for (std::size_t m = 0; m < joint.modes.size(); ++m)
      dot += "    @" + std::to_string(m) + " [shape=ellipse style=filled fillcolor=\"#fdf6e7\" label=<" +
             joint.modes[m].name + "<br/>" + small(list_rows(joint.modes[m].rows, "no rows")) + ">]\n";
    for (const Event& event : model_.events)
      for (const Action& action : event.then) {
        if (action.kind != Action::Kind::kSetMode || action.subject != static_cast<int>(index)) continue;
        std::set<int> from;
        for (int m = 0; m < static_cast<int>(joint.modes.size()); ++m)
          if (m != action.mode && may_hold(event.when, action.subject, m)) from.insert(m);
        const std::string label =
            " [label=<<b>" + name(event.name) + "</b><br/>" + small(describe(event.when, action.subject)) +
            (event.delay > 0 ? "<br/>" + small("after " + to_short_text(event.delay) + " s") : "") + ">]\n";
        for (const int m : from) dot += "    @" + std::to_string(m) + " -> @" + std::to_string(action.mode) + label;
      }
    return dot;
  }

  // False if the condition says that the joint is in another mode.
  static bool may_hold(const Condition& c, int joint, int mode) {
    using Kind = Condition::Kind;
    const auto part_may = [&](const Condition& part) { return may_hold(part, joint, mode); };
    if (c.kind == Kind::kMode) return c.subject != joint || c.axis == mode;
    if (c.kind == Kind::kAll) return std::all_of(c.parts.begin(), c.parts.end(), part_may);
    if (c.kind == Kind::kAny) return std::any_of(c.parts.begin(), c.parts.end(), part_may);
    if (c.kind == Kind::kNot) {
      const Condition& part = c.parts.at(0);
      return !(part.kind == Kind::kMode && part.subject == joint && part.axis == mode);
    }
    return true;
  }

  // The condition in words, without its part about the modes of `joint`, which the picture shows by itself.
  std::string describe(const Condition& c, int joint) const {
    using Kind = Condition::Kind;
    if (c.kind == Kind::kNot) return "not (" + describe(c.parts.at(0), joint) + ")";
    if (c.kind != Kind::kAll && c.kind != Kind::kAny) {
      const Quantity quantity = get_quantity(model_, c);
      const QuantityTraits& traits = get_traits(quantity.kind);
      const bool compares = !traits.holds || c.kind == Kind::kQuantity, own = c.subject == joint;
      if (c.kind == Kind::kTime) return "t = " + to_short_text(c.threshold) + " s";
      if (c.kind == Kind::kMode && own) return "";
      if (c.kind == Kind::kReach)
        return name(model_.one_sided[static_cast<std::size_t>(c.subject)].name) +
               (c.below ? " at its end" : " reached");
      const bool of_joint = traits.of == SubjectOf::kJoint && c.kind != Kind::kQuantity;
      return name(unlatch::describe(model_, quantity, !(of_joint && own))) +
             (compares ? (c.below ? " &lt; " : " &gt; ") + to_short_text(c.threshold) : "");
    }
    std::string text;
    for (const Condition& part : c.parts) {
      const std::string words = describe(part, joint);
      if (!words.empty()) text += (text.empty() ? "" : c.kind == Kind::kAll ? " and " : " or ") + words;
    }
    return text;
  }

  std::string describe(const Action& a) const {
    const auto index = static_cast<std::size_t>(a.subject);
    if (a.kind == Action::Kind::kRaise) return "raise " + name(model_.signals[index]);
    if (a.kind == Action::Kind::kSetMode)
      return name(model_.joints[index].name) + " " + model_.joints[index].modes[static_cast<std::size_t>(a.mode)].name;
    if (a.kind == Action::Kind::kImpulse)
      return "impulse on " + name(get_body_name(model_, model_.impulses[index].body));
    if (a.kind == Action::Kind::kEngage)
      return name(model_.one_sided[index].name) + (a.value != 0 ? " acts" : " acts no longer");
    return name(model_.element_name(a.subject)) +
           (a.value == 0   ? " off"
            : a.value == 1 ? " on"
                           : " to " + to_short_text(a.value)) +
           (a.kind == Action::Kind::kRamp ? " over " + to_short_text(a.duration) + " s" : "");
  }

  std::string describe_event(const Event& event, bool full_names) {
    full_names_ = full_names;
    std::string actions;
    for (const Action& action : event.then) actions += (actions.empty() ? "" : ", ") + describe(action);
    const std::string delay = event.delay > 0 ? ", " + to_short_text(event.delay) + " s later" : "";
    return row("<b>" + name(event.name) + "</b> " + small(describe(event.when, kNone) + delay)) +
           row("&#160;&#160;" + actions);
  }

  // The other events with their conditions; events that differ only in a number appear once.
  std::string describe_other_events() {
    std::vector<std::string> order;
    std::map<std::string, std::vector<const Event*>> alike;
    for (const Event& event : model_.events) {
      const bool only_modes = std::all_of(event.then.begin(), event.then.end(),
                                          [](const Action& a) { return a.kind == Action::Kind::kSetMode; });
      if (only_modes) continue;
      const std::string line = describe_event(event, false);
      if (alike[line].empty()) order.push_back(line);
      alike[line].push_back(&event);
    }
    if (order.empty()) return "";
    std::string dot =
        std::string("  events [shape=plain label=<<table border=\"1\" color=\"#8a94a6\" cellborder=\"0\" ") +
        "cellspacing=\"1\" style=\"rounded\">" + row("<b>events that do more than change a mode</b>");
    for (const std::string& line : order) dot += alike[line].size() > 1 ? line : describe_event(*alike[line][0], true);
    return dot + "</table>>]\n";
  }

  bool full_names_ = false;
  const Model& model_;
};

}  // namespace

std::string describe_graph(const Model& model, const Plan& plan, const std::string& title) {
  const std::string font = " fontname=\"Helvetica,Arial,sans-serif\" fontsize=11";
  return "digraph unlatch {\n  graph [rankdir=LR nodesep=0.25 ranksep=0.45 labelloc=t label=<<b>" + escape(title) +
         "</b>>" + font + "]\n  node [" + font + "]\n  edge [" + font + " arrowsize=0.7 color=\"#5f6b7a\"]\n" +
         Structure(model, plan).describe() + Phases(model).describe() + "}\n";
}

}  // namespace unlatch::tools
