// A scenario: the model, its time step, the required flight software, and the watched quantities, read from a YAML
// file. hil/scenarios/README.md describes the language.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hil/scenario/language/scenario_sources.h"
#include "hil/scenario/outputs.h"
#include "hil/scenario/rates.h"
#include "hil/scenario/requirements.h"
#include "hil/scenario/shapes/shapes.h"
#include "hil/scenario/text/quantity.h"
#include "hil/scenario/timing_options.h"
#include "hil/scenario/yaml/scenario_error.h"
#include "hil/scenario/yaml/yaml_numbers.h"
#include "hil/session/messages/messages.h"
#include "unlatch/model.h"

namespace unlatch::hil {

// Required flight software, and the policy if it does not answer.
struct FlightSoftware {
  std::vector<std::string> required;  // names of participants
  double timeout = 0.25;              // s of wall time without an answer
  double pause_limit = 600;           // s of wall time that the policy 'pause' waits before it aborts
  double cutoff = 1;                  // real time: fraction of a tick after which its commands are late
  int delay = 0;                      // ticks by which the transport delays every command
  double horizon = 60;                // s of simulated time from the present tick to the last one accepted of a command
  int queue = 16384;                  // commands of a required participant that may wait for their tick
  // kHold: channels keep their last values; kZero: they go to 0, or to the nearest value of their range; kSafe: to
  // their safe values; kPause: the run waits; kAbort: the run ends; kEvict: as kHold, and the participant may not
  // return.
  Policy policy = Policy::kHold;
  // Most that a run may have to be passed; beyond it the run is failed, whatever its requirements say.
  struct Limits {
    int lost = 0;                    // times that a required participant was lost
    double late = 0.01;              // late commands, as a part of the run's ticks
    int refused = 0;                 // commands of participants that were refused
    std::optional<int> malformed{};  // messages that were none
    std::optional<int> unused{};     // commands for ticks that the run did not reach
    std::optional<int> overruns{};   // ticks that ended after the next was due
  } limits;
};
extern const std::vector<std::string> kPolicyNames;  // "hold" …, in the order of Policy

// A point of a body whose path is drawn and plotted. It does not influence the run.
struct TracedPoint {
  std::string name;
  int body = 0;
  Eigen::Vector3d p_BP = Eigen::Vector3d::Zero();  // body axes, m
  int seen_from = kGround;                         // the path is in the axes of this body; the ground: W
};

// A change made on reading, or a fact for the user; no mistake. `where`: a key of Scenario::marks.
struct Remark {
  std::string where, text;
  std::string kind = "modes";  // kind of the finding that `check` reports
};

// A named number for expressions.
struct NamedConstant {
  std::string name;
  Quantity value;
};

struct Scenario {
  std::string file;  // as given to the loader, for messages
  std::string text;  // text of the file and of those that it includes: with `overrides` it reproduces this scenario
  std::vector<std::string> files;      // these files, by SourceMark::file
  std::vector<std::string> overrides;  // PATH=VALUE, in the order in which they were applied
  std::string name, title;
  double dt = 0, until = 0;              // s; until is a whole number of steps
  std::vector<NamedConstant> constants;  // in the order of the file, overrides applied
  std::vector<WrittenNumber> numbers;    // from load_scenario(), not from ScenarioTree::read(); without constants
  Model model;
  std::size_t named_quantities = 0;  // of the model's, the first: those of `quantities`; the others stand in conditions
  FlightSoftware flight_software;
  Rates rates;
  TimingOptions timing;
  std::vector<std::vector<BodyShape>> shapes;  // shapes of each body
  std::vector<BodyShape> ground_shapes;        // fixed in W
  std::vector<ClearancePair> clearance;        // pairs whose distance is watched
  std::vector<TracedPoint> points;
  std::vector<Requirement> requirements;
  std::vector<OutputGroup> outputs;  // outputs that runs write; empty: all, at every tick
  std::vector<Remark> remarks;
  std::vector<std::string> springs_while_free;  // joint springs that act intentionally while their joint is free
  std::map<std::string, SourceMark> marks;      // places of the elements, by ModelError::where: "body 'core'"
};

// Shapes of a body, or of the ground.
inline const std::vector<BodyShape>& get_shapes(const Scenario& scenario, int body) {
  return body == kGround ? scenario.ground_shapes : scenario.shapes[static_cast<std::size_t>(body)];
}
// Name of a shape of one of the model's surfaces: "core.skirt"; "core.shape[2]" of one without a name.
std::string name_surface_shape(const Scenario& scenario, int surface, int shape);

// Says that the required flight software takes no part in something, such as "a campaign"; empty if none is required.
std::string describe_absence(const FlightSoftware& flight_software, const std::string& something);

// Both throw ScenarioError with every mistake of the files and of the physics (validate()) at once. An unreadable file
// is a ScenarioError as well. A text that includes other files contains them too, like Scenario::text.
Scenario load_scenario(const std::string& path, const std::vector<std::string>& overrides = {});
Scenario load_scenario_text(const std::string& text, const std::string& file,
                            const std::vector<std::string>& overrides = {});

}  // namespace unlatch::hil
