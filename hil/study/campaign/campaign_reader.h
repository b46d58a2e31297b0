// Internals of the campaign loader: one reader that fills a Campaign, and the check of the values that may be drawn.
#pragma once

#include <string>
#include <vector>

#include "hil/scenario/yaml/yaml_reader.h"
#include "hil/study/campaign/campaign.h"

namespace unlatch::hil {

class CampaignReader {
 public:
  CampaignReader(Campaign& campaign, Mistakes& mistakes) : campaign_(campaign), mistakes_(mistakes) {}
  void read(const YamlNode& root, const std::vector<std::string>& overrides);

 private:
  struct Reading {  // of one parameter: its unit, and its value in the scenario
    const YamlNode* nominal = nullptr;
    std::optional<Dimension> dimension;
    std::optional<WrittenUnit> shown;
    bool sheet = false;               // an error of a sensor: units of data sheets too
    std::string root_unit;            // of a size per root of time: "rad/√s"
    std::optional<SourceMark> plain;  // of the first number without a unit that is not 0
  };

  void read_scenario(YamlMap& top, const std::vector<std::string>& overrides);
  void read_constants();
  void read_plan(YamlMap& top);
  void read_tolerance(YamlMap& top);
  double read_whole(YamlMap& map, const char* key, double fallback, double least, double most);
  int read_levels(YamlMap& map, int fallback);
  void read_parameters(YamlMap& top);
  void read_parameter(const std::string& name, const YamlNode& node);
  [[nodiscard]] std::optional<Dimension> find_dimension(const std::string& path);
  void refuse_names_of_results();
  void refuse_plain_numbers(const CampaignParameter& parameter, const Reading& reading);
  void read_correlations(YamlMap& top);
  void read_table(YamlMap& top);
  void finish_plan(YamlMap& top);

  // Defined in chosen_outputs_reader.cc.
  void read_outputs(YamlMap& top);
  void read_chosen_value(const YamlNode& node, const std::vector<Output>& outputs);
  void read_curves(const YamlNode& node, const std::vector<Output>& outputs);
  std::vector<Output::Column> read_output_names(const YamlNode& node, const std::vector<Output>& outputs);

  // Defined in rare_failure.cc.
  void read_subset(YamlMap& top);
  void read_failure(YamlMap& map, RareFailure& to);

  // Defined in distribution_reader.cc.
  bool read_distribution(YamlMap& map, CampaignParameter& to, Reading& reading);
  double read_value(YamlMap& map, const std::string& key, Reading& reading, std::optional<double> fallback = {});
  double read_sigma(YamlMap& map, double mean, Reading& reading);
  void read_cut(YamlMap& map, double mean, double sigma, Distribution& to, Reading& reading);
  void read_normal(const YamlNode& node, bool logarithmic, Distribution& to, Reading& reading);
  void read_triangular(const YamlNode& node, Distribution& to, Reading& reading);
  void read_discrete(const YamlNode& node, CampaignParameter& to, Reading& reading);
  void read_empirical(const YamlNode& node, CampaignParameter& to, Reading& reading);
  void read_cone(const YamlNode& node, CampaignParameter& to, Reading& reading);

  Campaign& campaign_;
  Mistakes& mistakes_;
  std::vector<std::string> overrides_;                                    // of the scenario
  std::optional<std::vector<WrittenNumber>> numbers_;                     // of the scenario, once they are asked for
  std::vector<std::pair<std::string, std::vector<std::size_t>>> groups_;  // names as written, and their parameters
  int levels_ = 0;
};

// A path of the scenario that a path with * matches.
struct MetPath {
  std::string path;   // without *
  std::string stars;  // what the stars stand for, joined by ':'; empty without a star
  std::string parts;  // likewise the whole parts of the path with a star in them: "low_l" of elements.low_*.preload
};
// Returns the paths that match a path with *. A path without * is returned as it is, even if nothing is at that place.
// Throws YamlError at `mark`.
std::vector<MetPath> expand_path(const std::string& path, const SourceMark& mark, const YamlNode& root);

// Table of numbers with a header of names, each with " [unit]" behind it if it has one. Columns of which a cell is no
// number may be there for readers: notes, serial numbers.
struct NumberTable {
  std::string file;
  std::vector<std::string> names, units;
  std::vector<std::string> texts{};       // of each column the first cell that is no number, with its line; "": none
  std::vector<std::vector<double>> rows;  // NaN: no number
};
// Throws YamlError at `mark`.
NumberTable read_number_table(const std::string& folder, const std::string& name, const SourceMark& mark);
// Throws YamlError at `mark` if a cell of the column is no number.
void require_numbers(const NumberTable& table, std::size_t column, const SourceMark& mark);
// What the unit of a column means; 1 without one. Throws YamlError at `mark` for what is no unit.
Quantity read_unit(const NumberTable& table, std::size_t column, const SourceMark& mark);
// The factor to SI of a column for values whose SI unit is `unit`, "" for plain numbers. Throws YamlError at `mark` if
// the column's unit is of another kind.
double read_factor(const NumberTable& table, std::size_t column, const std::string& unit, const SourceMark& mark);

// Point of the unit cube with every axis at one of its ends; that of a discrete parameter at any value. The same for
// the same number.
std::vector<double> draw_corner(const Campaign& campaign, std::uint64_t corner);

// Adds a mistake for each parameter of which a value makes no valid scenario, with the probability of such values: the
// ends of a distribution and every discrete value are tried; for values together the corners, and their probability is
// estimated from draws.
void check_draws(const Campaign& campaign, Mistakes& mistakes);

}  // namespace unlatch::hil
