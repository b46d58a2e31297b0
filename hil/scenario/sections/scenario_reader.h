// Internals of the scenario loader: one reader that fills a Scenario section by section. The files beside this one
// define the methods of a section each.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "hil/scenario/flexible/flexible_body.h"
#include "hil/scenario/language/record.h"
#include "hil/scenario/language/scenario_sources.h"
#include "hil/scenario/scenario.h"
#include "hil/scenario/yaml/yaml_reader.h"
#include "unlatch/quantities.h"

namespace unlatch::hil {

class ScenarioReader {
 public:
  // `sources`: files that the scenario names. `like`: a reading of the same files, whose meshes are shared.
  // `structures`: files of modes that other readings of the same files have read; new ones are added. `like`: a
  // scenario of the same files, whose meshes are taken.
  ScenarioReader(Scenario& scenario, ScenarioSources& sources, Mistakes& mistakes, KnownStructures& structures,
                 const Scenario* like = nullptr);
  void read(const YamlNode& root);
  // What it says about itself; only if the mistakes keep numbers.
  ScenarioRecord take_record() { return std::move(record_); }

 private:
  // Top level.
  void read_constants(YamlMap& top);
  void read_step(YamlMap& top);
  void read_gravity(YamlMap& top);
  void read_environment(YamlMap& top);
  void read_planet(const YamlNode& node);
  void read_atmosphere(const YamlNode& node);
  void read_wind(const YamlNode& node);
  void read_start(YamlMap& top);
  void remark_start(const Start& start);
  Eigen::Vector3d read_start_velocity(const YamlNode& node);
  void read_flight_software(YamlMap& top);
  void read_session_limits(const YamlNode& node);
  void read_timing(YamlMap& top);
  void report_physics();

  // Sections, in the order of reading: each may name items of those before it.
  void read_bodies(YamlMap& top);
  void read_ground(YamlMap& top);
  void read_channels(YamlMap& top);
  void read_signals(YamlMap& top);
  void read_joints(YamlMap& top);
  void read_elements(YamlMap& top);
  void read_contacts(YamlMap& top);
  void read_tables(YamlMap& top);
  void read_quantities(YamlMap& top);
  void read_sensors(YamlMap& top);
  void read_events(YamlMap& top);
  void read_clearance(YamlMap& top);
  void read_points(YamlMap& top);
  void read_requirements(YamlMap& top);
  void read_outputs(YamlMap& top);

  // Bodies.
  struct Placement {
    const YamlNode* relative_to = nullptr;
    int parent = kNone;  // also the flexible body of a marker, which `follows` it
    bool placed = false, follows = false;
  };
  void read_body(const std::string& name, const YamlNode& node);
  void read_mass(YamlMap& map, Body& body);
  Eigen::Vector3d read_position(YamlMap& map, const Body& body);
  MassLaw read_law(const YamlNode& node);
  void read_flexible(const YamlNode& node, Body& body);
  void read_marker(const YamlNode& node, Body& body);
  void place_bodies();
  void report_circles();
  Eigen::Quaterniond read_attitude(const YamlNode& node);
  std::vector<BodyShape> read_shapes(const YamlNode& node);
  BodyShape read_body_shape(const YamlNode& node);
  geometry::Shape read_shape(const std::string& key, const YamlNode& node);
  std::shared_ptr<const TriangleMesh> read_mesh_shape(const YamlNode& node);
  void read_hollow(const std::string& key, YamlMap& map, geometry::Shape& shape);
  void report_shape(const geometry::Shape& shape, const YamlNode& node);

  // Pairs of shapes. Functions that return nothing have noted a mistake.
  static constexpr const char* kGroundName = "ground";
  [[nodiscard]] std::string get_body_name(int body) const;  // or that of the ground
  [[nodiscard]] ShapeSet get_shapes_of(int body) const;
  std::optional<ShapeSet> read_shape_set(const YamlNode& node);
  std::optional<ClearancePair> read_two_sets(const YamlNode& node);      // two names, of different bodies
  std::optional<ClearancePair> read_shape_pair(const YamlNode& node);    // likewise, which have a distance
  std::optional<ClearancePair> read_surface_pair(const YamlNode& node);  // likewise, for the step: without meshes
  [[nodiscard]] std::size_t count_distances(const ClearancePair& pair) const;
  void report_undefined(const ClearancePair& pair);
  std::vector<ClearancePair> list_all_pairs();
  std::vector<ClearancePair> read_watched_pairs(const YamlNode& node);
  void read_exceptions(const YamlNode& node, std::vector<ClearancePair>& pairs);
  int watch(const ClearancePair& pair);  // index in Scenario::clearance

  // Joints.
  void read_joint(const std::string& name, const YamlNode& node);
  void read_modes(const YamlNode& node, Joint& joint);
  RowSet read_rows(const YamlNode& node);
  RowSet read_joint_kind(YamlMap& mode, Joint& joint);
  void read_between(YamlMap& map, int& base, int& follower);
  Eigen::Matrix3d read_frame(const YamlNode& node);

  // Elements. They are numbered by type, so they are first read into their lists and numbered afterwards.
  friend struct ElementReader;
  void read_element(const std::string& name, const YamlNode& node);
  Profile read_profile(const YamlNode& node, const std::string& unit, const std::string& element);

  // Contacts.
  void read_contact(const std::string& name, const YamlNode& node);
  void read_restitution(YamlMap& map, Contact& contact);
  bool is_of_lines(const ClearancePair& pair) const;
  void report_shared_pairs(const ClearancePair& pair, const YamlNode& node);
  void add_touches();
  int find_surface(const ShapeSet& set);  // index in the model, to which it is added if new
  // Pushers, cords, stops, friction, impulses, and the events that belong to some of them.
  bool read_line(YamlMap& map, OneSided& force);
  void read_pusher(YamlMap& map, OneSided force);
  void read_cord(YamlMap& map, OneSided force);
  void read_drum(const YamlNode& node, OneSided& cord);
  void read_stop(const std::string& name, const YamlNode& node);
  void read_friction(YamlMap& map, JointFriction friction);
  void read_parting(const YamlNode& node, const Joint& joint, int number);
  Action read_impulse(YamlMap& map);
  int read_one_sided(const YamlNode& node);
  int read_wound_cord(const YamlNode& node);
  void report_idle_partings();
  void append_events();

  // Timing.
  void read_overruns(const YamlNode& node);
  void read_watchdog(const YamlNode& node);
  Rate read_rate(YamlMap& map);
  void read_rate_groups(const YamlNode& node);
  void read_group_channels(const YamlNode& node, RateGroup& group);
  void read_group_sensors(const YamlNode& node, RateGroup& group);
  void check_channels_belong_to_one_group(const YamlNode& node);

  // Tables and laws.
  struct TableSource {
    TableSignature signature;
    std::vector<const YamlNode*> of;  // per axis; null: it does not say
    bool is_open = false;             // its axes are being compiled
  };
  struct ElementLaw {
    int law;
    const YamlNode* node;
    std::string unit, element;
  };
  class Names;
  Quantity read_unit(YamlMap& map);
  void read_table(const std::string& name, const YamlNode& node);
  void read_table_numbers(const YamlNode& node, Quantity& unit, std::vector<double>& to);
  void read_table_ends(YamlMap& map, TableAxis& axis);
  void read_table_axis(const std::string& name, const YamlNode& node, bool inline_knots, Table& table,
                       TableSource& source);
  void read_table_file(YamlMap& map, const YamlNode& file, Table& table, TableSource& source);
  // Factor and offset of a law or a table; `unit` of its values.
  template <class Scaled>
  void read_scaling(YamlMap& map, const std::string& unit, Scaled& item) {
    item.scale = map.number("scale", "", 1.0);
    item.offset = map.number("offset", unit, 0.0);
    item.scale_channel = map.choice("scale_channel", "channel", channels_, kNone);
    item.offset_channel = map.choice("offset_channel", "channel", channels_, kNone);
  }
  int add_law(const std::string& name, const YamlNode& node);
  int read_law(YamlMap& map, const std::string& unit, const std::string& name, const std::string& element);
  void compile_law(int law, const YamlNode& node, const std::optional<std::string>& unit, const std::string& element);
  void compile_steps(int law, const YamlNode& node, const std::optional<std::string>& unit, const std::string& element);
  void compile_element_laws();
  void read_expression_quantity(YamlMap& map, int law);

  // Quantities.
  int read_quantity_index(const std::string& kind, const YamlNode& node);
  unlatch::Quantity read_model_quantity(const std::string& kind, const YamlNode& node);
  int read_quantity_subject(const YamlNode& node, SubjectOf of);
  void read_quantity_part(YamlMap& map, const QuantityTraits& traits, unlatch::Quantity& to);
  int read_relative_to(YamlMap& map, int body, bool may_be_itself);
  Eigen::Vector3d read_direction(YamlMap& map, const char* key, bool needed);
  void find_quantity_events();

  // Sensors and events.
  void read_sensor(const std::string& name, const YamlNode& node);
  void read_sensor_errors(const YamlNode& node, const Sensor& sensor);
  void read_sensor_delays();
  void read_event(const YamlNode& node);
  Condition read_condition(const YamlNode& node);
  void read_parts(const YamlNode& node, const std::string& kind, Condition& condition);
  void read_joint_condition(const YamlNode& node, const std::string& kind, Condition& condition);
  void read_threshold(YamlMap& map, const std::string& unit, Condition& condition);
  void collect_signals(const YamlNode& events);
  Action read_action(const YamlNode& node);
  int read_mode_of(YamlMap& map, const std::string& key, int joint);

  // Requirements.
  void read_requirement(const YamlNode& node);
  void read_requirement_quantity(const YamlNode& node, const std::string& kind, Requirement& to);
  void read_requirement_clearance(const YamlNode& node, Requirement& to);
  void read_requirement_of_bodies(YamlMap& map, Requirement& to);
  void read_requirement_contact(YamlMap& map, Requirement& to);
  void read_requirement_sensor(YamlMap& map, Requirement& to);
  void read_requirement_interval(YamlMap& map, Requirement& to);
  void read_requirement_limit(YamlMap& map, Requirement& to);
  EventName read_event_name(const YamlNode& node);

  // Basis of values.
  void read_basis(YamlMap& top, const YamlNode& root);
  void read_basis_entry(const YamlNode& node, const YamlNode& root);
  void read_basis_pattern(const YamlNode& node, const YamlNode& root, const std::string& where, Basis& basis);
  void check_uncertainties();

  // Outputs.
  void read_output_group(const YamlNode& node, const std::vector<Output>& known);
  void read_output_pattern(const YamlNode& node, const std::vector<Output>& known, const std::string& where,
                           OutputGroup& group);

  // In names that expressions alone use, no - may be.
  enum class Minus { kAllowed, kRefused };
  bool check_name(const std::string& name, const YamlNode& node, const std::string& kind, Minus minus);
  // Calls `read_item(name, node)` for each entry of a section that maps names to entries, and stores its place.
  void for_each_named(YamlMap& top, const std::string& section, const std::string& kind,
                      const std::function<void(const std::string&, const YamlNode&)>& read_item);
  // Runs `read_item`, stores the place of `where`, and notes if it had mistakes: then findings of validate() there are
  // mere consequences.
  void read_item_at(const std::string& where, const YamlNode& node, const std::function<void()>& read_item);
  bool is_flawed(const std::string& where) const { return flawed_.count(where) > 0; }

  const KnownStructure& read_structure(const std::string& path, const std::vector<int>& numbers);

  Scenario& scenario_;
  ScenarioRecord record_;
  Model& model_;
  ScenarioSources& sources_;
  Mistakes& mistakes_;
  std::vector<std::string> bodies_, joints_, elements_, channels_;  // names, by index
  std::vector<std::pair<std::string, int>> event_names_;  // name or name:subject, index; kNone for disabled ones
  std::vector<std::pair<std::size_t, const YamlNode*>> awaited_events_;  // per quantity that is the time since one
  std::vector<Event> parting_joints_, cord_events_;                      // see append_events()
  std::vector<TableSource> tables_;                                      // as Model::tables
  std::set<int> open_laws_;                                              // that have no steps yet
  std::vector<ElementLaw> element_laws_;                                 // likewise, of elements
  struct SensorDelay {
    std::size_t errors;  // index
    YamlNode node;
  };
  std::vector<SensorDelay> sensor_delays_;
  std::vector<Placement> placements_;
  Start::Origin origin_ = Start::Origin::kKept;  // of W, beside the planet
  const YamlNode* origin_node_ = nullptr;
  std::vector<std::pair<std::string, ClearancePair>> pushing_;  // contacts that act at the start
  std::map<std::string, FlexibleStructure> structures_;         // by flexible body
  std::map<std::string, const YamlNode*> nodes_;                // by ModelError::where
  std::set<std::string> flawed_;
  std::vector<std::shared_ptr<const TriangleMesh>> known_meshes_;
  KnownStructures& known_structures_;
};

std::string get_si(const Channel& channel);  // unit of its numbers, "" if it is no SI unit
std::string get_si(const Model& model, const unlatch::Quantity& quantity);  // likewise, "" for a plain number
const std::vector<std::string>& axis_names();                               // x y z
const std::vector<std::string>& row_names();                                // x … rot_z

}  // namespace unlatch::hil
