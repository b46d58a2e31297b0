// Distribution of samples to workers, for a campaign on several processes. A worker gets as many samples as it runs in
// half a second, or as its threads run side by side if that is more; towards the end no more than it has threads. So
// slow workers get fewer, and the end of the campaign does not wait long for one of them. The worker of a sample does
// not influence its result.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <vector>

namespace unlatch::hil {

class Handout {
 public:
  static constexpr std::int64_t kMost = 256;  // samples of a worker, or eight for each thread if that is more; those of
                                              // a killed job are run again
  // Distributes the samples from `first` to before `last`, except those of `done`, which may name others too.
  Handout(std::int64_t first, std::int64_t last, const std::vector<std::int64_t>& done);
  // Extends the range to before `last`; does nothing if that is no increase.
  void extend(std::int64_t last);

  // Adds a worker, identified by any number, with its threads.
  void join(int worker, int threads);
  // Samples to run now, if any; `now`: s, from any origin, never less than before.
  std::vector<std::int64_t> assign(int worker, double now);
  // Notes a result. False: the worker has no such sample, or its result was noted before.
  bool take(int worker, std::int64_t sample);
  // True once all results are noted.
  [[nodiscard]] bool is_finished() const { return missing_ == 0; }

 private:
  struct Worker {
    int threads = 1;
    std::set<std::int64_t> samples;  // handed out, without a result
    std::int64_t came = 0;
    double begin = -1;  // s, beginning of its first sample
  };
  [[nodiscard]] static double calc_rate(const Worker& worker, double now);  // samples per second
  [[nodiscard]] double calc_part(const Worker& worker, double now) const;   // 0 … 1
  [[nodiscard]] std::int64_t calc_share(const Worker& worker, double now) const;

  const std::int64_t first_;
  std::vector<bool> done_;        // from first_; samples done before the campaign
  std::set<std::int64_t> later_;  // samples of `done` beyond the range
  std::size_t next_ = 0;          // index into done_
  std::int64_t not_given_ = 0;    // samples not handed out
  std::int64_t missing_ = 0;      // samples without a result
  int threads_ = 0;               // threads of all workers
  std::map<int, Worker> workers_;
};

}  // namespace unlatch::hil
