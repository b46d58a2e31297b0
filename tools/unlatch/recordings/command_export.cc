// unlatch export: a recording, run again, in the formats of other tools; or a scenario as an FMU.
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "hil/scenario/base/module.h"
#include "hil/scenario/shapes/clearance.h"
#include "library/fmi/write_fmu.h"
#include "tools/common/output.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"
#include "tools/export/node_writer.h"
#include "tools/export/sink.h"
#include "tools/program/exit_codes.h"
#include "tools/unlatch/options/output_options.h"
#include "tools/unlatch/recordings/replayed_log.h"
#include "tools/unlatch/recordings/verbs.h"
#include "tools/unlatch/results/accuracy_report.h"

namespace unlatch::tools {
namespace {

struct ExportOptions {
  std::string log, format, out, outputs;
  std::vector<std::string> bodies;
  std::int64_t every = 1;
  std::string fmu, fmi = "3";
  std::vector<std::string> overrides;
};

bool needs_node(const std::string& format) { return format == "mcap" || format == "parquet"; }

void check_destination(const ExportOptions& options) {
  std::error_code error;
  if (std::filesystem::equivalent(options.log, options.out, error)) {
    refuse_option("--out", options.out + " is the recording; what is exported needs a file of its own");
  }
  if (options.out == "-" && needs_node(options.format)) {
    refuse_option("--out", options.format + " goes to a file, not to standard output");
  }
}

// The file, or the pipe to its writer.
class Destination {
 public:
  Destination(const std::string& format, const std::string& path) : path_(path) {
    if (needs_node(format)) {
      node_.emplace(format, std::filesystem::absolute(path).string());
    } else {
      file_.reset(path == "-" ? stdout : std::fopen(path.c_str(), "wb"));
      if (!file_) throw OutputError(path_ + ": cannot be created: " + std::strerror(errno));
    }
  }

  [[nodiscard]] std::FILE* get_stream() const { return node_ ? node_->get_stream() : file_.get(); }

  // Opened early, so that a full disk is found before a long replay.
  void check() const {
    if (std::ferror(get_stream()) != 0) throw OutputError(path_ + ": cannot be written: " + std::strerror(errno));
  }

  void finish() {
    if (node_ ? !node_->finish() : std::fflush(file_.get()) != 0) {
      throw OutputError(path_ + ": is not whole: " + (node_ ? "its writer has failed" : std::strerror(errno)));
    }
    if (!node_) check();
  }

 private:
  struct Close {
    void operator()(std::FILE* file) const {
      if (file != stdout) std::fclose(file);
    }
  };
  const std::string path_;
  std::optional<NodeWriter> node_;
  std::unique_ptr<std::FILE, Close> file_;
};

std::unique_ptr<Sink> build_sink(const std::string& format, std::FILE* stream) {
  if (format == "csv") return build_csv_sink(stream);
  return format == "parquet" ? build_table_sink(stream) : build_json_sink(stream);
}

// Groups that state no rate go out at --every.
std::vector<hil::SelectedOutputs> choose_groups(const ExportOptions& options, const hil::Scenario& scenario,
                                                hil::SensorsShown shown) {
  const std::vector<hil::Output> list = hil::list_outputs(scenario, shown);
  std::vector<hil::OutputGroup> groups = choose_outputs(scenario, options.outputs, shown);
  for (hil::OutputGroup& group : groups)
    if (group.rate.every == 1) group.rate.every = options.every;
  std::vector<hil::SelectedOutputs> selected =
      groups.empty() ? hil::select_all(list, {options.every, 0}) : hil::select(list, groups);
  return keep_bodies(std::move(selected), scenario, list, options.bodies);
}

// The touches of a run whose ticks are a table, beside it: run.csv has run.touches.csv.
void write_touch_table(const ExportOptions& options, const std::vector<hil::ContactRecord>& contacts,
                       const hil::LogHeader& header) {
  if (contacts.empty() || (options.format != "csv" && options.format != "parquet")) return;
  if (options.out == "-") {
    std::fprintf(stderr, "note: the touches of contacts are a second table, which needs a file: give --out FILE\n");
    return;
  }
  std::filesystem::path path = options.out;
  path.replace_extension(".touches" + path.extension().string());
  Destination destination(options.format, path.string());
  if (options.format == "csv")
    write_touches_as_csv(contacts, destination.get_stream());
  else
    write_touches_as_table(contacts, header, destination.get_stream());
  destination.finish();
  std::fprintf(stderr, "%s: the touches of contacts\n", path.string().c_str());
}

// What the run is worth, beside a table that has no place for it: run.csv has run.status.json.
void write_status(const ExportOptions& options, const nlohmann::ordered_json& status) {
  if (options.format != "csv" || !std::filesystem::is_regular_file(options.out)) return;
  std::filesystem::path path = options.out;
  path.replace_extension(".status.json");
  Destination destination("json", path.string());
  const std::string text = status.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  std::fwrite(text.data(), 1, text.size(), destination.get_stream());
  destination.finish();
}

int write_fmu(const ExportOptions& options) {
  if (!options.format.empty() || !options.out.empty())
    refuse_option("--fmu", "the FMU is the output; --format and --out are for recordings");
  const hil::Scenario scenario = hil::load_scenario(options.log, options.overrides);
  const hil::ClearanceMonitor monitor(scenario.clearance, scenario.shapes, scenario.ground_shapes);
  for (const hil::Clearance& pair : monitor.get())
    if (pair.method == hil::DistanceMethod::kMesh)
      refuse_option("--fmu",
                    "the distance of " + pair.name_a + " and " + pair.name_b +
                        " is that of a mesh, which needs a library that an FMU does not carry: take the pair out of "
                        "clearance and requirements");
  std::string overrides;
  for (const std::string& line : options.overrides) overrides += line + "\n";
  const auto write = hil::find_function<decltype(unlatch_write_fmu)>("unlatch-fmu", "unlatch_write_fmu");
  const char* const failure = write(scenario.text.c_str(), overrides.c_str(), scenario.name.c_str(),
                                    options.fmi == "2" ? 2 : 3, options.fmu.c_str());
  if (failure != nullptr) throw OutputError(failure);
  std::fprintf(stderr, "%s: FMI %s.0 co-simulation, step %g s\n", options.fmu.c_str(), options.fmi.c_str(),
               scenario.dt);
  return kExitDone;
}

int run(const ExportOptions& options) {
  if (!options.fmu.empty()) return write_fmu(options);
  if (!options.overrides.empty()) refuse_option("--set", "a recording has its own; --set is for --fmu");
  if (options.format.empty()) refuse_option("--format", "is missing: csv, json, mcap or parquet");
  if (options.out.empty()) refuse_option("--out", "is missing: the file to write");
  check_destination(options);
  OpenedLog opened(options.log);
  hil::RecordingReader& recording = opened.recording;
  hil::Simulation& simulation = *opened.simulation;
  // What the step did not resolve; of contacts the shapes of their touches, and each touch.
  hil::RunAnalysis analysis(opened.scenario, simulation,
                            hil::AnalysisRequest{.reactions = false, .redundancy = false, .pushes = false});
  const bool touches = !opened.scenario.model.contacts.empty();
  std::optional<Selection> selection;
  try {
    const hil::SensorsShown shown = hil::get_sensors_shown(recording.header);
    selection.emplace(opened.scenario, simulation, choose_groups(options, opened.scenario, shown),
                      recording.header.last_tick, shown, touches ? &analysis : nullptr);
  } catch (const std::invalid_argument& error) {
    refuse_option("--bodies", error.what());
  }
  Destination destination(options.format, options.out);
  const auto sink = build_sink(options.format, destination.get_stream());
  sink->begin(*selection, recording.header);

  Progress progress(recording.header.dt, recording.header.last_tick);
  const hil::ReplayResult result = hil::replay(recording, simulation, &analysis, [&](const StepReport& report) {
    progress.show(simulation.get_tick());
    selection->set_received(recording.received);
    if (!selection->look(report, recording.take_events())) return;
    sink->add_tick(*selection);
    destination.check();
  });
  progress.clear();
  if (selection->look_at_end()) sink->add_tick(*selection);
  const std::vector<hil::ContactRecord> contacts =
      touches ? analysis.list_contacts() : std::vector<hil::ContactRecord>();
  for (const hil::ContactRecord& contact : contacts) sink->add_contact(contact);
  std::string status = describe_status(recording, result);
  std::string why = recording.end ? recording.end->message : recording.shortfall;
  tell_unresolved(analysis, status, why);
  const std::string hash = to_hex(simulation.calc_hash());
  sink->end({status, why, hash});
  destination.finish();
  write_touch_table(options, contacts, recording.header);
  write_status(options, {{"status", status},
                         {"reason", why},
                         {"replays", result.agrees()},
                         {"ticks", simulation.get_tick()},
                         {"hash", hash}});

  std::fprintf(stderr, "%s: %s, up to tick %lld (t = %g s), %s\n", options.out.c_str(), options.format.c_str(),
               static_cast<long long>(simulation.get_tick()), simulation.get_time(), status.c_str());
  if (!recording.shortfall.empty()) std::fprintf(stderr, "  %s\n", recording.shortfall.c_str());
  if (status == kUnresolved) std::fprintf(stderr, "  %s\n", why.c_str());
  if (!result.agrees()) std::fprintf(stderr, "  it does not replay as it was recorded: see unlatch replay\n");
  return result.agrees() && !recording.damaged && status != kUnresolved ? kExitDone : kExitFailed;
}

}  // namespace

void add_export(Command app, int& exit_code) {
  auto options = std::make_shared<ExportOptions>();
  Command command = app.add_verb(
      "export",
      "Replays a recording and converts it. csv: a table, one row per tick, units in the header; cells of "
      "outputs "
      "that are not due are empty. json: one object on each line: the run, its ticks and events. mcap: for Foxglove, "
      "with the 3D scene, transforms, reactions, elements, sensors, events. parquet: the table of csv. With "
      "contacts csv and parquet write a second table, FILE.touches.csv: each touch with its times, shapes, peak force, "
      "depth and impulse. mcap and parquet need Node.js. SI units, angles in rad; reactions act on the follower. Exit "
      "code 1: the file was written, but the replay differs from the recording, or the step did not resolve the run, "
      "whose numbers are no results then. A file of csv has FILE.status.json beside it: the run's status, its reason, "
      "and whether it replays. --fmu writes a scenario as a co-simulation "
      "FMU instead: channels are inputs; "
      "sensors, reactions, bodies and clearances outputs.",
      "unlatch export run.log --format csv --every 10 --out run.csv\n"
      "unlatch export run.log --format mcap --bodies core,booster1 --out run.mcap\n"
      "unlatch export run.log --format parquet --outputs 'core.*,*.force@10' --out run.parquet\n"
      "unlatch export hil/scenarios/boosters/scenario.yaml --fmu boosters.fmu --fmi 2");
  command.add_option("LOG", options->log, "recording made by --log; with --fmu: a scenario").required();
  command.add_option("--format", options->format, "output format of a recording")
      .one_of({"csv", "json", "mcap", "parquet"});
  command.add_option("--out", options->out, "file to write; - for standard output (csv, json)").type_name("FILE");
  command
      .add_option("--every", options->every,
                  "ticks from one row to the next, for outputs without a rate of their own; first and last always")
      .type_name("TICKS")
      .within(std::int64_t{1}, std::int64_t{1'000'000'000})
      .default_shown();
  command.add_option("--bodies", options->bodies, "only these bodies (default: all)")
      .delimiter(',')
      .type_name("NAME,...");
  add_outputs_option(command, options->outputs);
  command.add_option("--fmu", options->fmu, "FMU to write from a scenario").type_name("FILE");
  command.add_option("--fmi", options->fmi, "version of FMI of --fmu").one_of({"2", "3"}).default_shown();
  command.add_option("--set", options->overrides, "with --fmu: overrides a value of the scenario; repeatable")
      .type_name("PATH=VALUE");
  command.callback([options, &exit_code] {
    try {
      exit_code = run(*options);
    } catch (const NodeMissing& missing) {
      std::fprintf(stderr, "unlatch export: %s\n", missing.what());
      exit_code = kExitEnvironment;
    }
  });
}

}  // namespace unlatch::tools
