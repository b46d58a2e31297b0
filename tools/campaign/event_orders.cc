#include "tools/campaign/event_orders.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace unlatch::tools {
namespace {

constexpr std::size_t kMostOrders = 20;

// An order of events as bytes: for each event the relation to the one before it, and its number in two bytes, by which
// orders sort as their texts do.
class EventOrders {
 public:
  explicit EventOrders(const Json& columns) {
    for (std::size_t k = 0; k < columns.size(); ++k) {
      if (columns[k].at("kind") != "event") continue;
      if (events_.empty()) first_ = k;
      events_.push_back({columns[k].at("name").get<std::string>().substr(6), k - first_});
    }
    count_ = events_.empty() ? 0 : events_.back().column + 1;
    std::ranges::stable_sort(events_, {}, &Event::name);
  }

  // The columns that encode() takes.
  [[nodiscard]] std::size_t get_first() const { return first_; }
  [[nodiscard]] std::size_t get_count() const { return count_; }

  [[nodiscard]] std::string encode(const std::vector<double>& values) const {
    std::vector<std::pair<std::pair<double, std::size_t>, std::size_t>> came;  // time, column; number
    for (std::size_t number = 0; number < events_.size(); ++number)
      if (const double time = values[events_[number].column]; !std::isnan(time))
        came.emplace_back(std::pair(time, events_[number].column), number);
    std::ranges::sort(came);
    std::string code;
    for (std::size_t i = 0; i < came.size(); ++i) {
      const bool same = i > 0 && came[i].first.first == came[i - 1].first.first;
      code += i == 0 ? kFirst : same ? kSame : kLater;
      code += static_cast<char>(came[i].second >> 8);
      code += static_cast<char>(came[i].second & 0xff);
    }
    return code;
  }
  [[nodiscard]] std::string describe(const std::string& code) const {
    std::string text;
    for (std::size_t i = 0; i + 2 < code.size(); i += 3) {
      const auto get = [&](std::size_t k) { return std::size_t{static_cast<unsigned char>(code[i + k])}; };
      text += (code[i] == kFirst ? "" : code[i] == kSame ? " = " : " > ") + events_[get(1) << 8 | get(2)].name;
    }
    return text;
  }

 private:
  struct Event {
    std::string name;
    std::size_t column;  // from the first one of an event
  };
  static constexpr char kFirst = 0, kSame = 1, kLater = 2;
  std::vector<Event> events_;
  std::size_t first_ = 0, count_ = 0;
};

}  // namespace

Json list_orders(const CampaignData& data) {
  struct Class {
    std::int64_t samples = 0, first = 0;
  };
  const EventOrders orders(data.manifest.at("columns"));
  std::map<std::string, Class> classes;
  std::vector<double> values(orders.get_count());
  std::int64_t left_out = 0;
  for (std::size_t row = 0; row < data.rows; ++row) {
    if (data.get_status(row) != hil::SampleStatus::kDone) {  // an order that was cut off, or may be another
      ++left_out;
      continue;
    }
    data.table->read_numbers(data.get_place(row), data.table->shape().inputs + orders.get_first(), values);
    Class& own = classes[orders.encode(values)];
    if (own.samples++ == 0) own.first = data.get_sample(row);
  }
  std::vector<const std::pair<const std::string, Class>*> sorted;
  for (const auto& one : classes) sorted.push_back(&one);
  std::ranges::stable_sort(sorted, std::greater(), [](const auto* one) { return one->second.samples; });
  Json json = {{"count", sorted.size()}, {"left_out", left_out}, {"classes", Json::array()}};
  for (std::size_t i = 0; i < std::min(kMostOrders, sorted.size()); ++i)
    json["classes"].push_back({{"order", orders.describe(sorted[i]->first)},
                               {"samples", sorted[i]->second.samples},
                               {"first", sorted[i]->second.first}});
  return json;
}

}  // namespace unlatch::tools
