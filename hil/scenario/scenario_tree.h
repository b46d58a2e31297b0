// A scenario's files, read and parsed once, for many scenarios that differ in some values; without further access to
// files.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "hil/scenario/flexible/flexible_body.h"
#include "hil/scenario/language/scenario_sources.h"
#include "hil/scenario/scenario.h"
#include "hil/scenario/yaml/setting.h"

namespace unlatch::hil {

// Immutable: threads may share it.
class ScenarioTree {
 public:
  // Reads the files. Throws ScenarioError, like load_scenario().
  explicit ScenarioTree(const std::string& path, const std::vector<std::string>& overrides = {});
  ScenarioTree(const ScenarioSources& sources, const std::string& file, const std::vector<std::string>& overrides = {});

  // The scenario without settings.
  const Scenario& get_nominal() const { return nominal_; }
  const YamlNode& get_root() const { return root_; }  // files, templates and overrides combined
  // Returns the scenario with the settings, bit by bit that of load_scenario() with them, as PATH=VALUE, after the
  // overrides. Throws ScenarioError. The same reader reads the same tree, so this holds by construction.
  Scenario read(std::span<const Setting> settings) const;

 private:
  KnownStructures structures_;  // files of modes, read and conditioned once
  Scenario nominal_;
  ScenarioSources sources_;
  Mistakes mistakes_;
  YamlNode root_;
};

}  // namespace unlatch::hil
