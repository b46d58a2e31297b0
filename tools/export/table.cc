// A run as a table: one row for each tick, one column for each number, written as CSV or as arrays of JSON.
#include <array>
#include <charconv>
#include <nlohmann/json.hpp>

#include "tools/export/sink.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

struct Column {
  std::string name, unit;
  const char* type = "number";  // or integer, text
};

// The columns, and the cells of a tick in the same order.
class Table {
 public:
  explicit Table(const Selection& selection) {
    const Model& model = selection.scenario().model;
    columns_ = {{"tick", "1", "integer"}, {"t", "s"}};
    for (const std::size_t body : selection.bodies()) {
      add_body(model.bodies[body].name);
      for (std::size_t k = 1; k <= selection.get_modal(body).size(); ++k) {
        columns_.push_back({model.bodies[body].name + ".modal" + std::to_string(k), "kg^0.5 m"});
      }
    }
    for (const Joint& joint : model.joints) add_joint(joint.name);
    for (const hil::ClearancePair& pair : selection.scenario().clearance)
      columns_.push_back({"clearance." + pair.a.name + "." + pair.b.name, "m"});
    for (const Channel& channel : model.channels) columns_.push_back({"channel." + channel.name, channel.unit});
    columns_.push_back({"events", "1", "text"});
  }

  [[nodiscard]] const std::vector<Column>& columns() const { return columns_; }

  // Calls number(double), integer(…) or text(…) for each column.
  template <class Writer>
  void write(const Selection& selection, Writer& to) const {
    const hil::Simulation& simulation = selection.simulation();
    to.integer(simulation.get_tick());
    to.number(simulation.get_time());
    for (const std::size_t i : selection.bodies()) {
      const unlatch::BodyState& body = simulation.state().bodies[i];
      for (const double value : {body.p.x, body.p.y, body.p.z, body.q.w, body.q.x, body.q.y, body.q.z, body.v.x,
                                 body.v.y, body.v.z, body.w.x, body.w.y, body.w.z}) {
        to.number(value);
      }
      for (const double value : selection.get_modal(i)) to.number(value);
    }
    for (std::size_t i = 0; i < selection.scenario().model.joints.size(); ++i) {
      to.text(selection.get_mode(i).name);
      for (std::size_t row = 0; row < kRows; ++row) to.number(simulation.workspace().multipliers[i * kRows + row]);
    }
    for (const hil::Clearance& clearance : selection.clearances()) to.number(clearance.now);
    for (const double value : simulation.channels()) to.number(value);
    std::string events;
    for (const hil::TimelineEntry& event : selection.events()) {
      events += (events.empty() ? "" : "; ") + event.name + (event.subject.empty() ? "" : " " + event.subject);
    }
    to.text(events);
  }

 private:
  static std::string get_body(const Model& model, int body) {
    return model.bodies[static_cast<std::size_t>(body)].name;
  }

  void add_body(const std::string& name) {
    for (const char* axis : {"x", "y", "z"}) columns_.push_back({name + "." + axis, "m"});
    for (const char* axis : {"qw", "qx", "qy", "qz"}) columns_.push_back({name + "." + axis, "1"});
    for (const char* axis : {"vx", "vy", "vz"}) columns_.push_back({name + "." + axis, "m/s"});
    for (const char* axis : {"wx", "wy", "wz"}) columns_.push_back({name + "." + axis, "rad/s"});
  }
  void add_joint(const std::string& name) {
    columns_.push_back({name + ".mode", "1", "text"});
    for (int row = 0; row < kRows; ++row) {
      columns_.push_back({name + "." + kRowNames[row], has_row(kPointRows, row) ? "N" : "N m"});
    }
  }

  std::vector<Column> columns_;
};

// The shortest text that is read back as the same number.
std::string to_text(double value) {
  std::array<char, 32> text;
  const auto result = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), result.ptr};
}

std::string quote(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

class CsvLine {
 public:
  void number(double value) { add(to_text(value)); }
  void integer(std::int64_t value) { add(std::to_string(value)); }
  void text(const std::string& value) { add(quote(value)); }
  void put(std::FILE* file) {
    line_ += "\r\n";
    std::fwrite(line_.data(), 1, line_.size(), file);
  }

 private:
  void add(const std::string& cell) {
    if (!first_) line_ += ',';
    first_ = false;
    line_ += cell;
  }
  std::string line_;
  bool first_ = true;
};

class JsonLine {
 public:
  void number(double value) { cells_.push_back(value); }
  void integer(std::int64_t value) { cells_.push_back(value); }
  void text(const std::string& value) { cells_.push_back(value); }
  void put(std::FILE* file) {
    const std::string line = cells_.dump() + "\n";
    std::fwrite(line.data(), 1, line.size(), file);
  }

 private:
  Json cells_ = Json::array();
};

void put_head(const std::vector<Column>& columns, const hil::LogHeader&, std::FILE* file, CsvLine line) {
  for (const Column& column : columns) line.text(column.name + (column.unit == "1" ? "" : " [" + column.unit + "]"));
  line.put(file);
}

void put_head(const std::vector<Column>& columns, const hil::LogHeader& header, std::FILE* file, const JsonLine&) {
  Json head = {{"scenario", header.scenario_name}, {"columns", Json::array()}};
  for (const Column& column : columns) {
    head["columns"].push_back({{"name", column.name}, {"unit", column.unit}, {"type", column.type}});
  }
  const std::string line = head.dump() + "\n";
  std::fwrite(line.data(), 1, line.size(), file);
}

template <class Line>
class TableSink final : public Sink {
 public:
  explicit TableSink(std::FILE* file) : file_(file) {}
  void begin(const Selection& selection, const hil::LogHeader& header) override {
    table_.emplace(selection);
    put_head(table_->columns(), header, file_, Line());
  }
  void add_tick(const Selection& selection) override {
    Line line;
    table_->write(selection, line);
    line.put(file_);
  }
  void end(const ExportEnd&) override {}

 private:
  std::FILE* file_;
  std::optional<Table> table_;
};

}  // namespace

std::unique_ptr<Sink> build_csv_sink(std::FILE* file) { return std::make_unique<TableSink<CsvLine>>(file); }
std::unique_ptr<Sink> build_table_sink(std::FILE* file) { return std::make_unique<TableSink<JsonLine>>(file); }

}  // namespace unlatch::tools
