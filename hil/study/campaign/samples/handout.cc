#include "hil/study/campaign/samples/handout.h"

#include <algorithm>
#include <cmath>

#include "hil/study/evaluation/evaluation.h"

namespace unlatch::hil {
namespace {

constexpr double kAhead = 0.5;                                      // s of work that a worker has ahead
constexpr std::int64_t kSideBySide = SampleEvaluator::kSideBySide;  // samples that a thread runs together

}  // namespace

Handout::Handout(std::int64_t first, std::int64_t last, const std::vector<std::int64_t>& done)
    : first_(first), done_(static_cast<std::size_t>(std::max<std::int64_t>(0, last - first)), false) {
  for (const std::int64_t sample : done) {
    if (sample >= last)
      later_.insert(sample);
    else if (sample >= first)
      done_[static_cast<std::size_t>(sample - first)] = true;
  }
  missing_ = not_given_ = std::count(done_.begin(), done_.end(), false);
}

void Handout::extend(std::int64_t last) {
  for (auto next = first_ + static_cast<std::int64_t>(done_.size()); next < last; ++next) {
    done_.push_back(later_.erase(next) != 0);
    if (done_.back()) continue;
    ++missing_;
    ++not_given_;
  }
}

void Handout::join(int worker, int threads) {
  workers_[worker].threads = threads;
  threads_ += threads;
}

double Handout::calc_rate(const Worker& worker, double now) {
  const double time = now - worker.begin;
  return worker.begin < 0 || time <= 0 ? 0 : static_cast<double>(worker.came) / time;
}

// Worker's part of the total rate: from the samples run so far, or from the numbers of threads while some workers have
// run nothing.
double Handout::calc_part(const Worker& worker, double now) const {
  double all = 0;
  for (const auto& [number, other] : workers_) {
    const double rate = calc_rate(other, now);
    if (rate == 0) return static_cast<double>(worker.threads) / threads_;
    all += rate;
  }
  return calc_rate(worker, now) / all;
}

// Number of samples that the worker should hold.
std::int64_t Handout::calc_share(const Worker& worker, double now) const {
  const double ahead = std::min(kAhead * calc_rate(worker, now), static_cast<double>(kMost));
  const std::int64_t wanted = std::max<std::int64_t>(worker.threads * kSideBySide, std::lround(ahead));
  const std::int64_t fair = std::lround(0.5 * static_cast<double>(not_given_) * calc_part(worker, now));
  return std::min(wanted, std::max<std::int64_t>(worker.threads, fair));
}

std::vector<std::int64_t> Handout::assign(int worker, double now) {
  Worker& to = workers_.at(worker);
  std::int64_t count = std::min(calc_share(to, now) - static_cast<std::int64_t>(to.samples.size()), not_given_);
  std::vector<std::int64_t> samples;
  for (; count > 0; ++next_) {
    if (done_[next_]) continue;
    samples.push_back(first_ + static_cast<std::int64_t>(next_));
    --count;
  }
  to.samples.insert(samples.begin(), samples.end());
  not_given_ -= static_cast<std::int64_t>(samples.size());
  if (to.begin < 0 && !samples.empty()) to.begin = now;
  return samples;
}

bool Handout::take(int worker, std::int64_t sample) {
  const auto from = workers_.find(worker);
  if (from == workers_.end() || from->second.samples.erase(sample) == 0) return false;
  ++from->second.came;
  --missing_;
  return true;
}

}  // namespace unlatch::hil
