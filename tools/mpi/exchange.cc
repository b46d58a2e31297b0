#include "tools/mpi/exchange.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include "hil/study/campaign/samples/sample_pool.h"

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

// Program and version, which all ranks must share beside the shape.
std::uint64_t get_program() { return hil::calc_digest("unlatch " UNLATCH_VERSION); }

// Bytes of a sample in kWork: its number and its inputs.
std::size_t get_work_bytes(const hil::ResultShape& shape) { return 8 + 8 * std::size_t{shape.inputs}; }

// Longer than all other messages.
std::size_t get_longest_message(const hil::ResultShape& shape) {
  const std::size_t most = std::max<std::size_t>(hil::Handout::kMost, kMostJobs + 1);
  return std::max<std::size_t>({hil::get_record_bytes(shape), most * get_work_bytes(shape), 65536});
}

std::vector<char> write_work(const std::vector<hil::PlannedSample>& samples) {
  std::vector<char> bytes;
  const auto put = [&](const void* from, std::size_t count) {
    const auto* const begin = static_cast<const char*>(from);
    bytes.insert(bytes.end(), begin, begin + count);
  };
  for (const hil::PlannedSample& sample : samples) {
    put(&sample.sample, 8);
    put(sample.inputs.data(), 8 * sample.inputs.size());
  }
  return bytes;
}

[[noreturn]] void refuse(int rank, const std::string& what) {
  throw hil::ResultError("rank " + std::to_string(rank) + " " + what);
}

std::vector<char> to_bytes(const void* from, std::size_t count) {
  const auto* const begin = static_cast<const char*>(from);
  return {begin, begin + count};
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
        source_(task.campaign, task.first, task.last, results) {
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
      if (!ended && (task_.stop || left_ || source_.is_finished())) {
        for (int rank = 1; rank < ranks_; ++rank) mailbox_.send(rank, kEnd, {});  // those that left wait for it
        ended = true;
      }
      if (!ended) assign();
    }
    mailbox_.flush();
  }

 private:
  void join(int rank, int jobs) {
    source_.join(rank, jobs);
    joined_.insert(rank);
  }

  void assign() {
    const double now = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    for (const int rank : joined_) {
      const std::vector<hil::PlannedSample> samples = source_.assign(rank, now);
      if (samples.empty()) continue;
      if (rank == 0)
        pool_.add(samples);
      else
        mailbox_.send(rank, kWork, write_work(samples));
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
    try {
      source_.take(rank, record);
    } catch (const hil::ResultError& error) {
      refuse(rank, std::string("sent ") + error.what());
    }
    results_.append(record);
    finished_();
  }

  const CampaignTask& task_;
  hil::ResultFile& results_;
  const std::function<void()>& finished_;
  Mailbox mailbox_;
  hil::SamplePool pool_;
  hil::SampleSource source_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  int ranks_ = 1;
  std::set<int> present_;  // other ranks that have not said kBye
  std::set<int> joined_;   // ranks that run samples
  bool left_ = false;      // one of them said kBye
};

std::vector<hil::PlannedSample> read_work(const MpiMessage& message, const hil::ResultShape& shape) {
  const std::size_t size = get_work_bytes(shape);
  if (message.bytes.size() % size != 0) refuse(message.rank, "handed out what are no samples of the campaign");
  std::vector<hil::PlannedSample> samples(message.bytes.size() / size);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const char* const from = message.bytes.data() + i * size;
    std::memcpy(&samples[i].sample, from, 8);
    samples[i].inputs.resize(shape.inputs);
    std::memcpy(samples[i].inputs.data(), from + 8, size - 8);
  }
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
      if (message->tag == kWork && pool) pool->add(read_work(*message, shape));
      ended = ended || message->tag == kEnd;
    }
  }
  leave();
  mailbox.flush();
}

}  // namespace unlatch::tools
