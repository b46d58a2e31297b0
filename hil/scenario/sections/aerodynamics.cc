// Elements of type aerodynamics: coefficients as numbers, expressions and sums of them.
#include <array>

#include "hil/scenario/language/bounded_number.h"
#include "hil/scenario/sections/scenario_reader.h"

namespace unlatch::hil {
namespace {

constexpr std::array<const char*, 7> kCoefficients{"cx", "cy", "cz", "cl", "cm", "cn", "drag"};  // as AeroTerm::Of

bool is_moment(AeroTerm::Of of) {
  return of == AeroTerm::Of::kRoll || of == AeroTerm::Of::kPitch || of == AeroTerm::Of::kYaw;
}

}  // namespace

void ScenarioReader::read_aerodynamics(YamlMap& map, Aerodynamics air) {
  air.body = map.choice("body", "body", bodies_);
  air.area = read_bounded(map, get_number_key("scenario.aerodynamics.area"), {}, mistakes_);
  air.point = map.vector("point", "m", Eigen::Vector3d::Zero());
  const YamlNode *const length = map.find("length"), *const lengths = map.find("lengths");
  if (length != nullptr && lengths != nullptr)
    mistakes_.add(lengths->mark, "it has a length and three lengths", "write one of them");
  if (length != nullptr)
    air.lengths.setConstant(read_bounded(map, get_number_key("scenario.aerodynamics.length"), 1.0, mistakes_));
  else if (lengths != nullptr)
    air.lengths = read_vector(*lengths, "m", Eigen::Vector3d::Ones(), mistakes_);
  for (std::size_t i = 0; i < kCoefficients.size(); ++i)
    if (const YamlNode* node = map.find(kCoefficients[i]))
      read_coefficient(*node, {static_cast<AeroTerm::Of>(i), kNone, 0, kNone}, air);
  if (const YamlNode* node = map.find("damping")) {
    YamlMap damping(*node, "damping", mistakes_);
    for (std::size_t i = 0; i < kCoefficients.size(); ++i) {
      const YamlNode* rates = damping.find(kCoefficients[i]);
      if (!rates) continue;
      if (!rates->is_sequence() || rates->items.size() != 3) {
        mistakes_.add(rates->mark, "these are not three derivatives", "write those by p, q and r: [-0.4, 0, 0]");
        continue;
      }
      for (int rate = 0; rate < 3; ++rate)
        read_coefficient(rates->items[static_cast<std::size_t>(rate)], {static_cast<AeroTerm::Of>(i), rate, 0, kNone},
                         air);
    }
    damping.finish();
  }
  if (length == nullptr && lengths == nullptr)
    for (const AeroTerm& term : air.terms)
      if (is_moment(term.of) || term.rate != kNone) {
        mistakes_.add(map.node().mark, "its moments have no length", "give its `length`, or three `lengths`");
        break;
      }
  air.on = map.boolean("enabled", true);
  model_.aerodynamics.push_back(std::move(air));
}

// A number, an expression, or a list of these, which is their sum.
void ScenarioReader::read_coefficient(const YamlNode& node, AeroTerm term, Aerodynamics& air) {
  if (!node.is_sequence()) return read_aero_term(node, term, air);
  for (const YamlNode& item : node.items) read_aero_term(item, term, air);
}

void ScenarioReader::read_aero_term(const YamlNode& node, AeroTerm term, Aerodynamics& air) {
  if (node.is_mapping()) {
    YamlMap map(node, "a coefficient", mistakes_);
    if (map.require("expression") != nullptr) {
      term.law = read_law(map, "", "coefficient " + std::to_string(air.terms.size() + 1) + " of " + air.name, air.name);
      air.terms.push_back(term);
    }
    map.finish();
    return;
  }
  term.value = read_number(node, "", 0.0, mistakes_);
  if (term.value != 0) air.terms.push_back(term);
}

}  // namespace unlatch::hil
