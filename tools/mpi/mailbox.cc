#include "tools/mpi/mailbox.h"

#include <string>
#include <utility>

#include "hil/scenario/text/count.h"
#include "hil/study/campaign/samples/result_file.h"

namespace unlatch::tools {

void Mailbox::send(int rank, int tag, std::vector<char> bytes) {
  std::erase_if(sent_, [](Sent& sent) {
    int done = 0;
    MPI_Test(&sent.request, &done, MPI_STATUS_IGNORE);
    return done != 0;
  });
  Sent& sent = sent_.emplace_back();
  sent.bytes = std::move(bytes);
  MPI_Isend(sent.bytes.data(), static_cast<int>(sent.bytes.size()), MPI_BYTE, rank, tag, communicator_, &sent.request);
}

std::optional<MpiMessage> Mailbox::receive() {
  int there = 0, count = 0;
  MPI_Status status{};
  MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, communicator_, &there, &status);
  if (there == 0) return std::nullopt;
  MPI_Get_count(&status, MPI_BYTE, &count);
  if (count < 0 || static_cast<std::size_t>(count) > longest_)
    throw hil::ResultError("rank " + std::to_string(status.MPI_SOURCE) + " sent " + hil::count(count, "byte") +
                           "; the longest message has " + std::to_string(longest_));
  MpiMessage message{status.MPI_SOURCE, status.MPI_TAG, std::vector<char>(static_cast<std::size_t>(count))};
  MPI_Recv(message.bytes.data(), count, MPI_BYTE, message.rank, message.tag, communicator_, MPI_STATUS_IGNORE);
  return message;
}

void Mailbox::flush() {
  for (Sent& sent : sent_) MPI_Wait(&sent.request, MPI_STATUS_IGNORE);
  sent_.clear();
}

}  // namespace unlatch::tools
