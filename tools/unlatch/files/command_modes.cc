// unlatch modes: natural frequencies and shapes, from beam theory, from CalculiX, into modes files for flexible bodies.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "hil/scenario/flexible/flexible_body.h"
#include "hil/scenario/text/utf8.h"
#include "tools/common/output.h"
#include "tools/common/terminal.h"
#include "tools/common/text.h"
#include "tools/modes/mesh_modes.h"
#include "tools/modes/shell_beams.h"
#include "tools/program/exit_codes.h"
#include "tools/unlatch/files/flexible_report.h"
#include "tools/unlatch/files/verbs.h"
#include "tools/unlatch/results/report.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

// --- What the verbs share -------------------------------------------------------------------------------------------

void add_shell_options(Command command, HalfShell& shell) {
  command.add_option("--radius", shell.radius, "radius of the half circle, m").positive();
  command.add_option("--thickness", shell.thickness, "wall thickness, m").positive();
  command.add_option("--young", shell.young, "Young's modulus, N/m2").positive();
  command.add_option("--density", shell.density, "density, kg/m3").positive();
  command.add_option("--poisson", shell.poisson, "Poisson's ratio").within(0.0, 0.499);
}

void write_file(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  if (!(file << text) || !file.flush()) throw OutputError(path + ": cannot be written");
}

// NAME=x,y,z
MarkerRequest parse_marker(const std::string& text) {
  MarkerRequest marker;
  char name[64] = "";
  int end = 0;
  Eigen::Vector3d& p = marker.position;
  if (std::sscanf(text.c_str(), "%63[^=]=%lf,%lf,%lf%n", name, &p.x(), &p.y(), &p.z(), &end) != 4 ||
      end != static_cast<int>(text.size()) || !p.allFinite())
    refuse_option("--marker", "'" + text + "' is not NAME=x,y,z");
  marker.name = name;
  return marker;
}

// --- arc ------------------------------------------------------------------------------------------------------------

struct ArcOptions {
  HalfShell shell;
  double angle_deg = 180;
  int count = 3, points = 91;
  std::string json;
};

int run_arc(const ArcOptions& options) {
  const double angle = options.angle_deg * std::numbers::pi / 180;
  const HalfShell& s = options.shell;
  const auto shallow = calc_arc_modes(ArcModel::kShallow, angle, options.count, options.points);
  const auto exact = calc_arc_modes(ArcModel::kInextensional, angle, options.count, options.points);
  std::FILE* const to = get_people_stream(options.json);
  std::fprintf(to, "Arc of %g deg, radius %g m, thickness %g m, free at both ends, in its plane\n", options.angle_deg,
               s.radius, s.thickness);
  std::fprintf(to, "  mode   beam (3.4)                exact inextensional arc, plate\n");
  std::fprintf(to, "         Omega          Hz         Omega          Hz\n");
  Json json = {{"schema", 1},
               {"angle_deg", options.angle_deg},
               {"radius", s.radius},
               {"thickness", s.thickness},
               {"models", Json::array()}};
  for (const auto& [name, modes, plate] : {std::tuple{"beam_3_4", &shallow, false}, {"exact_arc", &exact, true}}) {
    Json list = Json::array();
    for (const ArcMode& mode : *modes)
      list.push_back({{"omega", mode.omega},
                      {"hz", calc_arc_hz(mode.omega, s.radius, s.thickness, s.young, s.density, s.poisson, plate)},
                      {"even", mode.even},
                      {"radial", mode.radial},
                      {"tangential", mode.tangential}});
    json["models"].push_back({{"model", name}, {"modulus", plate ? "E/(1-nu2)" : "E"}, {"modes", list}});
  }
  for (std::size_t k = 0; k < shallow.size(); ++k)
    std::fprintf(to, "  %-4zu   %-12.9f   %-8.4f   %-12.9f   %-8.4f\n", k + 1, shallow[k].omega,
                 json["models"][0]["modes"][k]["hz"].get<double>(), exact[k].omega,
                 json["models"][1]["modes"][k]["hz"].get<double>());
  std::fprintf(to, "Omega = omega R2 sqrt(m/EJ). As many roots as the argument of each frequency function counts.\n");
  write_json(json, options.json);
  return kExitDone;
}

// --- What a modes file gives ----------------------------------------------------------------------------------------

struct ShowOptions {
  std::string path, json;
  std::vector<int> select;
};

hil::FlexibleStructure build_body(const hil::Modes& modes, const std::vector<int>& select, const std::string& file,
                                  hil::FlexibleReport& report) {
  try {
    return hil::build_flexible_body(modes, {select, {0}}, report);
  } catch (const std::invalid_argument& error) {
    throw hil::ScenarioError({{file, {}, "", error.what(), "see hil/MODES.md"}});
  }
}

int run_show(const ShowOptions& options) {
  const hil::Modes modes = hil::read_modes_file(options.path);
  hil::FlexibleReport report;
  const hil::FlexibleStructure body = build_body(modes, options.select, options.path, report);
  print_report(get_people_stream(options.json), body, report, modes);
  write_json(build_json(body, report), options.json);
  return kExitDone;
}

// --- import ---------------------------------------------------------------------------------------------------------

struct ExportOptions {
  std::vector<std::string> markers;
  std::string out, title;
  int count = 8, digits = 5;
};
void add_export_options(Command command, ExportOptions& options) {
  command.add_option("--marker", options.markers, "NAME=x,y,z: an attachment frame at the nearest node; repeatable");
  command.add_option("--modes", options.count, "largest number of elastic modes").within(1, 200);
  command.add_option("--digits", options.digits, "digits of shapes after the first digit of the largest").within(2, 15);
  command.add_option("--title", options.title, "title in the modes file");
}

constexpr double kRigidHz = 0.1;  // CalculiX prints rigid modes at some mHz

hil::Modes build_export(const MeshModes& found, double surface_density, const ExportOptions& options) {
  std::vector<MarkerRequest> markers;
  for (const std::string& text : options.markers) markers.push_back(parse_marker(text));
  hil::Modes modes = build_modes(found, surface_density, kRigidHz, options.count, options.digits, markers);
  modes.title = options.title;
  return modes;
}

struct ImportOptions {
  std::string frd, dat, json, units = "m";
  double thickness = 0, density = 0;
  ExportOptions file;
};

// CalculiX's files name no units: a file in mm, t, s, N is brought to m, kg, s, N.
void convert_units(MeshModes& found) {
  constexpr double kMillimetre = 1e-3, kTonne = 1e3;
  for (Eigen::Vector3d& node : found.mesh.nodes) node *= kMillimetre;
  const double shape = 1 / std::sqrt(kTonne);  // scaled to a modal mass of 1 t, not 1 kg
  for (std::vector<Eigen::Vector3d>& mode : found.displacements)
    for (Eigen::Vector3d& u : mode) u *= shape;
}

// CalculiX scales each shape to the modal mass 1. A sentence if the masses of the points say otherwise; "" if not.
std::string check_modal_masses(const hil::Modes& modes, bool millimetres) {
  constexpr double kNear = 1.5;  // meshes of few elements are off by some percent
  double lowest = HUGE_VAL, highest = 0;
  for (Eigen::Index k = 0; k < modes.get_count(); ++k) {
    double mass = 0;
    for (const hil::ModalPoint& point : modes.points) mass += point.mass * point.shape.col(k).squaredNorm();
    lowest = std::min(lowest, mass);
    highest = std::max(highest, mass);
  }
  if (lowest > 1 / kNear && highest < kNear) return "";
  const std::string found =
      format("the modal masses are %.3g to %.3g, where CalculiX has scaled them to 1: ", lowest, highest);
  const double factor = millimetres ? 1e-9 : 1e9;  // of areas and of masses per 1
  if (lowest > factor / kNear && highest < factor * kNear)
    return found +
           (millimetres ? "the file is in m and kg; leave out --units mm" : "the file is in mm and t; add --units mm");
  return found +
         "is the thickness (m) or the density (kg/m3) another than in the deck, or are its units neither m, kg, s, N "
         "nor mm, t, s, N?";
}

int run_import(const ImportOptions& options) {
  MeshModes found = read_calculix(options.frd, options.dat);
  const bool millimetres = options.units == "mm";
  if (millimetres) convert_units(found);
  const hil::Modes modes = build_export(found, options.thickness * options.density, options.file);
  const std::string warning = check_modal_masses(modes, millimetres);
  if (!warning.empty()) std::fprintf(stderr, "%s\n", paint(stderr, Colour::kYellow, "warning: " + warning).c_str());
  hil::FlexibleReport report;
  const hil::FlexibleStructure body = build_body(modes, {}, options.frd, report);
  write_file(options.file.out, hil::write_modes_text(modes));
  print_report(get_people_stream(options.json), body, report, modes);
  Json json = build_json(body, report);
  if (!warning.empty()) json["warnings"] = {warning};
  write_json(json, options.json);
  return kExitDone;
}

// --- shell ----------------------------------------------------------------------------------------------------------

struct ShellOptions {
  HalfShell shell;
  std::string ccx = "ccx", keep, json;
  ExportOptions file;
};

// A folder of its own for CalculiX's files, gone afterwards unless the user named it.
class WorkFolder {
 public:
  explicit WorkFolder(const std::string& keep) : keep_(!keep.empty()), path_(keep) {
    if (keep_) {
      std::filesystem::create_directories(path_);
      return;
    }
    path_ = (std::filesystem::temp_directory_path() / "unlatch-modes-XXXXXX").string();
    if (mkdtemp(path_.data()) == nullptr) throw OutputError(path_ + ": cannot be created");
  }
  ~WorkFolder() {
    std::error_code ignored;
    if (!keep_) std::filesystem::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  const std::string& get_path() const { return path_; }

 private:
  bool keep_;
  std::string path_;
};

MeshModes solve_shell(const ShellOptions& options) {
  constexpr int kRigidModes = 6;
  const WorkFolder folder(options.keep);
  const std::string job = folder.get_path() + "/shell";
  const Mesh mesh = build_half_shell(options.shell);
  write_file(job + ".inp", write_deck(mesh, options.shell, options.file.count + kRigidModes));
  run_calculix(options.ccx, folder.get_path(), "shell");
  return read_calculix(job + ".frd", job + ".dat");
}

// The table of all three models, and the same as JSON.
Json compare_models(std::FILE* to, const hil::Modes& modes, const HalfShell& s) {
  constexpr int kBeams = 3;
  const auto shallow = calc_arc_modes(ArcModel::kShallow, std::numbers::pi, kBeams, 181);
  const auto exact = calc_arc_modes(ArcModel::kInextensional, std::numbers::pi, kBeams, 181);
  const auto findings = match_beams(modes, s, exact);
  std::fprintf(to, "  mode  shell, Hz   about x = 0     beam  like it  (3.4), Hz         exact arc, Hz\n");
  Json list = Json::array();
  for (std::size_t k = 0; k < findings.size(); ++k) {
    const ShellModeFinding& finding = findings[k];
    const double hz = modes.frequencies_hz[static_cast<Eigen::Index>(k)];
    Json entry = {{"mode", k + 1}, {"hz", hz}, {"even", finding.even}, {"symmetry", finding.symmetry}};
    std::fprintf(to, "  %-4zu  %-10.5g  %-4s (%6.2f %%) ", k + 1, hz, finding.even ? "even" : "odd",
                 100 * finding.symmetry);
    if (finding.beam > 0) {
      const auto i = static_cast<std::size_t>(finding.beam) - 1;
      const double beam_hz = calc_arc_hz(shallow[i].omega, s.radius, s.thickness, s.young, s.density, s.poisson, false);
      const double arc_hz = calc_arc_hz(exact[i].omega, s.radius, s.thickness, s.young, s.density, s.poisson, true);
      entry["beam"] = {
          {"number", finding.beam}, {"mac", finding.likeness}, {"beam_3_4_hz", beam_hz}, {"exact_arc_hz", arc_hz}};
      std::fprintf(to, "  R%d    %.4f   %-8.4f (%+.2f %%)  %-8.4f (%+.2f %%)", finding.beam, finding.likeness, beam_hz,
                   100 * (hz / beam_hz - 1), arc_hz, 100 * (hz / arc_hz - 1));
    }
    std::fprintf(to, "\n");
    list.push_back(entry);
  }
  return list;
}

int run_shell(const ShellOptions& options) {
  const HalfShell& s = options.shell;
  if (s.cone > 0 && !(s.nose > 0 && s.nose < s.radius))
    refuse_option("--nose", "the cone ends at a radius between 0 and that of the cylinder");
  const MeshModes found = solve_shell(options);
  hil::Modes modes = build_export(found, s.thickness * s.density, options.file);
  char text[240];
  std::snprintf(
      text, sizeof text,
      "half shell: radius %g m, cylinder %g m, cone %g m to radius %g m, wall %g m; E %g N/m2, %g kg/m3, nu %g",
      s.radius, s.cylinder, s.cone, s.cone > 0 ? s.nose : s.radius, s.thickness, s.young, s.density, s.poisson);
  modes.source.emplace_back(text);
  std::snprintf(text, sizeof text, "mesh: S8R, %d around, %s in the cylinder, %d in the cone", s.around,
                count(s.cylinder_rows, "row").c_str(), s.cone > 0 ? s.cone_rows : 0);
  modes.source.emplace_back(text);
  std::FILE* const to = get_people_stream(options.json);
  for (const std::string& line : modes.source) std::fprintf(to, "%s\n", line.c_str());
  Json json = {{"schema", 1}, {"source", modes.source}, {"modes", compare_models(to, modes, s)}};
  if (!options.file.out.empty()) {
    hil::FlexibleReport report;
    const hil::FlexibleStructure body = build_body(modes, {}, options.file.out, report);
    write_file(options.file.out, hil::write_modes_text(modes));
    print_report(to, body, report, modes);
    json["body"] = build_json(body, report);
  }
  write_json(json, options.json);
  return kExitDone;
}

// --- The command line -----------------------------------------------------------------------------------------------

void add_arc(Command app, int& exit_code) {
  auto options = std::make_shared<ArcOptions>();
  Command command = app.add_verb(
      "arc", "Frequencies of a curved beam, free at both ends: Anshakov et al. (3.4), and the exact inextensional arc.",
      "unlatch modes arc --radius 2 --thickness 0.01");
  add_shell_options(command, options->shell);
  command.add_option("--angle", options->angle_deg, "angle of the arc, degrees").within(1.0, 359.0);
  command.add_option("--modes", options->count, "number of modes").within(1, 50);
  command.add_option("--points", options->points, "points of each shape in the JSON").within(3, 10001);
  command.add_json_option(options->json);
  command.callback([options, &exit_code] { exit_code = run_arc(*options); });
}

void add_shell(Command app, int& exit_code) {
  auto options = std::make_shared<ShellOptions>();
  HalfShell& shell = options->shell;
  Command command = app.add_verb(
      "shell",
      "Modes of a free half shell by finite elements (CalculiX), beside both beam models; --out writes a modes file.",
      "unlatch modes shell --cone 0\n"
      "unlatch modes shell --out fairing.modes --marker hinge=0,2,0");
  add_shell_options(command, shell);
  command.add_option("--cylinder", shell.cylinder, "height of the cylinder, m").positive();
  command.add_option("--cone", shell.cone, "height of the cone to its apex, m; 0: none").not_negative();
  command.add_option("--nose", shell.nose, "radius at which the cone is cut, m");
  command.add_option("--around", shell.around, "elements around the half circle").within(2, 200);
  command.add_option("--cylinder-rows", shell.cylinder_rows, "elements along the cylinder").within(1, 500);
  command.add_option("--cone-rows", shell.cone_rows, "elements along the cone").within(1, 500);
  command.add_option("--ccx", options->ccx, "CalculiX's program");
  command.add_option("--keep", options->keep, "folder that keeps CalculiX's files");
  command.add_option("--out", options->file.out, "modes file");
  add_export_options(command, options->file);
  command.add_json_option(options->json);
  command.callback([options, &exit_code] { exit_code = run_shell(*options); });
}

void add_modes_import(Command app, int& exit_code) {
  auto options = std::make_shared<ImportOptions>();
  Command command =
      app.add_verb("import", "Converts CalculiX's modes of a shell (.frd, and .dat for more digits) to a modes file.",
                   "unlatch modes import job.frd --dat job.dat --thickness 0.01 --density 4000 --out job.modes");
  command.add_option("frd", options->frd, "CalculiX's .frd file, written with *NODE FILE, OUTPUT=2D").required();
  command.add_option("--dat", options->dat, ".dat file of the same run");
  command
      .add_option("--units", options->units,
                  "of the .frd file: m (m, kg, s, N) or mm (mm, t, s, N); all other options are in m and kg")
      .one_of({"m", "mm"})
      .default_shown();
  command.add_option("--thickness", options->thickness, "wall thickness, m").required().positive();
  command.add_option("--density", options->density, "density, kg/m3").required().positive();
  command.add_option("--out", options->file.out, "modes file").required();
  add_export_options(command, options->file);
  command.add_json_option(options->json);
  command.callback([options, &exit_code] { exit_code = run_import(*options); });
}

void add_show(Command app, int& exit_code) {
  auto options = std::make_shared<ShowOptions>();
  Command command = app.add_verb(
      "show", "Prints the contents of a modes file, its conditioning, and the effect of a selection of modes.",
      "unlatch modes show fairing.modes --select 1,4,5");
  command.add_option("file", options->path, "modes file (hil/MODES.md)").required();
  command.add_option("--select", options->select, "numbers of modes (default: all)").delimiter(',');
  command.add_json_option(options->json);
  command.callback([options, &exit_code] { exit_code = run_show(*options); });
}

}  // namespace

void add_modes(Command app, int& exit_code) {
  Command command = app.add_verb(
      "modes", "Natural frequencies and shapes for flexible bodies: beam theory, finite elements, modes files.",
      "unlatch modes arc --radius 2 --thickness 0.01");
  command.require_verb();
  add_arc(command, exit_code);
  add_shell(command, exit_code);
  add_modes_import(command, exit_code);
  add_show(command, exit_code);
}

}  // namespace unlatch::tools
