// Module unlatch._native: the C library for Python. A thin layer: handles become objects, statuses exceptions, arrays
// NumPy views of the library's own memory, which keep the handle open. The interpreter's lock is released while the
// library works.
#include <pybind11/complex.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <complex>
#include <memory>
#include <string>
#include <vector>

#include "unlatch.h"

namespace py = pybind11;

namespace {

// Makes unlatch.Error or one of its kinds, from the package.
py::object make_exception(unlatch_status status) {
  const py::module_ errors = py::module_::import("unlatch.errors");
  py::list mistakes;
  for (std::size_t i = 0; i < unlatch_count_errors(); ++i) {
    const unlatch_error& error = *unlatch_get_error(i);
    mistakes.append(py::make_tuple(error.text, error.file, error.line, error.column, error.key));
  }
  return errors.attr("make")(status, mistakes);
}

[[noreturn]] void throw_error(unlatch_status status) {
  const py::object error = make_exception(status);
  PyErr_SetObject(py::type::of(error).ptr(), error.ptr());
  throw py::error_already_set();
}

unlatch_status check(unlatch_status status) {
  if (status < 0) throw_error(status);
  return status;
}

// Options with the texts that they refer to.
class Options {
 public:
  Options(std::vector<std::string> overrides, std::uint32_t flags, std::uint32_t event_capacity)
      : texts_(std::move(overrides)) {
    for (const std::string& text : texts_) pointers_.push_back(text.c_str());
    options_.size = sizeof options_;
    options_.overrides = pointers_.data();
    options_.override_count = pointers_.size();
    options_.flags = flags;
    options_.event_capacity = event_capacity;
  }
  [[nodiscard]] const unlatch_options* get() const { return &options_; }

 private:
  std::vector<std::string> texts_;
  std::vector<const char*> pointers_;
  unlatch_options options_{};
};

// Handle that closes itself. Views hold a reference to it, so that their memory stays valid.
struct SimulationHandle {
  unlatch_simulation* pointer = nullptr;
  ~SimulationHandle() {
    if (pointer != nullptr) unlatch_close(pointer);
  }
};
struct BatchHandle {
  unlatch_batch* pointer = nullptr;
  ~BatchHandle() {
    if (pointer != nullptr) unlatch_close_batch(pointer);
  }
};

// Read-only view of numbers whose memory `owner` holds.
template <class Handle>
py::array view(const unlatch_array& array, const std::shared_ptr<Handle>& owner) {
  const auto type = array.type == UNLATCH_INT64 ? py::dtype::of<std::int64_t>() : py::dtype::of<double>();
  const py::capsule base(new std::shared_ptr<Handle>(owner),
                         [](void* kept) { delete static_cast<std::shared_ptr<Handle>*>(kept); });
  std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(array.rows)}, strides{array.row_stride};
  if (array.columns != 1) {
    shape.push_back(static_cast<py::ssize_t>(array.columns));
    strides.push_back(array.column_stride);
  }
  py::array made(type, shape, strides, array.data, base);
  made.attr("flags").attr("writeable") = false;
  return made;
}

py::tuple to_tuple(const unlatch_item& item) {
  return py::make_tuple(item.name, item.unit, item.text, item.first, item.width, item.a, item.b, item.initial,
                        item.minimum, item.maximum, item.safe);
}

class Simulation {
 public:
  explicit Simulation(unlatch_simulation* pointer) : handle_(std::make_shared<SimulationHandle>()) {
    handle_->pointer = pointer;
  }

  unlatch_simulation* get() const {
    if (!handle_) throw_error(unlatch_step(nullptr));  // closed
    return handle_->pointer;
  }
  // Closes the handle. Memory that views refer to is freed with the last of them.
  void close() {
    const std::shared_ptr<SimulationHandle> closing = std::move(handle_);
    if (!closing) return;
    const unlatch_status status = unlatch_stop_recording(closing->pointer);
    if (status != UNLATCH_ERROR_ORDER) check(status);  // nothing is being recorded
  }
  bool is_closed() const { return !handle_; }

  void step() {
    unlatch_simulation* const sim = get();
    unlatch_status status;
    {
      const py::gil_scoped_release released;
      status = unlatch_step(sim);
    }
    if (status != UNLATCH_OK) end(status);
  }
  py::tuple advance(std::uint64_t ticks, bool stop_at_events) {
    unlatch_simulation* const sim = get();
    std::uint64_t done = 0;
    unlatch_status status;
    {
      const py::gil_scoped_release released;
      status = unlatch_advance(sim, ticks, stop_at_events ? UNLATCH_STOP_AT_EVENTS : 0, &done);
    }
    return py::make_tuple(check(status), done);
  }
  void set_channel(std::size_t channel, double value) { check(unlatch_set_channel(get(), channel, value)); }

  std::vector<py::tuple> list(std::int32_t kind) const {
    std::size_t count = 0;
    check(unlatch_count(get(), kind, &count));
    std::vector<py::tuple> items;
    for (std::size_t i = 0; i < count; ++i) {
      unlatch_item item{};
      item.size = sizeof item;
      check(unlatch_describe(get(), kind, i, &item));
      items.push_back(to_tuple(item));
    }
    return items;
  }
  std::string get_mode_name(std::size_t joint, std::size_t mode) const {
    const char* name = "";
    check(unlatch_get_mode_name(get(), joint, mode, &name));
    return name;
  }
  py::tuple get_scenario() const {
    const char* name = "";
    double dt = 0, until = 0;
    check(unlatch_get_scenario(get(), &name, &dt, &until));
    return py::make_tuple(name, dt, until);
  }
  std::int64_t get_tick() const {
    std::int64_t tick = 0;
    check(unlatch_get_tick(get(), &tick));
    return tick;
  }
  double get_time() const {
    double time = 0;
    check(unlatch_get_time(get(), &time));
    return time;
  }
  std::uint64_t get_hash() const {
    std::uint64_t hash = 0;
    check(unlatch_get_hash(get(), &hash));
    return hash;
  }
  py::array get_array(std::int32_t which, std::size_t index) const {
    unlatch_array array{};
    array.size = sizeof array;
    check(unlatch_get_array(get(), which, index, &array));
    return view(array, handle_);
  }
  // Returns [(time, tick, event)], lost.
  py::tuple get_events(std::size_t from) const {
    const unlatch_event* events = nullptr;
    std::size_t count = 0;
    std::uint64_t lost = 0;
    check(unlatch_get_events(get(), &events, &count, &lost));
    py::list list;
    for (std::size_t i = from; i < count; ++i)
      list.append(py::make_tuple(events[i].time, events[i].tick, events[i].event));
    return py::make_tuple(list, lost);
  }
  py::list judge() const {
    const unlatch_verdict* verdicts = nullptr;
    std::size_t count = 0;
    check(unlatch_judge(get(), &verdicts, &count));
    const unlatch_certainty* certainties = nullptr;
    check(unlatch_get_certainties(get(), &certainties, &count));
    py::list list;
    for (std::size_t i = 0; i < count; ++i) {
      const unlatch_verdict& v = verdicts[i];
      list.append(py::make_tuple(v.evaluated != 0, v.met != 0, v.value, v.limit, v.margin, v.time, v.why,
                                 certainties[i].uncertainty, certainties[i].at_ticks != 0));
    }
    return list;
  }
  py::list get_findings() const {
    const unlatch_finding* findings = nullptr;
    std::size_t count = 0;
    check(unlatch_get_findings(get(), &findings, &count));
    py::list list;
    for (std::size_t i = 0; i < count; ++i) {
      const unlatch_finding& f = findings[i];
      list.append(py::make_tuple(f.name, f.subject, f.text, f.of_run != 0, f.unresolved != 0, f.time, f.worst_time));
    }
    return list;
  }
  // Of the model of linearize().
  std::vector<std::complex<double>> list_poles() const {
    const unlatch_linear_response* response = nullptr;
    check(unlatch_get_linear_response(get(), &response));
    std::vector<std::complex<double>> poles;
    for (std::size_t i = 0; i < response->pole_count; ++i)
      poles.emplace_back(response->poles[2 * i], response->poles[2 * i + 1]);
    return poles;
  }
  std::vector<double> list_poles_error() const {
    const unlatch_linear_response* response = nullptr;
    check(unlatch_get_linear_response(get(), &response));
    return {response->poles_error, response->poles_error + response->pole_count};
  }
  py::array_t<double> copy_gains(std::size_t rows, std::size_t columns, bool errors) const {
    const unlatch_linear_response* response = nullptr;
    check(unlatch_get_linear_response(get(), &response));
    py::array_t<double> out({rows, columns});
    std::copy_n(errors ? response->gains_error : response->gains, rows * columns, out.mutable_data());
    return out;
  }
  py::tuple linearize() const {
    const unlatch_linear_model* m = nullptr;
    check(unlatch_linearize(get(), &m));
    const auto copy = [](const double* from, std::size_t rows, std::size_t columns) {
      py::array_t<double> out({rows, columns});
      std::copy_n(from, rows * columns, out.mutable_data());
      return out;
    };
    const auto list = [](const char* const* texts, std::size_t count) {
      return std::vector<std::string>(texts, texts + count);
    };
    const std::size_t n = m->state_count, inputs = m->input_count, outputs = m->output_count;
    return py::make_tuple(m->time, list(m->states, n), list(m->state_units, n), list(m->inputs, inputs),
                          list(m->input_units, inputs), list(m->outputs, outputs), list(m->output_units, outputs),
                          copy(m->a, n, n), copy(m->b, n, inputs), copy(m->c, outputs, n), copy(m->d, outputs, inputs),
                          copy(m->a_error, n, n), copy(m->b_error, n, inputs), copy(m->c_error, outputs, n),
                          copy(m->d_error, outputs, inputs), list_poles(), copy_gains(outputs, inputs, false),
                          copy_gains(outputs, inputs, true), list_poles_error());
  }
  py::tuple calc_margins(const std::string& loop, double period, double delay) const {
    unlatch_loop_margins m;
    check(unlatch_calc_margins(get(), loop.c_str(), period, delay, &m));
    return py::make_tuple(m.stable != 0, m.gain, m.gain_frequency, m.drop, m.drop_frequency, m.phase, m.phase_frequency,
                          m.delay, m.delay_frequency);
  }
  py::bytes save() const {
    std::size_t needed = 0;
    check(unlatch_save(get(), nullptr, 0, &needed));
    std::string bytes(needed, '\0');
    check(unlatch_save(get(), bytes.data(), bytes.size(), &needed));
    return bytes;
  }
  void restore(const py::bytes& state) {
    const std::string bytes = state;
    check(unlatch_restore(get(), bytes.data(), bytes.size()));
  }
  void reset() { check(unlatch_reset(get())); }
  void start_recording(const std::string& path) { check(unlatch_start_recording(get(), path.c_str())); }
  void stop_recording() {
    unlatch_simulation* const sim = get();
    unlatch_status status;
    {
      const py::gil_scoped_release released;
      status = unlatch_stop_recording(sim);
    }
    check(status);
  }

 private:
  [[noreturn]] static void end(unlatch_status status) {
    if (status < 0) throw_error(status);
    throw py::stop_iteration("the recording is at its end");
  }

  std::shared_ptr<SimulationHandle> handle_;
};

class Batch {
 public:
  Batch(const std::string& path, std::vector<std::string> overrides, bool judge)
      : handle_(std::make_shared<BatchHandle>()) {
    const Options options(std::move(overrides), judge ? UNLATCH_JUDGE : 0, 0);
    check(unlatch_open_batch(path.c_str(), options.get(), &handle_->pointer));
  }
  unlatch_batch* get() const {
    if (!handle_) throw_error(unlatch_run_batch(nullptr, 0, 1));
    return handle_->pointer;
  }
  void close() { handle_.reset(); }
  // Adds a sample. Refused while views of the results exist: adding moves them.
  void add(const std::vector<std::string>& overrides) {
    if (handle_.use_count() > 1)
      throw py::buffer_error(
          "views of the batch's results are in use; copy them, or delete them, before adding samples");
    const Options options(overrides, 0, 0);
    check(unlatch_add_sample(get(), options.get()->overrides, overrides.size()));
  }
  // Runs the samples. A signal interrupts the run, and is handled then.
  bool run(double until, std::size_t threads) {
    unlatch_batch* const batch = get();
    unlatch_status status;
    {
      const py::gil_scoped_release released;
      status = unlatch_run_batch(batch, until, threads);
    }
    return check(status) == UNLATCH_OK;
  }
  void interrupt() const { (void)unlatch_interrupt(get()); }
  py::array get_array(std::int32_t which) const {
    unlatch_array array{};
    array.size = sizeof array;
    check(unlatch_get_batch_array(get(), which, &array));
    return view(array, handle_);
  }
  std::string get_text(std::size_t sample) const {
    const char* text = "";
    check(unlatch_get_sample_text(get(), sample, &text));
    return text;
  }
  std::vector<py::tuple> list(std::int32_t kind) const {
    std::size_t count = 0;
    check(unlatch_count_in_batch(get(), kind, &count));
    std::vector<py::tuple> items;
    for (std::size_t i = 0; i < count; ++i) {
      unlatch_item item{};
      item.size = sizeof item;
      check(unlatch_describe_in_batch(get(), kind, i, &item));
      items.push_back(to_tuple(item));
    }
    return items;
  }

 private:
  std::shared_ptr<BatchHandle> handle_;
};

template <class Load>
std::unique_ptr<Simulation> load(const Load& load_it) {
  unlatch_simulation* pointer = nullptr;
  check(load_it(&pointer));
  return std::make_unique<Simulation>(pointer);
}

}  // namespace

PYBIND11_MODULE(_native, module) {
  module.def("get_version", &unlatch_get_version);
  module.def("load", [](const std::string& path, const std::vector<std::string>& overrides, std::uint32_t flags,
                        std::uint32_t events) {
    const Options options(overrides, flags, events);
    return load([&](unlatch_simulation** to) { return unlatch_load(path.c_str(), options.get(), to); });
  });
  module.def("load_text", [](const std::string& text, const std::string& name,
                             const std::vector<std::string>& overrides, std::uint32_t flags, std::uint32_t events) {
    const Options options(overrides, flags, events);
    return load([&](unlatch_simulation** to) {
      return unlatch_load_text(text.data(), text.size(), name.c_str(), options.get(), to);
    });
  });
  module.def("open_recording", [](const std::string& path, std::uint32_t flags, std::uint32_t events) {
    const Options options({}, flags, events);
    return load([&](unlatch_simulation** to) { return unlatch_open_recording(path.c_str(), options.get(), to); });
  });
  py::class_<Simulation>(module, "Simulation")
      .def("close", &Simulation::close)
      .def("is_closed", &Simulation::is_closed)
      .def("step", &Simulation::step)
      .def("advance", &Simulation::advance)
      .def("set_channel", &Simulation::set_channel)
      .def("list", &Simulation::list)
      .def("get_mode_name", &Simulation::get_mode_name)
      .def("get_scenario", &Simulation::get_scenario)
      .def("get_tick", &Simulation::get_tick)
      .def("get_time", &Simulation::get_time)
      .def("get_hash", &Simulation::get_hash)
      .def("get_array", &Simulation::get_array)
      .def("get_events", &Simulation::get_events)
      .def("judge", &Simulation::judge)
      .def("get_findings", &Simulation::get_findings)
      .def("linearize", &Simulation::linearize)
      .def("calc_margins", &Simulation::calc_margins)
      .def("save", &Simulation::save)
      .def("restore", &Simulation::restore)
      .def("reset", &Simulation::reset)
      .def("start_recording", &Simulation::start_recording)
      .def("stop_recording", &Simulation::stop_recording);
  py::class_<Batch>(module, "Batch")
      .def(py::init<const std::string&, std::vector<std::string>, bool>())
      .def("close", &Batch::close)
      .def("add", &Batch::add)
      .def("run", &Batch::run)
      .def("interrupt", &Batch::interrupt)
      .def("get_array", &Batch::get_array)
      .def("get_text", &Batch::get_text)
      .def("list", &Batch::list);
}
