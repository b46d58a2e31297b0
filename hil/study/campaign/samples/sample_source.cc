#include "hil/study/campaign/samples/sample_source.h"

#include <cstring>
#include <string>

#include "hil/study/campaign/samples/rare_failure.h"

namespace unlatch::hil {
namespace {

bool are_same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), 8 * a.size()) == 0;
}

std::optional<SubsetSimulation> begin_subset(const Campaign& campaign, const ResultFile& results) {
  if (!campaign.failure) return std::nullopt;
  SubsetSimulation subset(make_subset_plan(*campaign.failure, campaign.plan));
  for (std::size_t i = 0; i < results.samples().size(); ++i)
    subset.note(results.samples()[i], calc_failure_margin(*campaign.failure, results.read(i)));
  return subset;
}

}  // namespace

SampleSource::SampleSource(const Campaign& campaign, std::int64_t first, std::int64_t last, const ResultFile& results)
    : campaign_(campaign),
      subset_(begin_subset(campaign, results)),
      handout_(first, subset_ ? subset_->get_end() : last, results.samples()) {}

std::vector<double> SampleSource::draw(std::int64_t sample) const {
  return subset_ ? calc_inputs(campaign_, subset_->calc_point(sample)) : draw_inputs(campaign_, sample);
}

std::vector<PlannedSample> SampleSource::assign(int worker, double now) {
  std::vector<PlannedSample> planned;
  for (const std::int64_t sample : handout_.assign(worker, now)) planned.push_back({sample, draw(sample)});
  return planned;
}

void SampleSource::take(int worker, const SampleRecord& record) {
  const std::string name = "sample " + std::to_string(record.sample);
  if (!handout_.take(worker, record.sample)) throw ResultError(name + ", which it was not given");
  if (!are_same_bits(record.inputs, draw(record.sample)))
    throw ResultError(name + " with other inputs than it was given");
  if (!subset_) return;
  subset_->note(record.sample, calc_failure_margin(*campaign_.failure, record));
  handout_.extend(subset_->get_end());
}

}  // namespace unlatch::hil
