#include "tools/mpi/exchange.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include "hil/campaign/handout.h"
#include "hil/campaign/sample_pool.h"

namespace unlatch::tools {
namespace {

enum Tag { kHello, kWork, kRecord, kEnd, kBye };

struct Hello {
  std::uint64_t fingerprint, program;
  std::uint32_t inputs, values, jobs, zero;
};

constexpr auto kTurn = std::chrono::milliseconds(1);  // longest wait of a turn; MPI itself would wait at full load
constexpr int kMostMessages = 1000;                   // of a turn
constexpr std::uint32_t kMostJobs = 1024;             // of a rank, as the command line takes

// What all ranks must have in common beside the shape.
std::uint64_t get_program() { return hil::calc_digest("unlatch " UNLATCH_VERSION); }

// Longer than all other messages.
std::size_t get_longest_message(const hil::ResultShape& shape) {
  return std::max<std::size_t>(hil::get_record_bytes(shape), 65536);
}

[[noreturn]] void refuse(int rank, const std::string& what) {
  throw hil::ResultError("rank " + std::to_string(rank) + " " + what);
}

std::vector<char> to_bytes(const void* from, std::size_t count) {
  const auto* const begin = static_cast<const char*>(from);
  return {begin, begin + count};
}

bool are_same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), 8 * a.size()) == 0;
}

class Leader {
 public:
  Leader(MPI_Comm communicator, const CampaignTask& task, hil::ResultFile& results,
         const std::function<void()>& finished)
      : task_(task),
        results_(results),
        finished_(finished),
        mailbox_(communicator, get_longest_message(results.shape())),
        pool_(task.campaign, task.evaluator, task.jobs),
        handout_(task.first, task.last, results.samples()) {
    MPI_Comm_size(communicator, &ranks_);
    for (int rank = 1; rank < ranks_; ++rank) present_.insert(rank);
    join(0, task.jobs);
  }

  void run() {
    bool ended = false;
    while (!ended || !present_.empty()) {
      for (const hil::SampleRecord& record : pool_.take(kTurn)) take(0, record);
      for (int i = 0; i < kMostMessages; ++i) {
        const auto message = mailbox_.receive();
        if (!message) break;
        handle(*message);
      }
      if (!ended && (task_.stop || left_ || handout_.is_finished())) {
        for (int rank = 1; rank < ranks_; ++rank) mailbox_.send(rank, kEnd, {});  // those that left wait for it
        ended = true;
      }
      if (!ended) give();
    }
    mailbox_.flush();
  }

 private:
  void join(int rank, int jobs) {
    handout_.join(rank, jobs);
    joined_.insert(rank);
  }

  void give() {
    const double now = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    for (const int rank : joined_) {
      const std::vector<std::int64_t> samples = handout_.give(rank, now);
      if (samples.empty()) continue;
      if (rank == 0)
        pool_.add(samples);
      else
        mailbox_.send(rank, kWork, to_bytes(samples.data(), 8 * samples.size()));
    }
  }

  void handle(const MpiMessage& message) {
    if (!present_.contains(message.rank)) refuse(message.rank, "sent a message after its last one");
    if (message.tag == kHello) {
      greet(message);
    } else if (message.tag == kRecord) {
      const auto record = hil::decode_record(results_.shape(), message.bytes);
      if (!record) refuse(message.rank, "sent bytes that are no record of a sample");
      take(message.rank, *record);
    } else if (message.tag == kBye && message.bytes.empty()) {
      present_.erase(message.rank);
      joined_.erase(message.rank);
      left_ = true;
    } else {
      refuse(message.rank, "sent a message of no known kind");
    }
  }

  void greet(const MpiMessage& message) {
    Hello hello{};
    if (message.bytes.size() != sizeof hello || joined_.contains(message.rank))
      refuse(message.rank, "began with a message of no known kind");
    std::memcpy(&hello, message.bytes.data(), sizeof hello);
    if (hello.program != get_program()) refuse(message.rank, "is another version of unlatch-mpi than rank 0");
    if (!(results_.shape() == hil::ResultShape{hello.fingerprint, hello.inputs, hello.values}))
      refuse(message.rank, "reads another campaign or scenario than rank 0; all ranks need the same files");
    if (hello.jobs < 1 || hello.jobs > kMostJobs) refuse(message.rank, "has no possible number of threads");
    join(message.rank, static_cast<int>(hello.jobs));
  }

  void take(int rank, const hil::SampleRecord& record) {
    const std::string name = "sample " + std::to_string(record.sample);
    if (!handout_.take(rank, record.sample)) refuse(rank, "sent " + name + ", which it was not given");
    if (rank != 0 && !are_same_bits(record.inputs, draw_inputs(task_.campaign, record.sample)))
      refuse(rank, "drew other inputs for " + name + " than rank 0; all ranks need the same files and program");
    results_.append(record);
    finished_();
  }

  const CampaignTask& task_;
  hil::ResultFile& results_;
  const std::function<void()>& finished_;
  Mailbox mailbox_;
  hil::SamplePool pool_;
  hil::Handout handout_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  int ranks_ = 1;
  std::set<int> present_;  // other ranks that have not said kBye
  std::set<int> joined_;   // ranks that run samples
  bool left_ = false;      // one of them said kBye
};

std::vector<std::int64_t> read_work(const MpiMessage& message, const CampaignTask& task) {
  std::vector<std::int64_t> samples(message.bytes.size() / 8);
  std::memcpy(samples.data(), message.bytes.data(), 8 * samples.size());
  const auto fits = [&](std::int64_t sample) { return sample >= task.first && sample < task.last; };
  if (message.bytes.size() % 8 != 0 || !std::all_of(samples.begin(), samples.end(), fits))
    refuse(message.rank, "handed out what are no samples of the campaign");
  return samples;
}

}  // namespace

void lead_campaign(MPI_Comm communicator, const CampaignTask& task, hil::ResultFile& results,
                   const std::function<void()>& finished) {
  Leader(communicator, task, results, finished).run();
}

void follow_campaign(MPI_Comm communicator, const CampaignTask& task) {
  const hil::ResultShape shape = get_shape(task.campaign, task.evaluator);
  Mailbox mailbox(communicator, get_longest_message(shape));
  const Hello hello{
      shape.fingerprint, get_program(), shape.inputs, shape.values, static_cast<std::uint32_t>(task.jobs), 0};
  mailbox.send(0, kHello, to_bytes(&hello, sizeof hello));
  std::optional<hil::SamplePool> pool(std::in_place, task.campaign, task.evaluator, task.jobs);
  const auto leave = [&] {
    if (!pool) return;
    pool.reset();
    mailbox.send(0, kBye, {});
  };
  for (bool ended = false; !ended;) {
    if (task.stop) leave();
    if (!pool) std::this_thread::sleep_for(kTurn);
    for (const hil::SampleRecord& record : pool ? pool->take(kTurn) : std::vector<hil::SampleRecord>{}) {
      std::vector<char> bytes(hil::get_record_bytes(shape));
      encode_record(shape, record, bytes);
      mailbox.send(0, kRecord, std::move(bytes));
    }
    while (const auto message = mailbox.receive()) {
      if (message->rank != 0 || (message->tag != kWork && message->tag != kEnd))
        refuse(message->rank, "sent a message of no known kind");
      if (message->tag == kWork && pool) pool->add(read_work(*message, task));
      ended = ended || message->tag == kEnd;
    }
  }
  leave();
  mailbox.flush();
}

}  // namespace unlatch::tools
