// What a session has, by its Hello and its catalog: names of bodies, joints, channels and sensor values, and so the
// size and the contents of its packets.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hil/session/messages/messages.h"

namespace unlatch {
struct Model;
}

namespace unlatch::bridge {

struct LayoutItem {
  std::string name, unit;
};

class SessionLayout {
 public:
  // Takes the names of the joints' modes, which no message has, from the model of the session's scenario. False, and
  // nothing is taken, if the session has other joints. A layout without the names is complete, too.
  bool take_modes(const Model& model);
  [[nodiscard]] const std::vector<std::string>& get_modes(std::size_t joint) const {
    static const std::vector<std::string> kUnknown;
    const auto at = modes_.find(joint);
    return at == modes_.end() ? kUnknown : at->second;
  }

  // Takes a Hello or a Catalog. True if another session has begun with it: the layout begins anew.
  bool hear(const hil::Message& message);

  // Everything that its Hello announced is there.
  [[nodiscard]] bool is_complete() const;
  [[nodiscard]] std::int64_t get_session() const { return hello_.session; }
  [[nodiscard]] const hil::HelloMessage& get_hello() const { return hello_; }
  [[nodiscard]] std::string get_scenario() const;
  [[nodiscard]] const std::vector<LayoutItem>& list(hil::CatalogKind kind) const;

  // Messages that one State takes, or one Reactions.
  [[nodiscard]] int count_state_parts() const;
  [[nodiscard]] int count_reaction_parts() const;
  // Entries of an array of State or Reactions that are valid in a part.
  [[nodiscard]] std::size_t count_valid(hil::MessageKind kind, std::string_view field, int part) const;

 private:
  void expect();

  hil::HelloMessage hello_;
  std::array<std::vector<LayoutItem>, 6> items_;           // by CatalogKind
  std::map<std::size_t, std::vector<std::string>> modes_;  // by joint
  std::size_t missing_ = 0;                                // entries that no Catalog has named yet
};

}  // namespace unlatch::bridge
