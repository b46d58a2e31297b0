// A foreign rank in a job of unlatch-mpi: it follows the protocol (tools/mpi/exchange.h) up to one message.
//   mpi_stranger MODE CAMPAIGN
#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>

#include <cstring>
#include <string>
#include <vector>

#include "hil/study/campaign/samples/runner.h"

namespace {

using namespace unlatch;

enum Tag { kHello, kWork, kRecord, kEnd, kBye };

MPI_Comm communicator;

void send(int tag, const void* bytes, std::size_t count) {
  MPI_Send(bytes, static_cast<int>(count), MPI_BYTE, 0, tag, communicator);
}

std::vector<hil::PlannedSample> receive_work(std::size_t inputs) {
  std::vector<char> bytes(100000);
  MPI_Status status;
  MPI_Recv(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, 0, MPI_ANY_TAG, communicator, &status);
  int count = 0;
  MPI_Get_count(&status, MPI_BYTE, &count);
  const std::size_t size = 8 + 8 * inputs;
  std::vector<hil::PlannedSample> samples(status.MPI_TAG == kWork ? static_cast<std::size_t>(count) / size : 0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    std::memcpy(&samples[i].sample, bytes.data() + i * size, 8);
    samples[i].inputs.resize(inputs);
    std::memcpy(samples[i].inputs.data(), bytes.data() + i * size + 8, 8 * inputs);
  }
  return samples;
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  const std::string mode = argc > 2 ? argv[1] : "";
  MPI_Comm_dup(MPI_COMM_WORLD, &communicator);
  int ranks = 1;
  MPI_Comm_size(communicator, &ranks);
  const int ready = -1;
  std::vector<int> others(static_cast<std::size_t>(ranks));
  MPI_Allgather(&ready, 1, MPI_INT, others.data(), 1, MPI_INT, communicator);
  if (others[0] != ready) return MPI_Finalize();

  const hil::Campaign campaign = hil::load_campaign(argv[2]);
  const hil::SampleEvaluator evaluator(*campaign.tree, campaign.chosen);
  const hil::ResultShape shape = get_shape(campaign, evaluator);
  struct {
    std::uint64_t fingerprint, program;
    std::uint32_t inputs, values, jobs, zero;
  } hello{shape.fingerprint, hil::calc_digest("unlatch " UNLATCH_VERSION), shape.inputs, shape.values, 1, 0};
  if (mode == "version") hello.program ^= 1;
  if (mode == "jobs") hello.jobs = 4000000000;
  const std::vector<char> large(1000000);
  if (mode == "size") send(kHello, large.data(), large.size());
  send(kHello, &hello, mode == "hello" ? sizeof hello - 1 : sizeof hello);
  if (mode == "twice") send(kHello, &hello, sizeof hello);
  if (mode == "kind") send(77, nullptr, 0);
  if (mode == "bye") {
    send(kBye, nullptr, 0);
    send(kHello, &hello, sizeof hello);
  }

  std::vector<char> bytes(hil::get_record_bytes(shape));
  const std::atomic<bool> never{false};
  while (true) {
    const std::vector<hil::PlannedSample> work = receive_work(shape.inputs);
    if (work.empty()) break;
    for (const hil::PlannedSample& sample : work) {
      hil::SampleRecord record = run_together(campaign, evaluator, {sample}, never).front();
      if (mode == "sample") record.sample = campaign.plan.samples + 5;
      if (mode == "inputs") record.inputs[0] += 1e-15;
      encode_record(shape, record, bytes);
      if (mode == "record") bytes[20] = static_cast<char>(bytes[20] ^ 1);
      send(kRecord, bytes.data(), mode == "short" ? bytes.size() - 8 : bytes.size());
      if (mode == "again") send(kRecord, bytes.data(), bytes.size());
    }
  }
  send(kBye, nullptr, 0);
  MPI_Finalize();
}
