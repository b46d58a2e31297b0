#include "library/c/errors.h"

#include <algorithm>
#include <filesystem>
#include <new>
#include <vector>

#include "hil/run/recording/log_file.h"
#include "hil/scenario/base/module.h"
#include "hil/scenario/language/scenario_sources.h"

namespace unlatch::library {
namespace {

struct StoredError {
  unlatch_status status = UNLATCH_OK;
  int line = 0, column = 0;
  std::string text, file, key;
};

struct ThreadErrors {
  std::vector<StoredError> stored;
  std::vector<unlatch_error> views;
  // True if there was no memory for the text of the error.
  bool bare = false;
  unlatch_error view{};

  void show() {
    bare = false;
    views.clear();
    for (const StoredError& error : stored) {
      views.push_back({sizeof(unlatch_error), error.status, error.line, error.column, error.text.c_str(),
                       error.file.c_str(), error.key.c_str()});
    }
  }
  void show_bare(unlatch_status status) noexcept {
    bare = true;
    view = {sizeof(unlatch_error), status, 0, 0, unlatch_get_status_text(status), "", ""};
  }
};

ThreadErrors& get_errors() noexcept {
  static thread_local ThreadErrors errors;
  return errors;
}

unlatch_status keep(std::vector<StoredError> stored) {
  ThreadErrors& errors = get_errors();
  const unlatch_status status = stored.front().status;
  errors.stored = std::move(stored);
  errors.show();
  return status;
}

// Search for the latest key or entry of a list at or before a place: the place belongs to it.
struct KeySearch {
  int line, column;
  std::string found;

  [[nodiscard]] bool is_reached(const hil::SourceMark& mark) const {
    return mark.line < line || (mark.line == line && mark.column <= column);
  }
  void walk(const hil::YamlNode& node, const std::string& path) {
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      const bool mapping = node.is_mapping();
      if (!is_reached(mapping ? node.keys[i].mark : node.items[i].mark)) return;
      const std::string name = mapping ? node.keys[i].text : std::to_string(i);
      const std::string below = path.empty() ? name : path + "." + name;
      found = below;
      walk(node.items[i], below);
    }
  }
};

// Text that contains the mistake: the main file's, or that of an included file.
std::string read_source(const std::string& file, const ErrorSource& source) {
  if (file == source.file && !source.text.empty()) return source.text;
  if (!source.text.empty()) return hil::ScenarioSources(source.text, "").read(file);
  const std::filesystem::path beside = std::filesystem::path(source.file).parent_path() / file;
  std::error_code error;
  return hil::read_text_file(std::filesystem::exists(file, error) ? file : beside.string(), "scenario");
}

StoredError describe(const hil::ScenarioMistake& mistake, const ErrorSource& source) {
  StoredError error{UNLATCH_ERROR_SCENARIO, mistake.mark.line, mistake.mark.column,
                    mistake.to_string(),    mistake.file,      ""};
  if (!mistake.override_text.empty()) {
    error.key = mistake.override_text.substr(0, mistake.override_text.find('='));
  } else if (mistake.mark.line > 0) {
    try {
      error.key = find_key(read_source(mistake.file, source), mistake.mark.line, mistake.mark.column);
    } catch (const std::exception&) {
      error.key.clear();  // a text that is not YAML has no keys
    }
  }
  return error;
}

}  // namespace

std::string find_key(const std::string& text, int line, int column) {
  KeySearch search{line, column, ""};
  search.walk(hil::parse_yaml(text), "");
  return search.found;
}

unlatch_status fail(unlatch_status status, std::string_view text, std::string_view file,
                    std::string_view key) noexcept {
  try {
    return keep({{status, 0, 0, std::string(text), std::string(file), std::string(key)}});
  } catch (...) {
    get_errors().show_bare(status);
    return status;
  }
}

unlatch_status fail(const hil::ScenarioError& error, const ErrorSource& source) noexcept {
  try {
    std::vector<StoredError> stored;
    for (const hil::ScenarioMistake& mistake : error.mistakes) stored.push_back(describe(mistake, source));
    if (stored.empty()) stored.push_back({UNLATCH_ERROR_SCENARIO, 0, 0, error.what(), source.file, ""});
    return keep(std::move(stored));
  } catch (...) {
    get_errors().show_bare(UNLATCH_ERROR_SCENARIO);
    return UNLATCH_ERROR_SCENARIO;
  }
}

unlatch_status fail(const Access& access) noexcept {
  return fail(access.get_status(), access.get_status() == UNLATCH_ERROR_BUSY
                                       ? "another thread is at work in this handle; one thread at a time may use it"
                                       : "a null, closed or foreign handle; pass one that unlatch_load() or "
                                         "unlatch_open_batch() gave and that is not closed");
}

unlatch_status fail_of_exception(const ErrorSource& source) noexcept {
  try {
    throw;
  } catch (const hil::ScenarioError& error) {
    return fail(error, source);
  } catch (const hil::LogError& error) {
    return fail(UNLATCH_ERROR_FILE, error.what(), source.file);
  } catch (const hil::ModuleError& error) {
    return fail(UNLATCH_ERROR_FILE, error.what());
  } catch (const std::bad_alloc&) {
    get_errors().show_bare(UNLATCH_ERROR_MEMORY);
    return UNLATCH_ERROR_MEMORY;
  } catch (const std::exception& error) {
    return fail(UNLATCH_ERROR_INTERNAL, error.what());
  } catch (...) {
    return fail(UNLATCH_ERROR_INTERNAL, "an exception of an unknown type");
  }
}

}  // namespace unlatch::library

using unlatch::library::get_errors;

const unlatch_error* unlatch_get_error(size_t index) {
  const unlatch::library::ThreadErrors& errors = get_errors();
  if (errors.bare) return index == 0 ? &errors.view : nullptr;
  return index < errors.views.size() ? &errors.views[index] : nullptr;
}

size_t unlatch_count_errors(void) { return get_errors().bare ? 1 : get_errors().views.size(); }

const char* unlatch_get_status_text(unlatch_status status) {
  switch (status) {
    case UNLATCH_OK:
      return "done";
    case UNLATCH_EVENT:
      return "events acted";
    case UNLATCH_END:
      return "end of the recording";
    case UNLATCH_INTERRUPTED:
      return "interrupted";
    case UNLATCH_ERROR_ARGUMENT:
      return "wrong argument";
    case UNLATCH_ERROR_HANDLE:
      return "null, closed or foreign handle";
    case UNLATCH_ERROR_BUSY:
      return "another thread is at work in this handle";
    case UNLATCH_ERROR_SCENARIO:
      return "mistakes in the scenario";
    case UNLATCH_ERROR_FILE:
      return "a file that cannot be used";
    case UNLATCH_ERROR_RANGE:
      return "out of range";
    case UNLATCH_ERROR_FAULT:
      return "the step cannot be made";
    case UNLATCH_ERROR_ORDER:
      return "not possible now";
    case UNLATCH_ERROR_STATE:
      return "no state of this model";
    case UNLATCH_ERROR_DIFFERENCE:
      return "the replay differs from the recording";
    case UNLATCH_ERROR_MEMORY:
      return "no memory, or no free handle";
    case UNLATCH_ERROR_INTERNAL:
      return "a defect of the library";
    default:
      return "unknown status";
  }
}

const char* unlatch_get_version(void) { return UNLATCH_VERSION; }
