// Which worker gets which samples, for a campaign on several processes: as many as it runs in half a second, or as its
// threads run side by side if that is more, and towards the end no more than it has threads. So slow workers get fewer,
// and none is waited for long. Who runs a sample changes nothing in its result.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <vector>

namespace unlatch::hil {

class Handout {
 public:
  static constexpr std::int64_t kMost = 256;  // samples that a worker has, or eight a thread if that is more; those of
                                              // a killed job are run again
  // Samples from `first` to before `last`, but those of `done`, which may name others too.
  Handout(std::int64_t first, std::int64_t last, const std::vector<std::int64_t>& done);
  // From now on to before `last`; nothing if that is not more than before.
  void extend(std::int64_t last);

  // A new worker, by any number, with its threads.
  void join(int worker, int threads);
  // Samples that it is to get now, if any; `now`: s, from any origin, never less than before.
  std::vector<std::int64_t> give(int worker, double now);
  // Its result has come. False: it has no such sample, or had it already.
  bool take(int worker, std::int64_t sample);
  // All have come.
  [[nodiscard]] bool is_finished() const { return missing_ == 0; }

 private:
  struct Worker {
    int threads = 1;
    std::set<std::int64_t> samples;  // given, not come
    std::int64_t came = 0;
    double begin = -1;  // s, of its first sample
  };
  [[nodiscard]] static double calc_rate(const Worker& worker, double now);  // samples a second
  [[nodiscard]] double calc_part(const Worker& worker, double now) const;   // 0 … 1
  [[nodiscard]] std::int64_t calc_share(const Worker& worker, double now) const;

  const std::int64_t first_;
  std::vector<bool> done_;        // from first_; before the campaign
  std::set<std::int64_t> later_;  // of those that `done` named, what lies beyond
  std::size_t next_ = 0;          // in done_
  std::int64_t not_given_ = 0;    // samples
  std::int64_t missing_ = 0;      // samples
  int threads_ = 0;               // of all workers
  std::map<int, Worker> workers_;
};

}  // namespace unlatch::hil
