// Messages between the ranks of an MPI job: bytes with a tag, sent without waiting, received when they are there. Only
// the thread that initialised MPI may use it.
#pragma once

#include <cstddef>
#include <list>
#include <optional>
#include <vector>

// Open MPI's header without its old C++ interface.
#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>

namespace unlatch::tools {

struct MpiMessage {
  int rank = 0;  // sender
  int tag = 0;
  std::vector<char> bytes;
};

class Mailbox {
 public:
  // `longest`: bytes of a message; a longer one is refused.
  Mailbox(MPI_Comm communicator, std::size_t longest) : communicator_(communicator), longest_(longest) {}
  // The messages have been sent, or the job ends by MPI_Abort.
  ~Mailbox() = default;
  Mailbox(const Mailbox&) = delete;
  Mailbox& operator=(const Mailbox&) = delete;

  void send(int rank, int tag, std::vector<char> bytes);
  // The next message that has come. Throws hil::ResultError.
  std::optional<MpiMessage> receive();
  // Waits until all that was sent is with its receivers.
  void flush();

 private:
  struct Sent {
    std::vector<char> bytes;
    MPI_Request request = MPI_REQUEST_NULL;
  };

  const MPI_Comm communicator_;
  const std::size_t longest_;
  std::list<Sent> sent_;  // their bytes must stay until they are received
};

}  // namespace unlatch::tools
