// Destination of an export, one class for each format. Data are written as they arrive; memory does not grow with the
// run.
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "hil/run/motion/contact_history.h"
#include "hil/run/recording/log_format.h"
#include "tools/export/selection.h"

namespace unlatch::tools {

// End of the run, for formats that record it.
struct ExportEnd {
  std::string status, message;
  std::string hash;  // of the last state
};

class Sink {
 public:
  virtual ~Sink() = default;
  Sink(const Sink&) = delete;
  Sink& operator=(const Sink&) = delete;
  virtual void begin(const Selection& selection, const hil::LogHeader& header) = 0;
  virtual void add_tick(const Selection& selection) = 0;
  // The touches of a contact, after the last tick. Tables have a row a tick: theirs are a table of their own, below.
  virtual void add_contact(const hil::ContactRecord&) {}
  virtual void end(const ExportEnd& end) = 0;

 protected:
  Sink() = default;
};

// RFC 4180: a header with units, one row per tick.
std::unique_ptr<Sink> build_csv_sink(std::FILE* file);
// The same table as JSON: an object with the columns, then an array a tick. For the Parquet writer.
std::unique_ptr<Sink> build_table_sink(std::FILE* file);
// The touches of all contacts, one row each: contact, shapes, times, duration, peak force, depth, impulse. As CSV, or
// as JSON for the Parquet writer.
void write_touches_as_csv(const std::vector<hil::ContactRecord>& contacts, std::FILE* file);
void write_touches_as_table(const std::vector<hil::ContactRecord>& contacts, const hil::LogHeader& header,
                            std::FILE* file);
// An object a line: the run, ticks and events, its end. For programs, and for the MCAP writer.
std::unique_ptr<Sink> build_json_sink(std::FILE* file);

}  // namespace unlatch::tools
