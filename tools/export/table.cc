// A run as a tidy table: one row for each tick, one column for each number, written as CSV or as arrays of JSON.
#include <nlohmann/json.hpp>
#include <optional>

#include "hil/scenario/yaml/setting.h"
#include "tools/common/text.h"
#include "tools/export/sink.h"

namespace unlatch::tools {
namespace {

using Json = nlohmann::ordered_json;

struct Column {
  std::string name, unit;
  const char* type = "number";  // or integer, text
  bool may_miss = false;        // cells may be empty

  // With its unit.
  [[nodiscard]] std::string get_title() const { return name + (unit == "1" ? "" : " [" + unit + "]"); }
};

// The columns, and the cells of a row in the same order: tick, time, outputs, events. Cells of outputs that are not due
// are empty.
class Table {
 public:
  explicit Table(const Selection& selection) {
    columns_ = {{"tick", "1", "integer"}, {"t", "s"}};
    for (const std::size_t i : selection.outputs()) {
      const hil::Output& output = selection.reader().list()[i];
      for (const hil::Output::Column& column : output.columns)
        columns_.push_back({column.name, column.unit, is_text(output) ? "text" : "number", selection.has_gaps()});
    }
    columns_.push_back({"events", "1", "text"});
  }

  [[nodiscard]] const std::vector<Column>& columns() const { return columns_; }

  // Calls number(double), integer(…), text(…) or nothing() for each column.
  template <class Writer>
  void write(const Selection& selection, Writer& to) const {
    to.integer(selection.simulation().get_tick());
    to.number(selection.simulation().get_time());
    for (const std::size_t i : selection.outputs()) {
      const hil::Output& output = selection.reader().list()[i];
      for (std::size_t k = 0; k < output.columns.size(); ++k) {
        const double value = selection.values()[output.first + k];
        if (!selection.is_due(i))
          to.nothing();
        else if (is_text(output))
          to.text(selection.reader().get_mode_name(output, value));
        else
          to.number(value);
      }
    }
    std::string events;
    for (const hil::TimelineEntry& event : selection.events())
      events += (events.empty() ? "" : "; ") + event.name + (event.subject.empty() ? "" : " " + event.subject) +
                (event.shapes.empty() ? "" : " (" + event.shapes + ")");
    to.text(events);
  }

 private:
  static bool is_text(const hil::Output& output) { return output.kind == hil::Output::Kind::kMode; }

  std::vector<Column> columns_;
};

class CsvLine {
 public:
  void number(double value) { add(hil::to_text(value)); }
  void integer(std::int64_t value) { add(std::to_string(value)); }
  void text(const std::string& value) { add(quote_cell(value)); }
  void nothing() { add({}); }
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
  void nothing() { cells_.push_back(nullptr); }
  void put(std::FILE* file) {
    const std::string line = cells_.dump() + "\n";
    std::fwrite(line.data(), 1, line.size(), file);
  }

 private:
  Json cells_ = Json::array();
};

void put_head(const std::vector<Column>& columns, const hil::LogHeader&, std::FILE* file, CsvLine line) {
  for (const Column& column : columns) line.text(column.get_title());
  line.put(file);
}

void put_head(const std::vector<Column>& columns, const hil::LogHeader& header, std::FILE* file, const JsonLine&) {
  Json head = {{"scenario", header.scenario_name}, {"columns", Json::array()}};
  for (const Column& column : columns) {
    head["columns"].push_back(
        {{"name", column.get_title()}, {"unit", column.unit}, {"type", column.type}, {"optional", column.may_miss}});
  }
  const std::string line = head.dump() + "\n";
  std::fwrite(line.data(), 1, line.size(), file);
}

// A table of commas has no place for it.
void put_end(const ExportEnd&, std::FILE*, const CsvLine&) {}

void put_end(const ExportEnd& end, std::FILE* file, const JsonLine&) {
  const Json json = {{"status", end.status}, {"message", end.message}, {"hash", end.hash}};
  const std::string line = json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
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
  void end(const ExportEnd& end) override { put_end(end, file_, Line()); }

 private:
  std::FILE* file_;
  std::optional<Table> table_;
};

template <class Line>
void write_touches(const std::vector<hil::ContactRecord>& contacts, const hil::LogHeader& header, std::FILE* file) {
  const std::vector<Column> columns = {
      {"contact", "1", "text"}, {"shapes", "1", "text"}, {"t", "s"},      {"lift", "s", "number", true},
      {"duration", "s"},        {"peak_force", "N"},     {"peak_t", "s"}, {"depth", "m"},
      {"impulse", "N s"}};
  put_head(columns, header, file, Line());
  for (const hil::ContactRecord& contact : contacts)
    for (const hil::Touch& touch : contact.list) {
      Line line;
      line.text(contact.name);
      std::string shapes;
      for (const std::string& pair : touch.pairs) shapes += (shapes.empty() ? "" : "; ") + pair;
      line.text(shapes);
      line.number(touch.time);
      if (touch.lift)
        line.number(*touch.lift);
      else
        line.nothing();
      for (const double value : {touch.duration, touch.peak_force, touch.peak_time, touch.depth, touch.impulse})
        line.number(value);
      line.put(file);
    }
}

}  // namespace

void write_touches_as_csv(const std::vector<hil::ContactRecord>& contacts, std::FILE* file) {
  write_touches<CsvLine>(contacts, {}, file);
}

void write_touches_as_table(const std::vector<hil::ContactRecord>& contacts, const hil::LogHeader& header,
                            std::FILE* file) {
  write_touches<JsonLine>(contacts, header, file);
}

std::unique_ptr<Sink> build_csv_sink(std::FILE* file) { return std::make_unique<TableSink<CsvLine>>(file); }
std::unique_ptr<Sink> build_table_sink(std::FILE* file) { return std::make_unique<TableSink<JsonLine>>(file); }

}  // namespace unlatch::tools
